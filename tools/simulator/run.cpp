#include "simulator/run.h"

#include <fmt/format.h>

#include <vector>

namespace cansync_sim {
namespace {

/// Tells when a drive's state has changed.
class StateLog {
 public:
  StateLog(const Bench& bench, const RunSettings& settings)
      : bench_(bench), settings_(settings), states_(bench.drives().size()) {}

  void look() {
    if (!settings_.verbose || bench_.counters().syncs == looked_at_) return;
    looked_at_ = bench_.counters().syncs;
    for (std::size_t index = 0; index < states_.size(); ++index)
      look(*bench_.drives()[index], states_[index]);
  }

 private:
  struct State {
    bool activated = false;
    bool synchronized = false;
    std::uint16_t control_word = sim::control_bit::run;
    std::uint16_t fault = sim::fault_code::none;
  };

  template <class... Arguments>
  void tell(const sim::Drive& drive, fmt::format_string<Arguments...> format, Arguments&&... arguments) {
    settings_.remark(fmt::format("SYNC {}: drive {} ", looked_at_ - 1, drive.number().value()) +
                     fmt::format(format, std::forward<Arguments>(arguments)...));
  }

  void look(const sim::Drive& drive, State& before) {
    State now;
    now.activated = drive.slave().sync_activated();
    now.synchronized = (drive.status_word() & sim::status_bit::synchronized) != 0;
    now.control_word = drive.control_word();
    now.fault = drive.fault();
    if (now.activated && !before.activated) tell(drive, "was activated");
    if (now.synchronized && !before.synchronized) tell(drive, "is synchronized");
    if (!now.synchronized && before.synchronized) tell(drive, "is not synchronized any more");
    if (now.control_word != before.control_word) tell(drive, "has control word 0x{:04X}", now.control_word);
    if (now.fault != before.fault && now.fault == 0) tell(drive, "has no fault any more");
    if (now.fault != before.fault && now.fault != 0) tell(drive, "has fault {}", now.fault);
    before = now;
  }

  const Bench& bench_;
  const RunSettings& settings_;
  std::vector<State> states_;
  std::uint64_t looked_at_ = 0;
};

/// Tells when the interface is lost and when it is back.
class LinkLog {
 public:
  explicit LinkLog(const RunSettings& settings) : settings_(settings) {}

  /// True when the interface has just been lost.
  bool look(Link link) {
    if (link == link_) return false;
    const bool lost = link_ == Link::up;
    link_ = link;
    if (link == Link::up) {
      settings_.remark(settings_.interface + " is up; the drives are on the bus");
    } else {
      settings_.remark(fmt::format("{} {}; waiting for it. {}", settings_.interface,
                                   link == Link::down ? "is down" : "does not exist",
                                   remedy(link, settings_.interface)));
    }
    return lost;
  }

 private:
  const RunSettings& settings_;
  Link link_ = Link::up;
};

void send_due(Bench& bench, Port& port) {
  while (const auto frame = bench.next(port.now())) bench.sent(port.send(*frame));
}

}  // namespace

std::string remedy(Link link, const std::string& interface) {
  switch (link) {
    case Link::missing:
      return fmt::format(
          "`ip link` lists the interfaces; a virtual one: ip link add dev {0} type vcan && ip link set "
          "{0} up",
          interface);
    case Link::down:
      return fmt::format(
          "An adapter: ip link set {0} up type can bitrate 500000 (the line's bit rate); vcan: ip link set "
          "{0} up",
          interface);
    case Link::up:
      break;
  }
  return {};
}

void run(Bench& bench, Port& port, const RunSettings& settings) {
  StateLog states(bench, settings);
  LinkLog link(settings);
  do {
    if (link.look(port.link())) bench.link_lost();
    can::ReceivedFrame frame;
    // Answers go out after each frame: the slot of the first would be over when all have been read.
    while (port.receive(frame)) {
      bench.receive(frame, port.now());
      send_due(bench, port);
      states.look();
    }
    send_due(bench, port);
  } while (port.wait(bench.next_due()));
}

std::string summary(const Bench& bench, std::uint64_t dropped) {
  const BenchCounters& counters = bench.counters();
  return fmt::format(
      "{} drives, {} SYNC, {} frames received, {} sent, {} not sent, {} answers too late, {} error frames, "
      "{} frames lost by the kernel, {} foreign frames without room",
      bench.drives().size(), counters.syncs, counters.received, counters.sent, counters.not_sent,
      counters.too_late, counters.error_frames, dropped, counters.faults_missed);
}

}  // namespace cansync_sim
