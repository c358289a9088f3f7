// What the realtime thread must not do, held against the line with every fault at work.

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cansync/sim/drive_faults.h"
#include "rt/alloc_counter.h"
#include "scripted_node.h"
#include "sim/line.h"
#include "sim/trace_file.h"

namespace {

using namespace sim::test;
using sim::FaultKind;

// Answers reference values and commands that name it, and keeps no book of it.
class AnsweringNode final : public sim::Node {
 public:
  explicit AnsweringNode(unsigned number) : number_(static_cast<sim::NodeNumber>(number)) {}
  sim::NodeNumber node_number() const noexcept override { return number_; }
  bool accepts(const can::Frame& frame) const noexcept override {
    return frame.id == 0x100u + number_ || frame.id == 0x500u + number_;
  }
  void on_sync(can::Time) noexcept override {}
  std::optional<sim::Transmission> on_frame(const can::Frame& received, can::Time end) noexcept override {
    can::Frame answer = received;
    answer.id += (received.id & 0x780) == 0x100 ? 0x200 : 0x080;
    return sim::Transmission{answer, end + us(5)};
  }

 private:
  sim::NodeNumber number_;
};

std::vector<sim::Fault> every_fault() {
  std::vector<sim::Fault> faults;
  for (unsigned kind = 0; kind < sim::kFaultKinds; ++kind) {
    faults.push_back({.kind = static_cast<FaultKind>(kind), .probability = 0.05});
  }
  faults[static_cast<unsigned>(FaultKind::silent)].node = 3;
  faults[static_cast<unsigned>(FaultKind::late)].delay = us(20);
  faults[static_cast<unsigned>(FaultKind::inject)].frame = frame("7F0#00");
  return faults;
}

// Runs `intervals` intervals of 1 ms and returns what this thread has done meanwhile.
rt::ThreadCalls calls_of(sim::ClockKind clock, sim::TraceSink* trace, unsigned intervals) {
  std::vector<std::unique_ptr<sim::Node>> nodes;
  for (unsigned n = 0; n < 32; ++n) nodes.push_back(std::make_unique<AnsweringNode>(n));
  sim::Line line({.clock = clock, .faults = every_fault(), .protocol = &sim::drive_faults(), .trace = trace},
                 std::move(nodes));
  can::Frame reference = frame("100#0011223344556677");
  can::Frame command = frame("500#70010000");
  can::ReceivedFrame received;
  const can::Time start = line.now() + us(500);
  const auto before = rt::thread_calls();
  for (unsigned n = 0; n < intervals; ++n) {
    const can::Time edge = start + us(1000.0 * n);
    while (line.wait_until(edge) == can::Wake::frame) line.receive(received);
    line.sync_edge(edge);
    reference.id = 0x100 + n % 32;
    line.send(reference);
    command.id = 0x500 + n % 32;
    line.send(command);
    if (line.status().state == can::ControllerState::bus_off) line.reset();
  }
  const auto after = rt::thread_calls();
  EXPECT_GT(line.counters().frames, intervals);
  EXPECT_GT(line.counters().error_frames, 0u);
  return {after.allocations - before.allocations, after.locks - before.locks, after.writes - before.writes};
}

TEST(LineRules, NothingForbiddenInVirtualTime) {
  const auto calls = calls_of(sim::ClockKind::virtual_time, nullptr, 5000);
  EXPECT_EQ(calls.allocations, 0u);
  EXPECT_EQ(calls.locks, 0u);
  EXPECT_EQ(calls.writes, 0u);
}

TEST(LineRules, NothingForbiddenInRealTimeWithATraceInTheBackground) {
  const auto path =
      std::filesystem::temp_directory_path() / ("cansync_rules_" + std::to_string(::getpid()) + ".log");
  sim::TraceFile trace({.path = path, .background = true});
  const auto calls = calls_of(sim::ClockKind::real_time, &trace, 300);
  const auto summary = trace.close();
  std::filesystem::remove(path);
  EXPECT_EQ(calls.allocations, 0u);
  EXPECT_EQ(calls.locks, 0u);
  EXPECT_EQ(calls.writes, 0u);
  EXPECT_GT(summary.lines, 600u);
  EXPECT_EQ(summary.lost, 0u);
}

}  // namespace
