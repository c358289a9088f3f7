// The whole simulated line in virtual time: the daemon's realtime loop, the bus with frames to the bit, and
// 32 drives, on one core. docs/performance.md has the figures and the command.
#include <benchmark/benchmark.h>

#include <chrono>
#include <memory>

#include "cansync/settings/timing.h"
#include "support/virtual_line.h"

namespace {

using namespace cansync;
using cansyncd::support::drives_for;
using cansyncd::support::line_settings;
using cansyncd::support::VirtualLine;

/// One iteration is a run of `kEdges` intervals with both reference telegrams, both actual value telegrams
/// and a parameter read in every one of them. "times_real_time" is bus time over CPU time.
void whole_line(benchmark::State& state) {
  constexpr std::uint64_t kEdges = 20'000;
  const auto rate = static_cast<BitRate>(state.range(0));
  const SlotTimes& times = slot_times(rate);
  std::uint64_t frames = 0;
  for (auto _ : state) {
    state.PauseTiming();
    const MasterSettings settings = line_settings(rate);
    VirtualLine line(settings, drives_for(settings));
    line.on_edge = [&](std::uint64_t edge) {
      line.give_references(static_cast<std::uint32_t>(edge * 50));
      static_cast<void>(
          line.exchange().requests.try_push(ParameterRequest{.id = edge + 1,
                                                             .slave = *SlaveNumber::from(edge % kSlaves),
                                                             .number = *ParameterNumber::from(301)}));
      cansyncd::Terminal terminal;
      while (line.exchange().terminals.try_pop(terminal)) {
      }
    };
    state.ResumeTiming();
    line.run(kEdges);
    frames += line.line().counters().frames;
  }
  const double intervals = static_cast<double>(state.iterations()) * static_cast<double>(kEdges);
  const double bus_seconds = intervals * std::chrono::duration<double>(times.interval).count();
  state.counters["times_real_time"] = benchmark::Counter(bus_seconds, benchmark::Counter::kIsRate);
  state.counters["us_per_interval"] =
      benchmark::Counter(intervals / 1e6, benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
  state.counters["frames_per_interval"] = static_cast<double>(frames) / intervals;
  state.SetLabel(std::to_string(times.bits_per_second / 1000) + " kbit/s, 32 drives");
}
BENCHMARK(whole_line)->Arg(3)->Arg(2)->Arg(1)->Arg(0)->Unit(benchmark::kMillisecond);

}  // namespace
