// What the realtime thread must not do, watched on a whole simulated line in real time.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "can/passing_bus.h"
#include "cansync/settings/timing.h"
#include "cansync/sim/drive.h"
#include "daemon/cansync/realtime/realtime_loop.h"
#include "daemon/loop/flight_tap.h"
#include "rt/alloc_counter.h"
#include "rt/realtime_thread.h"
#include "sim/line.h"

namespace {

using namespace cansyncd;
using std::chrono::milliseconds;

constexpr unsigned kDrives = 32;
/// Intervals watched: 1.5 s at 1 Mbit/s.
constexpr std::uint64_t kWatched = 1500;

cansync::SlaveNumber slave(unsigned n) {
  return *cansync::SlaveNumber::from(n);
}

cansync::MasterSettings master_settings() {
  cansync::MasterSettings settings;
  settings.process.maximum_slave = slave(kDrives - 1);
  for (unsigned i = 0; i < kDrives; ++i) settings.slaves[i].configured = true;
  return settings;
}

std::vector<std::unique_ptr<sim::Node>> drives() {
  std::vector<std::unique_ptr<sim::Node>> nodes;
  for (unsigned i = 0; i < kDrives; ++i) {
    sim::DriveSettings settings;
    settings.slave.number = slave(i);
    settings.lock_time = milliseconds(20);
    nodes.push_back(std::make_unique<sim::Drive>(settings));
  }
  return nodes;
}

/// Everything countable about the calling thread.
struct Account {
  rt::ThreadCalls calls;
  rusage usage{};
  std::uint64_t write_calls = 0;  ///< as the kernel counts them, however they were made
  std::uint64_t signals = 0;
};

/// Write system calls of this thread; nothing when the kernel does not count them.
std::optional<std::uint64_t> kernel_write_calls() {
  std::ifstream file("/proc/thread-self/io");
  std::string key;
  std::uint64_t value = 0;
  while (file >> key >> value) {
    if (key == "syscw:") return value;
  }
  return std::nullopt;
}

/// The simulated line, seen through a bus that takes the account of the thread that drives it: once the line
/// is in active operation and has settled, and again `kWatched` intervals later.
class WatchedLine final : public can::PassingBus, public sync_line::SyncWire {
 public:
  explicit WatchedLine(sim::Line& line) : PassingBus(line), line_(line) {}

  std::atomic<bool> active{false};  ///< set by the test's thread
  std::atomic<bool> finished{false};
  Account before;
  Account after;
  std::uint64_t edges = 0;

  void sync_edge(can::Time due) noexcept override {
    line_.sync_edge(due);
    if (!active.load(std::memory_order_relaxed) || finished.load(std::memory_order_relaxed)) return;
    if (edges++ == 0) before = take_account();
    if (edges == kWatched) {
      after = take_account();
      finished.store(true, std::memory_order_release);
    }
  }

 private:
  /// The kernel's count is read outside the span that is watched: reading it allocates.
  Account take_account() noexcept {
    Account account;
    if (edges > 1) account.calls = rt::thread_calls();
    if (edges > 1) getrusage(RUSAGE_THREAD, &account.usage);
    account.write_calls = kernel_write_calls().value_or(0);
    if (edges == 1) getrusage(RUSAGE_THREAD, &account.usage);
    if (edges == 1) account.calls = rt::thread_calls();
    return account;
  }

  sim::Line& line_;
};

/// Plays the gateway: keeps the line busy with every kind of request and reads everything back.
class BusyGateway {
 public:
  explicit BusyGateway(Exchange& exchange) : exchange_(exchange) {}

  std::uint64_t signals = 0;
  std::uint64_t answers = 0;
  std::uint64_t actual_values = 0;
  bool active = false;

  void work() {
    if (exchange_.gateway_wake.wait(milliseconds(2))) ++signals;
    Terminal terminal;
    while (exchange_.terminals.try_pop(terminal)) ++answers;
    Report report;
    while (exchange_.reports.try_pop(report)) {
    }
    for (auto& slot : exchange_.actual) {
      ActualReport actual;
      if (slot.read(actual)) ++actual_values;
    }
    MasterSnapshot snapshot;
    if (exchange_.master.read(snapshot)) active = snapshot.state == cansync::State::active_master;
    if (active) make_requests(snapshot);
  }

 private:
  void make_requests(const MasterSnapshot& snapshot) {
    for (const auto channel : {cansync::Channel::one, cansync::Channel::two}) {
      cansync::ReferenceUpdate update;
      update.channel = channel;
      update.value = {number_, number_, number_, number_};
      update.valid_mask = 0x0F;
      update.release_intervals = 20;
      exchange_.requests.try_push(update);
    }
    if (snapshot.open_parameter_jobs < 10) {
      cansync::ParameterRequest read;
      read.id = ++number_;
      read.slave = slave(number_ % kDrives);
      read.number = *cansync::ParameterNumber::from(301);
      exchange_.requests.try_push(read);
    }
    if (snapshot.open_transfers == 0) {
      cansync::TransferRequest upload;
      upload.id = ++number_;
      upload.slave = slave(number_ % kDrives);
      upload.address = 0x1000;
      upload.data = memory_;
      exchange_.requests.try_push(upload);
    }
    if (number_ % 7 == 0)
      exchange_.requests.try_push(cansync::ControlWordRequest{++number_, slave(3), 0x0007});
  }

  Exchange& exchange_;
  std::uint32_t number_ = 0;
  std::array<std::uint8_t, 600> memory_ = {};
};

TEST(RealtimeRules, TheRealtimeThreadNeitherAllocatesNorLocksNorWritesAnythingButItsWakeSignal) {
  sim::LineSettings line_settings;
  line_settings.clock = sim::ClockKind::real_time;
  sim::Line line(line_settings, drives());
  WatchedLine watched(line);
  const auto settings = master_settings();
  ExchangeSizes sizes;
  sizes.terminals = terminals_for(settings.command_channel, sizes.requests);
  Exchange exchange(sizes);
  // With the flight recorder, which works on this thread all the time.
  rt::FlightRecorder recorder(4096, 10);
  FlightTap tap(recorder, {});
  RecordedBus recorded(watched, tap);
  RealtimeLoop loop(settings, LoopSettings{.report_intervals = true, .tap = &tap, .sync_wire = &watched},
                    recorded, exchange);

  rt::RealtimeSettings wanted;
  wanted.enforce = false;
  wanted.hold_cpu_awake = false;
  rt::RealtimeThread thread(wanted, [&loop] { loop.run(); });

  BusyGateway gateway(exchange);
  const auto give_up = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  // This thread may be held up on a busy machine: it goes on until it has seen enough, which shows that the
  // line was at work.
  const auto enough = [&] {
    return watched.finished.load(std::memory_order_acquire) && gateway.actual_values > 500 &&
           gateway.answers > 100;
  };
  while (!enough() && std::chrono::steady_clock::now() < give_up) {
    gateway.work();
    if (gateway.answers > 20) watched.active = true;
  }
  loop.request_stop();
  thread.join();
  ASSERT_TRUE(watched.finished) << "the line was not active for " << kWatched << " intervals within 60 s";

  EXPECT_EQ(watched.after.calls.allocations, watched.before.calls.allocations);
  if (rt::counts_c_library()) {
    EXPECT_EQ(watched.after.calls.locks, watched.before.calls.locks);
    const auto signals = watched.after.calls.writes - watched.before.calls.writes;
    EXPECT_GE(signals, kWatched) << "the gateway is woken at least once an interval";
    if (kernel_write_calls()) {
      EXPECT_EQ(watched.after.write_calls - watched.before.write_calls, signals);
    }
  }
  const auto minor = watched.after.usage.ru_minflt - watched.before.usage.ru_minflt;
  const auto major = watched.after.usage.ru_majflt - watched.before.usage.ru_majflt;
  RecordProperty("minor_faults", static_cast<int>(minor));
  RecordProperty("major_faults", static_cast<int>(major));
  // What other threads of a higher priority take is not in this thread's hands: told, not judged.
  RecordProperty("involuntary_switches",
                 static_cast<int>(watched.after.usage.ru_nivcsw - watched.before.usage.ru_nivcsw));
  if (thread.grants().memory_locked && rt::counts_c_library()) {
    EXPECT_EQ(minor, 0);
    EXPECT_EQ(major, 0);
  }
  EXPECT_GT(gateway.actual_values, 500U) << "the line was at work";
  EXPECT_GT(gateway.answers, 100U) << "the line was at work";
}

}  // namespace
