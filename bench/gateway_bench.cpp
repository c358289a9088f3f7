// The daemon without a simulated line: realtime loop, gateway and DDS on a bus whose slaves answer at once,
// so that what is measured is the daemon alone. Runs until SIGTERM.
//   gateway_bench CONFIGURATION
#include <csignal>
#include <cstdio>
#include <exception>

#include "bench/answering_bus.h"
#include "cansync/config/file.h"
#include "daemon/cansync/exchange.h"
#include "daemon/cansync/gateway/gateway.h"
#include "daemon/cansync/realtime/realtime_loop.h"
#include "dds/participant.h"
#include "rt/realtime_thread.h"
#include "rt/thread_stack.h"

namespace {

int run(const char* path) {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGTERM);
  sigaddset(&signals, SIGINT);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  rt::set_default_stack_size(std::size_t{512} * 1024);
  const cansyncd::ConfigFile file = cansyncd::load_config(path, {});
  if (!file.problems.empty()) {
    return std::fprintf(stderr, "%s", config::problems_text(file.problems).c_str()), 1;
  }
  const cansyncd::Config& config = file.config;

  bench::AnsweringBus bus;
  cansyncd::Exchange exchange(cansyncd::ExchangeSizes{});
  const gateway::dds::Participant participant(
      {.domain = config.dds.domain, .partition = config.dds.partition, .interface = "lo", .serves = true});
  cansyncd::Gateway gateway(config, exchange, participant);
  cansyncd::RealtimeLoop loop(config.master, cansyncd::LoopSettings{}, bus, exchange);
  rt::RealtimeSettings realtime;
  realtime.priority = config.realtime.priority;
  realtime.cpu = config.realtime.cpu;
  {
    rt::RealtimeThread thread(realtime, [&] { loop.run(); });
    gateway.start();
    int number = 0;
    sigwait(&signals, &number);
    loop.request_stop();
  }
  gateway.stop();
  return 0;
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 2) return std::fprintf(stderr, "usage: %s CONFIGURATION\n", argv[0]), 2;
  return run(argv[1]);
} catch (const std::exception& error) {
  return std::fprintf(stderr, "%s\n", error.what()), 1;
}
