#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "daemon.h"
#include "gateway.h"
#include "program.h"
#include "row.h"
#include "support/kept_journal.h"

namespace given {

/// What the givers give.
constexpr std::uint8_t value_of(Giver giver) {
  return giver == Giver::first ? 1 : 2;
}
inline std::string whose(unsigned value) {
  if (value == 0) return "zero";
  if (value == value_of(Giver::first)) return "first";
  return value == value_of(Giver::second) ? "second" : "of the file";
}
/// Of something that has a value of the first, and another of the second.
inline std::string whose(unsigned of_first, unsigned of_second) {
  return of_first != 0 && of_second != 0 ? "both" : whose(of_first != 0 ? of_first : of_second);
}

/// Words for an answer: "done", "refused: read_only".
std::string word_of(gateway_ReplyCode code, gateway_RefusalCause cause);

/// Whether the first giver has what one writer alone can have, as the daemon tells everybody: an `Ownership`.
template <class Ownership>
std::string ownership_word(const Ownership& told) {
  if (gateway::dds::text(told.writer).empty()) return "nobody has it";
  if (told.strength == 1) return "has it";
  return gateway::dds::text(told.waiting_writer).empty() ? "another has it" : "waits";
}

/// How a daemon of a protocol is made, and what its file says of the bus.
struct ProtocolUnderTest {
  MakeDaemon make;
  std::string file;
  std::chrono::milliseconds settles{0};  ///< goes by after its start until it is as it stays
};

/// A row on the daemon of a protocol, with two programs.
class RowOn : public Row {
 public:
  void kill(Giver giver) override;
  void set_read_only(bool read_only) override { daemon_->set_read_only(read_only); }
  void reload() override { daemon_->reload(changed_); }
  void restart() override;
  void set_running(bool running) override;
  void take_bus_off() override { daemon_->bus().take_off(); }
  void bring_bus_back() override { daemon_->bus().bring_back(); }
  void set_listens_only() override { daemon_->bus().listens_only = true; }
  void set_full(bool full) override { daemon_->bus().full = full; }
  void keep_in_controller(bool keep) override;
  void run(std::chrono::milliseconds span) override;
  void let_it_be_seen() override;
  /// What has been answered since the last call, for what is given by requests.
  std::string told() override;
  std::string events() override;
  std::uint64_t unanswered() const override;

 protected:
  static constexpr std::size_t index(Giver giver) { return giver == Giver::first ? 0 : 1; }

  /// `file`: what it says more; `changed`: what the file says more that is read again.
  explicit RowOn(const ProtocolUnderTest& protocol, const std::string& file = {},
                 const std::string& changed = {});

  Program& program(Giver giver);
  Program& watcher();
  DisturbedBus& bus() { return daemon_->bus(); }

  /// An event that comes of what the row does to see something.
  virtual bool is_noise(const std::string& /*code*/) const { return false; }
  /// Every 10 ms: what the programs do again and again, and what other nodes do.
  virtual void each_step() {}
  /// Takes the answers that have come for the first giver: `collect_answers` of their topic.
  virtual void collect() {}
  template <class Reply>
  void collect_answers() {
    if (!programs_[0]) return;
    programs_[0]->take_answers<Reply>([&](const Reply& reply) {
      ++answers_[word_of(reply.code, reply.cause)];
      ++answered_;
    });
  }
  /// What of the daemon stood on the bus: `word` says whose a frame is; empty: of something else. A state's words
  /// stand there once each, a job's with their number.
  std::string frames(const std::function<std::string(const can::Frame&)>& word);

 private:
  void begin();

  const MakeDaemon make_;
  const std::string text_;
  const std::string changed_;
  cansyncd::KeptJournal journal_;
  std::size_t told_ = 0;  ///< entries of the journal
  std::unique_ptr<Daemon> daemon_;
  std::uint8_t starts_ = 0;
  std::array<std::unique_ptr<Program>, 2> programs_;
  std::uint8_t programs_so_far_ = 0;
  std::map<std::string, unsigned> answers_;  ///< to the first giver
  std::uint64_t answered_ = 0;               ///< likewise, since it began
  std::unique_ptr<Program> watcher_;
};

}  // namespace given
