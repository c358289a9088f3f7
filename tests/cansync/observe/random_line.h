#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "campaign/dice.h"
#include "cansync/observe/observer.h"
#include "cansync/sim/drive.h"
#include "cansync/sim/drive_faults.h"
#include "cansync/sim/master_node.h"
#include "sim/line.h"

/// Lines of a random master and random drives, and what stood on them.
namespace cansync::observe::support {

/// A line that can be recorded, again and again with the same course.
struct RandomLine {
  sim::MasterNodeSettings master;
  std::vector<sim::DriveSettings> drives;
  std::vector<sim::Fault> faults;
  std::uint64_t seed = 0;
  unsigned intervals = 0;
};

/// Everything that stood on a line, in the order of its start.
class Recording final : public sim::TraceSink {
 public:
  struct Entry {
    can::Time start{};
    can::Time end{};
    std::optional<can::Frame> frame;  ///< nothing: a SYNC edge
  };
  void frame(const sim::TracedFrame& traced) noexcept override {
    entries.push_back({traced.start, traced.end, traced.frame});
  }
  void sync(can::Time at) noexcept override { entries.push_back({at, at, std::nullopt}); }
  std::vector<Entry> entries;
};

/// What the recording is given as.
enum class Form : std::uint8_t { starts, ends, without_sync };

inline Duration whole_microseconds(Duration time) {
  return std::chrono::duration_cast<std::chrono::microseconds>(time);
}

/// Stamps are of whole microseconds, and rise, as in a log.
inline Observation observe_recording(const Recording& recording, Form form) {
  Observer observer({form == Form::starts ? Stamps::start : Stamps::end, std::nullopt});
  const auto stamp = [form](const Recording::Entry& entry) {
    return whole_microseconds(form == Form::starts ? entry.start : entry.end);
  };
  auto entries = recording.entries;
  std::stable_sort(entries.begin(), entries.end(),
                   [&](const auto& a, const auto& b) { return stamp(a) < stamp(b); });
  for (const Recording::Entry& entry : entries) {
    if (!entry.frame && form != Form::without_sync) observer.sync(stamp(entry));
    if (entry.frame) observer.frame(stamp(entry), *entry.frame);
  }
  return observer.finish();
}

/// Runs the line with this master in the place of its own.
inline Recording record(const RandomLine& line, const sim::MasterNodeSettings& master) {
  std::vector<std::unique_ptr<sim::Node>> nodes;
  nodes.push_back(std::make_unique<sim::MasterNode>(master));
  for (const sim::DriveSettings& drive : line.drives) nodes.push_back(std::make_unique<sim::Drive>(drive));
  Recording recording;
  sim::LineSettings settings;
  settings.bits_per_second = slot_times(line.master.master.bit_rate).bits_per_second;
  settings.seed = line.seed;
  settings.faults = line.faults;
  settings.protocol = &sim::drive_faults();
  settings.trace = &recording;
  settings.user_number = 31;
  sim::Line bus(settings, std::move(nodes));
  const can::Time until = slot_times(line.master.master.bit_rate).interval * line.intervals;
  can::ReceivedFrame received;
  while (bus.now() < until) {
    bus.wait_until(until);
    while (bus.receive(received)) {
    }
  }
  return recording;
}

/// A line by its number. `faulty`: frames are lost and destroyed, slaves fall silent.
RandomLine random_line(std::uint64_t seed, bool faulty);

}  // namespace cansync::observe::support
