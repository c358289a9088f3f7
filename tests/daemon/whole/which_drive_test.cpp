// Drives that are not the ones expected, on a whole line of simulated drives in virtual time: no such drive
// synchronizes, so none takes the reference values that go to every drive of the bus.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <limits>
#include <memory>
#include <variant>
#include <vector>

#include "support/virtual_line.h"

namespace cansyncd::test {
namespace {

using namespace cansync;
using support::drives_for;
using support::line_settings;
using support::VirtualLine;
using Code = MasterEvent::Code;

constexpr unsigned kDrives = 4;
constexpr std::uint32_t kSerial = 1000;  // and the slave's number

/// A drive that joins the bus at an edge of SYNC, and leaves it at a later one.
class LateDrive final : public sim::Node {
 public:
  LateDrive(const sim::DriveSettings& settings, std::uint64_t edge,
            std::uint64_t end = std::numeric_limits<std::uint64_t>::max())
      : drive_(settings), edge_(edge), end_(end) {}
  sim::NodeNumber node_number() const noexcept override { return drive_.node_number(); }
  bool accepts(const can::Frame& frame) const noexcept override { return drive_.accepts(frame); }
  void on_sync(can::Time now) noexcept override {
    if (edges_++ >= edge_ && is_there()) drive_.on_sync(now);
  }
  std::optional<sim::Transmission> on_frame(const can::Frame& frame, can::Time end) noexcept override {
    return edges_ > edge_ && is_there() ? drive_.on_frame(frame, end) : std::nullopt;
  }
  std::optional<sim::Transmission> on_sent(const can::Frame& frame, can::Time end) noexcept override {
    return drive_.on_sent(frame, end);
  }

 private:
  bool is_there() const noexcept { return edges_ <= end_; }

  sim::Drive drive_;
  std::uint64_t edge_;
  std::uint64_t end_;
  std::uint64_t edges_ = 0;
};

/// Four drives that are expected by their serial numbers; reference values are given all the time.
struct WhichDrive : testing::Test {
  MasterSettings settings = line_settings(BitRate::mbit1, kDrives);
  std::vector<std::unique_ptr<sim::Node>> nodes;
  std::vector<sim::Fault> faults;
  std::unique_ptr<VirtualLine> line;
  std::vector<MasterEvent> events;
  SlaveMask ever_synchronized;
  MasterSnapshot last;
  bool ever_active = false;
  std::uint64_t active_from = 0;

  WhichDrive() {
    settings.startup.census = true;
    for (unsigned n = 0; n < kDrives; ++n) {
      SlaveSettings& slave = settings.slaves[n];
      slave.expect[slave.expect_count++] = {*ParameterNumber::from(sim::parameter::device_type), 4400};
      slave.expect[slave.expect_count++] = {*ParameterNumber::from(sim::parameter::serial_number),
                                            kSerial + n};
    }
    nodes = drives_for(settings);
  }

  sim::DriveSettings drive_settings(unsigned n) const {
    sim::DriveSettings drive;
    drive.slave.number = *SlaveNumber::from(n);
    drive.slave.bit_rate = settings.bit_rate;
    drive.lock_time = std::chrono::milliseconds(100);
    drive.memory.size = 4096;
    return drive;
  }
  void make_line() { line = std::make_unique<VirtualLine>(settings, std::move(nodes), faults); }
  void serial(unsigned index, std::uint32_t value) {
    ASSERT_TRUE(line->drive(index).set_parameter(sim::parameter::serial_number, value));
  }
  void look(std::uint64_t edge) {
    for (unsigned n = 0; n < kDrives; ++n) {
      if ((line->drive(n).status_word() & sim::status_bit::synchronized) != 0)
        ever_synchronized.set(*SlaveNumber::from(n));
    }
    static_cast<void>(line->exchange().master.read(last));
    if (is_active(last.state) && !std::exchange(ever_active, true)) active_from = edge;
    Report report;
    while (line->exchange().reports.try_pop(report)) {
      if (const auto* event = std::get_if<EventReport>(&report)) events.push_back(event->event);
    }
    line->give_references(static_cast<std::uint32_t>(edge));
  }
  void run(
      std::uint64_t edges, const std::function<void(std::uint64_t)>& at_edge = [](std::uint64_t) {}) {
    line->on_edge = [this, at_edge](std::uint64_t edge) {
      at_edge(edge);
      look(edge);
    };
    line->run(edges);
  }
  unsigned count(Code code, unsigned slave) const {
    return static_cast<unsigned>(std::count_if(events.begin(), events.end(), [&](const MasterEvent& event) {
      return event.code == code && event.slave == SlaveNumber::from(slave);
    }));
  }
};

TEST_F(WhichDrive, TheDrivesExpectedRunAsSoonAsTheyHaveLocked) {
  make_line();
  run(1000);
  EXPECT_TRUE(ever_active);
  EXPECT_LE(active_from, 300u) << "100 ms to lock, and a few intervals of questions";
  for (unsigned n = 0; n < kDrives; ++n) EXPECT_EQ(count(Code::slave_identified, n), 1u) << n;
}

TEST_F(WhichDrive, AnExchangedPairIsHeldAndNeverSynchronizes) {
  make_line();
  serial(1, kSerial + 2);
  serial(2, kSerial + 1);
  run(2000);
  EXPECT_FALSE(ever_active);
  EXPECT_EQ(ever_synchronized.bits, 0b1001u);
  EXPECT_EQ(last.wrong.bits, 0b0110u);
  EXPECT_EQ(count(Code::wrong_drive, 1), 1u);
  EXPECT_EQ(count(Code::wrong_drive, 2), 1u);
}

TEST_F(WhichDrive, ADriveReplacedInRunIsHeldAndDoesNotFollow) {
  sim::Fault away{.kind = sim::FaultKind::silent, .from = 1000, .to = 1500, .node = 2};
  faults = {away};
  make_line();
  std::uint32_t missed = 0;
  run(4000, [&](std::uint64_t edge) {
    if (edge == 1400) {
      line->drive(2).restart();
      serial(2, 2001);
      ever_synchronized = {};
    }
    if (edge == 1500) missed = line->drive(0).missed_references();
  });
  EXPECT_TRUE(ever_active);
  EXPECT_EQ(count(Code::slave_lost, 2), 1u);
  EXPECT_EQ(count(Code::wrong_drive, 2), 1u);
  EXPECT_FALSE(ever_synchronized.has(*SlaveNumber::from(2)));
  EXPECT_EQ(line->drive(0).missed_references(), missed) << "the line goes on without a gap";
}

TEST_F(WhichDrive, TheSameDriveComesBackIntoTheLine) {
  faults = {{.kind = sim::FaultKind::silent, .from = 1000, .to = 1500, .node = 2}};
  make_line();
  run(4000, [&](std::uint64_t edge) {
    if (edge == 1400) line->drive(2).restart();
  });
  EXPECT_EQ(count(Code::slave_identified, 2), 2u);
  EXPECT_EQ(count(Code::slave_released, 2), 1u);
}

TEST_F(WhichDrive, TwoDrivesOfOneNumberKeepTheLineFromRun) {
  nodes.push_back(std::make_unique<LateDrive>(drive_settings(1), 0));
  make_line();
  run(2000);
  EXPECT_FALSE(ever_active);
  EXPECT_EQ(count(Code::duplicate_slave, 1), 1u);
  EXPECT_EQ(last.duplicate.bits, 0b0010u);
}

TEST_F(WhichDrive, OnceOneOfTwoDrivesIsDisconnectedTheOtherIsReleasedAndTheLineRuns) {
  nodes.push_back(std::make_unique<LateDrive>(drive_settings(1), 0, 1000));
  make_line();
  const auto release = [&](cansync::JobId id) {
    EXPECT_TRUE(line->exchange().requests.try_push(ReleaseSlave{id, *SlaveNumber::from(1), false}));
  };
  run(3000, [&](std::uint64_t edge) {
    if (edge == 900) release(1);
    if (edge == 1100) {
      EXPECT_TRUE(last.duplicate.has(*SlaveNumber::from(1))) << "a release alone does not help";
      EXPECT_FALSE(ever_active);
      release(2);
    }
  });
  EXPECT_TRUE(last.duplicate.empty());
  EXPECT_TRUE(last.released.has(*SlaveNumber::from(1)));
  EXPECT_TRUE(ever_active);
}

TEST_F(WhichDrive, ASecondDriveThatComesInRunIsFoundWithinAHundredIntervals) {
  nodes.push_back(std::make_unique<LateDrive>(drive_settings(1), 1000));
  make_line();
  bool found = false;
  run(1100, [&](std::uint64_t) { found = found || count(Code::duplicate_slave, 1) != 0; });
  EXPECT_TRUE(ever_active);
  EXPECT_EQ(count(Code::duplicate_slave, 1), 1u);
  EXPECT_TRUE(found);
}

TEST_F(WhichDrive, ADriveThatIsNotConfiguredIsNamedAndNotActivated) {
  nodes.push_back(std::make_unique<sim::Drive>(drive_settings(9)));
  make_line();
  run(1000);
  EXPECT_TRUE(ever_active);
  EXPECT_EQ(count(Code::unknown_slave, 9), 1u);
  EXPECT_EQ(last.unknown.bits, 1u << 9);
  EXPECT_EQ(line->drive(kDrives).status_word() & sim::status_bit::synchronized, 0);
}

}  // namespace
}  // namespace cansyncd::test
