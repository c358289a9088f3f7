#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "cli/watch/watched_parameters.h"

namespace cansync::cli {

/// Reads parameters in turn while something else is shown: one read at a time, so that other programs' jobs
/// never wait for more than one. Rounds are read by a thread of its own; every function is for one other
/// thread.
class ParameterTurns {
 public:
  /// `client` outlives the object; `timeout_ms` as of a request.
  ParameterTurns(client::Client& client, std::vector<WatchedSlave> slaves, std::uint32_t timeout_ms);
  /// Cancels the read that is open.
  ~ParameterTurns();
  ParameterTurns(const ParameterTurns&) = delete;
  ParameterTurns& operator=(const ParameterTurns&) = delete;

  /// Begins a round of all of them, unless the former one is not over yet.
  void begin_round();
  /// Waits until the round is over, `until`, or Ctrl-C.
  void await_round(std::chrono::steady_clock::time_point until);
  /// What is known now of a slave's parameters; empty: there are none.
  std::vector<WatchedParameter> of(unsigned slave);
  /// What went wrong with reads for the first time since it was right, in sentences.
  std::vector<std::string> take_problems();

 private:
  void run();
  /// False: the slave does not answer, and its others are left out of this round.
  bool read(WatchedSlave& slave, WatchedParameter& parameter);

  client::Client& client_;
  const std::uint32_t timeout_ms_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<WatchedSlave> slaves_;
  std::vector<std::string> problems_;
  bool reading_ = false;
  std::atomic<bool> stop_ = false;
  std::thread reader_;  // last: it uses all of them
};

}  // namespace cansync::cli
