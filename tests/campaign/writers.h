#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <string>
#include <vector>

#include "daemon/cansync/exchange.h"
#include "daemon/cansync/gateway/reference_gate.h"
#include "dice.h"
#include "plan.h"
#include "reference_truth.h"
#include "sim/line.h"
#include "tamper.h"

namespace cansyncd::campaign {

/// The programs that give reference values, and what DDS does between them and the gate: the last few samples of
/// each are kept while the gateway hangs, and a writer that died is noticed a lease later. Some of the programs
/// wrote to the daemon before and go on. Notes when the gate takes a telegram from a writer that keeps it.
class Writers final : private ReferenceSurroundings {
 public:
  /// All must outlive the object; `tamper` may be null.
  Writers(const Plan& plan, Exchange& exchange, sim::Line& line, ReferenceTruth& truth, Tamper* tamper);

  /// Told everything in words; empty: nobody wants to know.
  std::function<void(const std::string&)> on_event;

  /// One interval: programs live, write, give up and die.
  void live(std::uint64_t interval, std::uint64_t mapping_number);
  /// The faults are over: one program with everything new goes on alone.
  void settle_down(std::uint64_t interval, std::uint64_t mapping_number);
  /// The gateway looks at what has come. Not called while it hangs.
  void gateway(const MasterSnapshot& now);
  /// The master refused what was handed on last.
  void refused(const ReferenceRefused& report);

 private:
  static constexpr std::size_t kKept = 16;  ///< of a telegram of each, as the topic's QoS says

  struct Program {
    WriterHandle handle = 0;  ///< as DDS knows it; 0: not at all
    bool runs = false;
    std::uint64_t noticed_at = 0;  ///< its death, when it does not run
    std::int32_t strength = 0;
    bool of_daemon_before = false;  ///< it has not taken up its telegrams since
    std::uint64_t mapping_number = 1;
    std::array<bool, cansync::kChannels> holds = {};
  };
  struct Sample {
    ReferenceSample sample;
    unsigned program = 0;
    bool of_daemon_before = false;
  };

  void live_one(unsigned number, std::uint64_t interval, std::uint64_t mapping_number);
  void write(unsigned number, cansync::Channel channel, std::uint64_t interval, bool steady);
  void give_up(unsigned number, cansync::Channel channel);
  void send(Sample written, cansync::Channel channel);
  void deliver(const Sample& sample);
  const Program* of(WriterHandle writer) const noexcept;
  void judge(WriterHandle before, const Sample& sample);
  std::int64_t wall() noexcept { return line_.now().count(); }
  SteadyTime steady() noexcept { return SteadyTime(line_.now()); }

  // ReferenceSurroundings
  std::string hand_on(const Request& request) override;
  void tell(const EventText& event, SteadyTime now) override;
  gateway::dds::WriterIdentity identify(WriterHandle writer) override;
  bool left(WriterHandle writer) override;

  const Plan& plan_;
  Exchange& exchange_;
  sim::Line& line_;
  ReferenceTruth& truth_;
  Tamper* tamper_;
  Dice dice_;
  std::vector<Program> programs_;
  WriterHandle last_handle_ = 0;
  std::array<std::deque<Sample>, cansync::kChannels> samples_;  ///< not yet taken by the gateway
  std::vector<WriterHandle> dead_;                              ///< not yet told to it
  const Sample* current_ = nullptr;                             ///< that the gate is looking at
  bool handed_on_ = false;                                      ///< values of it
  ReferenceGate gate_;
};

}  // namespace cansyncd::campaign
