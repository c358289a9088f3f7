#pragma once

#include <cansync/client.h>

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "cli/base/session.h"
#include "dds/overview/desk_client.h"

namespace cansync::cli {

/// Says what a transfer waits for until its turn has come, and gives up after `--timeout`. Main thread only.
class TransferTurn {
 public:
  explicit TransferTurn(Session& session) : session_(session) {}

  /// Of a transfer that was just submitted.
  client::TransferJob begin(client::TransferJob job);
  /// The daemon has given a sign of it: once a second while it waits.
  void look(std::uint32_t done);
  /// It has ended: a transfer that was given up here did not end in time.
  void settle(client::TransferReply& reply) const;

 private:
  using Clock = std::chrono::steady_clock;
  void tell(const std::string& what);

  Session& session_;
  std::optional<client::TransferJob> job_;
  std::unique_ptr<gateway::dds::DeskClient> desk_;  ///< from the first time it waits
  Clock::time_point begun_;
  Clock::time_point told_;
  std::string waited_for_;  ///< what it was the last time; empty: its turn has come, or that is not known
  std::string told_job_;    ///< what was told, without how far it is
  bool given_up_ = false;
};

}  // namespace cansync::cli
