#include "cansync/sim/master_node.h"

#include <gtest/gtest.h>

#include <memory>
#include <utility>
#include <vector>

#include "cansync/sim/drive.h"
#include "cansync/sim/drive_faults.h"
#include "cansync/telegram/telegram.h"
#include "sim/line.h"

namespace sim {
namespace {

using cansync::BitRate;
using cansync::slot_times;
using std::chrono::milliseconds;

/// Notes edges and the start of every frame by its identifier.
class Trace final : public TraceSink {
 public:
  void frame(const TracedFrame& traced) noexcept override { frames.push_back(traced); }
  void sync(can::Time at) noexcept override { edges.push_back(at); }
  std::vector<TracedFrame> frames;
  std::vector<can::Time> edges;
};

struct Ended final : cansync::MasterListener {
  void actual_values(cansync::SlaveNumber, const cansync::ActualValues&) noexcept override { ++actual; }
  void slave_status(cansync::SlaveNumber, const cansync::SlaveStatus&) noexcept override {}
  void state_changed(cansync::State, cansync::State, cansync::ControlCommand) noexcept override {}
  void parameter_done(cansync::JobId, const cansync::ParameterResult& r) noexcept override {
    parameters.push_back(r);
  }
  void transfer_progress(cansync::JobId, std::uint32_t) noexcept override {}
  void transfer_done(cansync::JobId, const cansync::TransferResult&) noexcept override {}
  void command_done(cansync::JobId, cansync::Outcome) noexcept override {}
  void event(const cansync::MasterEvent&) noexcept override {}
  unsigned actual = 0;
  std::vector<cansync::ParameterResult> parameters;
};

/// A line whose master is a node: two drives, and a user that only looks on.
class MasterNodeTest : public ::testing::Test {
 protected:
  static MasterNodeSettings settings(BitRate rate) {
    MasterNodeSettings result;
    result.master.bit_rate = rate;
    result.master.send_margin = cansync::default_send_margin(rate);
    result.master.process.maximum_slave = *cansync::SlaveNumber::from(1);
    for (unsigned i = 0; i < 2; ++i) result.master.slaves[i].configured = true;
    result.references[0] = {ReferenceCurve::Kind::ramp, 1000, 7};
    result.references[1] = {ReferenceCurve::Kind::constant, -5};
    return result;
  }

  void build(const MasterNodeSettings& settings, std::vector<Fault> faults = {}) {
    rate_ = settings.master.bit_rate;
    std::vector<std::unique_ptr<Node>> nodes;
    auto master = std::make_unique<MasterNode>(settings, &told_);
    master_ = master.get();
    nodes.push_back(std::move(master));
    for (unsigned i = 0; i < 2; ++i) {
      DriveSettings drive;
      drive.slave.number = *cansync::SlaveNumber::from(i);
      drive.slave.bit_rate = rate_;
      drive.lock_time = milliseconds(50);
      drive.memory.size = 1024;
      auto node = std::make_unique<Drive>(drive);
      drives_[i] = node.get();
      nodes.push_back(std::move(node));
    }
    LineSettings line;
    line.bits_per_second = slot_times(rate_).bits_per_second;
    line.faults = std::move(faults);
    line.protocol = &drive_faults();
    line.trace = &trace_;
    line.user_number = 9;
    line_ = std::make_unique<Line>(line, std::move(nodes));
  }

  void run(unsigned intervals) {
    const can::Time until = line_->now() + slot_times(rate_).interval * static_cast<int>(intervals);
    can::ReceivedFrame received;
    while (line_->now() < until) {
      line_->wait_until(until);
      while (line_->receive(received)) ++heard_;
    }
  }

  BitRate rate_ = BitRate::mbit1;
  Ended told_;
  Trace trace_;
  MasterNode* master_ = nullptr;
  std::array<Drive*, 2> drives_ = {};
  std::unique_ptr<Line> line_;
  std::uint64_t heard_ = 0;
};

TEST_F(MasterNodeTest, StartsTheLineAndLetsTheDrivesFollowAtAllBitRates) {
  for (const cansync::SlotTimes& times : cansync::kSlotTimes) {
    trace_ = {};
    build(settings(times.bit_rate));
    run(2000);
    EXPECT_EQ(master_->master().state(), cansync::State::active_master);
    EXPECT_EQ(trace_.edges.size(), 2001u);
    for (std::size_t i = 1; i < trace_.edges.size(); ++i)
      ASSERT_EQ(trace_.edges[i] - trace_.edges[i - 1], times.interval);
    for (const Drive* drive : drives_) {
      EXPECT_TRUE((drive->status_word() & status_bit::synchronized) != 0);
      EXPECT_EQ(drive->missed_references(), 0u);
      EXPECT_EQ(drive->slave().references()[0], value_of({ReferenceCurve::Kind::ramp, 1000, 7}, 1999));
      EXPECT_EQ(drive->slave().references()[1], 0xFFFFFFFBu);
    }
    EXPECT_GT(told_.actual, 0u);
    EXPECT_EQ(master_->refused(), 0u);
  }
}

TEST_F(MasterNodeTest, NoMasterTelegramStartsAfterItsSlot) {
  build(settings(BitRate::mbit1));
  run(1000);
  std::size_t edge = 0;
  unsigned references = 0;
  for (const TracedFrame& traced : trace_.frames) {
    while (edge + 1 < trace_.edges.size() && trace_.edges[edge + 1] <= traced.start) ++edge;
    const can::Time since = traced.start - trace_.edges[edge];
    const std::uint32_t channel = cansync::identifier::channel_of(traced.frame.id);
    if (channel == 0x100) {
      EXPECT_EQ(traced.sender.kind, Sender::Kind::master);
      EXPECT_LE(since, std::chrono::microseconds(350));
      ++references;
    } else if (channel == 0x300) {
      EXPECT_EQ(traced.sender.kind, Sender::Kind::node);
      EXPECT_LE(since, std::chrono::microseconds(520));
    }
  }
  EXPECT_GT(references, 800u);
}

TEST_F(MasterNodeTest, TheUserSeesTheEdgesAndAllFrames) {
  build(settings(BitRate::mbit1));
  const auto all = [this] {
    std::vector<can::Time> edges;
    for (can::Time at{}; line_->take({}, at);) edges.push_back(at);
    return edges;
  };
  run(3);
  EXPECT_EQ(all(),
            (std::vector<can::Time>{milliseconds(0), milliseconds(1), milliseconds(2), milliseconds(3)}));
  run(100);
  const auto newest = all();
  ASSERT_EQ(newest.size(), Line::kEdgesKept) << "the newest are kept";
  EXPECT_EQ(newest.back(), milliseconds(103));
  EXPECT_GT(heard_, 150u);
}

TEST_F(MasterNodeTest, EdgesGoMissingByFaults) {
  Fault everywhere;
  everywhere.kind = FaultKind::missing_sync;
  everywhere.from = 500;
  everywhere.to = 501;
  Fault at_user = everywhere;
  at_user.node = NodeNumber{9};
  at_user.from = at_user.to = 503;
  build(settings(BitRate::mbit1), {everywhere, at_user});
  run(500);
  for (can::Time at{}; line_->take({}, at);) {
  }
  run(10);
  std::vector<can::Time> edges;
  for (can::Time at{}; line_->take({}, at);) edges.push_back(at);
  ASSERT_EQ(edges.size(), 8u);
  EXPECT_EQ(edges[0], milliseconds(502));
  EXPECT_EQ(edges[1], milliseconds(504));
  EXPECT_EQ(drives_[0]->parameters().value(parameter::missed_edges), 0u);
  EXPECT_EQ(master_->interval(), 510u) << "the master itself goes on";
}

TEST_F(MasterNodeTest, ReferenceTelegramsGoMissingByFaults) {
  Fault lost;
  lost.kind = FaultKind::lost;
  lost.from = 1000;
  lost.to = 1003;
  lost.identifier = cansync::identifier::reference_one;
  lost.mask = cansync::identifier::channel_bits;
  build(settings(BitRate::mbit1), {lost});
  run(1500);
  EXPECT_EQ(drives_[0]->missed_references(), 4u);
  EXPECT_EQ(drives_[1]->missed_references(), 4u);
}

TEST_F(MasterNodeTest, SubmitsRoutines) {
  MasterNodeSettings with = settings(BitRate::mbit1);
  cansync::ParameterRequest read;
  read.id = 77;
  read.slave = *cansync::SlaveNumber::from(1);
  read.number = *cansync::ParameterNumber::from(parameter::serial_number);
  with.routines = {{500, 100, read}};
  build(with);
  run(1000);
  ASSERT_EQ(told_.parameters.size(), 5u);
  for (const auto& result : told_.parameters) {
    EXPECT_EQ(result.outcome, cansync::Outcome::done);
    EXPECT_EQ(result.value, 1001u);
  }
}

TEST(ReferenceCurve, RunsAsItsKindSays) {
  EXPECT_EQ(value_of({}, 5), 0u);
  EXPECT_EQ(value_of({ReferenceCurve::Kind::ramp, -1, 2}, 0), 0xFFFFFFFFu);
  EXPECT_EQ(value_of({ReferenceCurve::Kind::ramp, -1, 2}, 1), 1u);
  EXPECT_EQ(value_of({ReferenceCurve::Kind::ramp, 0, 1}, 0x1'0000'0002), 2u);
  const ReferenceCurve sine{ReferenceCurve::Kind::sine, 10, 0, 100, 4};
  EXPECT_EQ(value_of(sine, 0), 10u);
  EXPECT_EQ(value_of(sine, 1), 110u);
  EXPECT_EQ(value_of(sine, 3), static_cast<std::uint32_t>(-90));
  EXPECT_EQ(value_of(sine, 4), 10u);
}

}  // namespace
}  // namespace sim
