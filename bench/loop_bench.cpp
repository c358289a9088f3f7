// The daemon's realtime loop in real time on the bus that a configuration names: how late it is at the SYNC
// edge, and how long from waking up until the interval's telegrams are handed over.
//   loop_bench CONFIGURATION SECONDS      prints one JSON object; times in us
#include <fmt/format.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <thread>

#include "bench/measured_bus.h"
#include "cansync/config/file.h"
#include "cansync/settings/timing.h"
#include "daemon/bus/bus_choice.h"
#include "daemon/cansync/bus/bus_plan.h"
#include "daemon/cansync/exchange.h"
#include "daemon/cansync/realtime/realtime_loop.h"
#include "daemon/loop/sync_line.h"
#include "rt/realtime_thread.h"
#include "sync/system.h"

namespace {

using namespace std::chrono_literals;

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

int run(const char* path, double seconds) {
  const cansyncd::ConfigFile file = cansyncd::load_config(path, {});
  if (!file.problems.empty()) {
    return std::fprintf(stderr, "%s", config::problems_text(file.problems).c_str()), 1;
  }
  const cansyncd::Config& config = file.config;
  cansyncd::BusChoice choice(cansyncd::bus_plan(config));
  cansyncd::SyncLine sync_line(config, cansync::slot_times(config.master.bit_rate).interval,
                               sync_line::kernel());
  bench::MeasuredBus bus(choice.bus(), choice.sync_wire());
  cansyncd::Exchange exchange(cansyncd::ExchangeSizes{});
  cansyncd::LoopSettings settings;
  settings.sync_wire = &bus;
  settings.sync_line = &sync_line;
  settings.look_at_every_slot = config.bus.kind == cansyncd::BusKind::simulated;
  cansyncd::RealtimeLoop loop(config.master, settings, bus, exchange);
  rt::RealtimeSettings realtime;
  realtime.priority = config.realtime.priority;
  realtime.cpu = config.realtime.cpu;
  {
    rt::RealtimeThread thread(realtime, [&] { loop.run(); });
    choice.start([&](const can::LinkFacts& facts) {
      exchange.link.write(facts);
      exchange.gateway_wake.signal();
    });
    play_gateway(exchange,
                 std::chrono::steady_clock::now() + std::chrono::duration_cast<std::chrono::nanoseconds>(
                                                        std::chrono::duration<double>(seconds)));
    loop.request_stop();
  }
  choice.stop();
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
  if (argc != 3) return std::fprintf(stderr, "usage: %s CONFIGURATION SECONDS\n", argv[0]), 2;
  return run(argv[1], std::atof(argv[2]));
} catch (const std::exception& error) {
  return std::fprintf(stderr, "%s\n", error.what()), 1;
}
