#include "simulator/master_bench.h"

#include <fmt/format.h>

#include <array>
#include <utility>

#include "cansync/settings/mode.h"
#include "sync/software_sync.h"
#include "text/counts.h"

namespace cansync_sim {

/// Says what the master finds out. Allocates when it has something to say, which a simulator may.
class MasterBench::News final : public cansync::MasterListener {
 public:
  explicit News(std::function<void(const std::string&)> tell) : tell_(std::move(tell)) {}

  void actual_values(cansync::SlaveNumber, const cansync::ActualValues&) noexcept override {}
  void slave_status(cansync::SlaveNumber slave, const cansync::SlaveStatus& status) noexcept override {
    const cansync::SlaveState before = std::exchange(states_[slave.value()], status.state);
    if (before != status.state) say("slave {}: {}", slave.value(), name(status.state));
  }
  void state_changed(cansync::State from, cansync::State to, cansync::ControlCommand) noexcept override {
    if (from != to) say("state: {}", name(to));
  }
  void parameter_done(cansync::JobId, const cansync::ParameterResult&) noexcept override {}
  void transfer_progress(cansync::JobId, std::uint32_t) noexcept override {}
  void transfer_done(cansync::JobId, const cansync::TransferResult&) noexcept override {}
  void command_done(cansync::JobId, cansync::Outcome) noexcept override {}
  void event(const cansync::MasterEvent&) noexcept override {}

 private:
  template <class... Arguments>
  void say(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
    if (tell_) tell_(fmt::format(format, std::forward<Arguments>(arguments)...));
  }

  std::function<void(const std::string&)> tell_;
  std::array<cansync::SlaveState, cansync::kSlaves> states_ = {};
};

MasterBench::MasterBench(const sim::MasterNodeSettings& settings, std::uint32_t sync_identifier,
                         std::function<void(const std::string&)> tell)
    : news_(std::make_unique<News>(std::move(tell))),
      node_(settings, news_.get()),
      sync_identifier_(sync_identifier) {}

MasterBench::~MasterBench() = default;

void MasterBench::receive(const can::ReceivedFrame& received, can::Time) noexcept {
  if (received.frame.error) {
    ++counters_.error_frames;
    return;
  }
  ++counters_.received;
  if (joined_ && node_.accepts(received.frame)) node_.on_frame(received.frame, received.end);
}

can::Time MasterBench::next_due() const noexcept {
  // At once, and the line begins.
  if (!joined_) return can::Time::min();
  return node_.next_time().value_or(can::Time::max());
}

std::optional<can::Frame> MasterBench::next(can::Time now) noexcept {
  if (!std::exchange(joined_, true)) node_.on_join(now);
  while (now >= next_due()) {
    const sim::Deed deed = node_.on_time(now);
    if (!deed.sync_edge && !deed.transmission) continue;
    given_ = deed.sync_edge ? sync_line::software_sync(sync_identifier_) : deed.transmission->frame;
    given_at_ = now;
    return given_;
  }
  return std::nullopt;
}

void MasterBench::sent(can::SendResult result) noexcept {
  if (result != can::SendResult::queued) {
    ++counters_.not_sent;
  } else if (sync_line::is_software_sync(given_, sync_identifier_)) {
    ++counters_.syncs;
  } else {
    ++counters_.sent;
    // A socket does not hear itself; every answer comes after this.
    node_.on_sent(given_, given_at_);
  }
}

std::string summary(const MasterBench& bench, std::uint64_t dropped) {
  const MasterBenchCounters& counters = bench.counters();
  return fmt::format(
      "master in state '{}', {} SYNC, {} received, {} sent, {} not sent, {} left out as too late, {}, {} "
      "lost by the kernel",
      name(bench.master().state()), counters.syncs, text::counted(counters.received, "frame"), counters.sent,
      counters.not_sent, bench.master().counters().left_out,
      text::counted(counters.error_frames, "error frame"), text::counted(dropped, "frame"));
}

}  // namespace cansync_sim
