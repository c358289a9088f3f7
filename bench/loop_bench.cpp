// The daemon's realtime loop in real time on a simulated line of 32 drives at 1 ms, on a realtime thread: how
// late it is at the SYNC edge, and how long from waking up until the interval's telegrams are handed over.
//   loop_bench SECONDS PRIORITY CPU      prints one JSON object; times in us
#include <fmt/format.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <thread>

#include "bench/measured_bus.h"
#include "daemon/exchange.h"
#include "daemon/realtime_loop.h"
#include "rt/realtime_thread.h"
#include "sim/line.h"
#include "support/virtual_line.h"

namespace {

using namespace std::chrono_literals;
using cansyncd::support::drives_for;
using cansyncd::support::line_settings;

/// Stands for the gateway: takes what comes, and gives both reference telegrams for the next intervals.
void play_gateway(cansyncd::Exchange& exchange, std::chrono::steady_clock::time_point end) {
  std::uint32_t value = 0;
  while (std::chrono::steady_clock::now() < end) {
    for (const auto channel : {cansync::Channel::one, cansync::Channel::two}) {
      cansync::ReferenceUpdate update;
      update.channel = channel;
      update.value = {value, value, value, value};
      update.valid_mask = 0x0F;
      update.release_intervals = 100;
      static_cast<void>(exchange.requests.try_push(update));
    }
    ++value;
    // A command in every interval, as far as the queue goes.
    for (unsigned i = 0; i < 20; ++i) {
      static_cast<void>(exchange.requests.try_push(
          cansync::ParameterRequest{.id = value * 32 + i,
                                    .slave = *cansync::SlaveNumber::from(i),
                                    .number = *cansync::ParameterNumber::from(301)}));
    }
    cansyncd::Terminal terminal;
    while (exchange.terminals.try_pop(terminal)) {
    }
    cansyncd::Report report;
    while (exchange.reports.try_pop(report)) {
    }
    exchange.gateway_wake.clear();
    std::this_thread::sleep_for(20ms);
  }
}

std::string quantiles(const bench::TimingHistogram& histogram) {
  return fmt::format(R"({{"count":{},"p50":{},"p90":{},"p99":{},"p99.9":{}}})", histogram.total(),
                     histogram.quantile(0.5), histogram.quantile(0.9), histogram.quantile(0.99),
                     histogram.quantile(0.999));
}

int run(double seconds, int priority, int cpu) {
  const cansync::MasterSettings settings = line_settings(cansync::BitRate::mbit1);
  sim::LineSettings line_options;
  line_options.bits_per_second = 1'000'000;
  line_options.clock = sim::ClockKind::real_time;
  sim::Line line(line_options, drives_for(settings));
  bench::MeasuredBus bus(line);
  cansyncd::Exchange exchange(cansyncd::ExchangeSizes{});
  cansyncd::RealtimeLoop loop(settings, cansyncd::LoopSettings{}, bus, exchange);
  rt::RealtimeSettings realtime;
  realtime.priority = priority;
  realtime.cpu = cpu;
  {
    rt::RealtimeThread thread(realtime, [&] { loop.run(); });
    play_gateway(exchange,
                 std::chrono::steady_clock::now() + std::chrono::duration_cast<std::chrono::nanoseconds>(
                                                        std::chrono::duration<double>(seconds)));
    loop.request_stop();
  }
  cansyncd::MasterSnapshot last;
  static_cast<void>(exchange.master.read(last));
  fmt::print(R"({{"late":{},"handed_over":{},"missed_syncs":{},"left_out":{}}})"
             "\n",
             quantiles(bus.lateness()), quantiles(bus.handed_over()), last.missed_syncs,
             last.counters.left_out);
  return 0;
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 4) return std::fprintf(stderr, "usage: %s SECONDS PRIORITY CPU\n", argv[0]), 2;
  return run(std::atof(argv[1]), std::atoi(argv[2]), std::atoi(argv[3]));
} catch (const std::exception& error) {
  return std::fprintf(stderr, "%s\n", error.what()), 1;
}
