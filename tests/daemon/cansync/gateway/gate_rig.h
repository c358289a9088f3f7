#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "cansync/master_rig.h"
#include "daemon/cansync/gateway/reference_gate.h"

namespace cansyncd {

/// The gate with a master behind it and nothing else: no DDS, no clock, no thread. Writers, their strengths
/// and the time are what the test says; one interval is 1 ms.
class GateRig : public ReferenceSurroundings {
 public:
  static constexpr DaemonIdentity kDaemon = {0x11, 0x22, 0x33};
  static constexpr std::int64_t kWallStart = 1'700'000'000'000'000'000;

  explicit GateRig(const Config& config = default_config())
      : line(line_settings()), gate(kDaemon, config, *this) {
    line.activate();
    wall_offset = static_cast<std::int64_t>(line.next_interval);
  }

  static Config default_config() {
    Config config;
    config.failsafe.reference_max_age = std::chrono::milliseconds(500);
    return config;
  }
  static cansync::MasterSettings line_settings() {
    cansync::MasterSettings settings = cansync::test::settings_for(2);
    settings.startup.status_period = cansync::Duration(0);
    return settings;
  }

  std::int64_t elapsed_ms() const { return static_cast<std::int64_t>(line.next_interval) - wall_offset; }
  std::int64_t wall() const { return kWallStart + elapsed_ms() * 1'000'000; }
  SteadyTime now() const { return SteadyTime{} + std::chrono::milliseconds(elapsed_ms()); }

  /// Values of `writer` for telegram 1, written now.
  ReferenceSample values(WriterHandle writer, std::uint32_t first, std::uint32_t intervals = 1) const {
    ReferenceSample sample;
    sample.writer = writer;
    sample.written = wall();
    sample.daemon = kDaemon;
    sample.update.value = {first};
    sample.update.valid_mask = 1;
    sample.update.release_intervals = intervals;
    return sample;
  }
  ReferenceSample last_of(WriterHandle writer) const {
    ReferenceSample sample;
    sample.writer = writer;
    sample.written = wall();
    sample.given_up = true;
    return sample;
  }
  void take(const ReferenceSample& sample) { gate.take(sample, wall(), now()); }

  /// Runs so many intervals; the first values on the bus in telegram 1.
  std::vector<unsigned> on_bus(unsigned intervals) {
    std::vector<unsigned> seen;
    for (unsigned i = 0; i < intervals; ++i) {
      line.step();
      for (const cansync::Telegram& telegram : line.sent) {
        const auto* reference = std::get_if<cansync::ReferenceTelegram>(&telegram);
        if (reference != nullptr && reference->channel == cansync::Channel::one && reference->words != 0)
          seen.push_back(reference->word[0]);
      }
      watch();
    }
    return seen;
  }
  std::size_t count_on_bus(unsigned intervals, unsigned value) {
    const auto seen = on_bus(intervals);
    return static_cast<std::size_t>(std::count(seen.begin(), seen.end(), value));
  }
  void watch() {
    gate.watch({line.master.release(cansync::Channel::one), line.master.release(cansync::Channel::two)},
               now());
    gate.set_mapping_number(line.master.mapping_number());
  }

  std::size_t told(std::string_view code) const {
    return static_cast<std::size_t>(std::count_if(events.begin(), events.end(),
                                                  [&](const EventText& e) { return e.code.word() == code; }));
  }
  std::string text(std::string_view code) const {
    const auto found =
        std::find_if(events.begin(), events.end(), [&](const EventText& e) { return e.code.word() == code; });
    return found != events.end() ? found->text : "";
  }
  /// Why values are held or stopped.
  std::string_view cause() const {
    return release_cause(line.master.release(cansync::Channel::one), gate.givers()[0].loss);
  }

  std::string hand_on(const Request& request) override {
    if (full) return "request queue full";
    if (const auto* update = std::get_if<cansync::ReferenceUpdate>(&request)) {
      const cansync::Refusal refusal = line.master.submit(*update);
      if (refusal != cansync::Refusal::none) refusals.push_back(refusal);
    } else if (const auto* stop = std::get_if<StopRelease>(&request)) {
      line.master.stop_release(stop->channel, stop->hold);
    }
    return {};
  }
  void tell(const EventText& event, SteadyTime /*now*/) override { events.push_back(event); }
  gateway::dds::WriterIdentity identify(WriterHandle writer) override {
    return {"writer " + std::to_string(writer), strength[writer]};
  }
  bool left(WriterHandle writer) override { return gone.count(writer) != 0; }

  cansync::test::MasterRig line;
  std::map<WriterHandle, std::int32_t> strength;
  std::set<WriterHandle> gone;  ///< have left or died
  bool full = false;            ///< no room for requests
  std::vector<EventText> events;
  std::vector<cansync::Refusal> refusals;
  std::int64_t wall_offset = 0;
  ReferenceGate gate;
};

}  // namespace cansyncd
