// What the realtime thread of a slave must not do, watched in virtual time: a master that reads, writes,
// uploads and downloads, and an application that answers, goes and comes back.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <numeric>
#include <utility>
#include <variant>
#include <vector>

#include "cansync/sim/drive_faults.h"
#include "cansync/sim/master_node.h"
#include "daemon/cansync_slave/realtime/slave_machine.h"
#include "daemon/loop/deadline_loop.h"
#include "sim/line.h"
#include "support/watched_turns.h"

namespace cansyncd {
namespace {

constexpr std::uint8_t kBusySlave = 5;

/// Plays gateway and application between two turns of the loop.
class ServedBus final : public test::WatchedTurns {
 public:
  ServedBus(can::Bus& line, SlaveExchange& exchange) : WatchedTurns(line, 3000, 40'000), exchange_(exchange) {
    taken_.present = taken_.same_application = taken_.blocks = true;
    taken_.taken.numbers.set(500);
  }

  static constexpr std::uint64_t kPresence = 997;  ///< the application comes or goes after so many
  std::uint64_t answered = 0;
  std::uint64_t dropped = 0;
  std::uint64_t blocks_done = 0;
  std::uint64_t references = 0;

 private:
  void work() noexcept override {
    if (turns % kPresence == 0) {
      taken_.present = !taken_.present;
      exchange_.orders.try_push(taken_);
    }
    exchange_.releases.try_push({cansync::Channel::one, {1, 2, 3, 4}, 0x0F, 3});
    ServiceReport report;
    while (exchange_.jobs.try_pop(report)) {
      if (const auto* job = std::get_if<JobReport>(&report)) {
        serve(*job);
      } else if (const auto* block = std::get_if<BlockReport>(&report)) {
        serve(*block);
      }
    }
    SlaveSideReport told;
    while (exchange_.reports.try_pop(told)) references += std::holds_alternative<ReferencesReport>(told);
  }
  void serve(const JobReport& report) noexcept {
    if (report.step == JobReport::Step::answered) ++answered;
    if (report.step == JobReport::Step::dropped) ++dropped;
    if (report.step != JobReport::Step::asked) return;
    exchange_.orders.try_push(JobAnswer{report.job.id, {.doubleword = true, .value = 7}});
  }
  void serve(const BlockReport& report) noexcept {
    BlockReply reply;
    reply.id = report.block.id;
    switch (report.step) {
      case BlockReport::Step::begun:
        if (report.block.direction == cansync::AskedBlock::Direction::upload && report.block.area)
          reply.bytes = report.block.length;
        break;
      case BlockReport::Step::complete:
        reply.kind = BlockReply::Kind::take;
        break;
      case BlockReport::Step::telegram:
        reply.kind = BlockReply::Kind::step;
        if (report.block.direction == cansync::AskedBlock::Direction::upload) reply.bytes = report.bytes;
        break;
      case BlockReport::Step::ended:
        if (report.end == cansync::BlockEnd::done) ++blocks_done;
        return;
    }
    exchange_.orders.try_push(reply);
  }

  SlaveExchange& exchange_;
  TakeOver taken_;
};

void add_transfer(sim::MasterNodeSettings& settings, std::uint16_t bytes, bool download,
                  cansync::IntervalNumber from) {
  using Direction = cansync::TransferRequest::Direction;
  auto block = std::make_shared<std::vector<std::uint8_t>>(bytes);
  std::iota(block->begin(), block->end(), std::uint8_t{0});
  cansync::TransferRequest request;
  request.id = from;
  request.direction = download ? Direction::download : Direction::upload;
  request.slave = *cansync::SlaveNumber::from(kBusySlave);
  request.address = 0x100;
  request.block_size = bytes;
  request.data = *block;
  settings.blocks.push_back(std::move(block));
  settings.routines.push_back({from, 400, request});
}

std::unique_ptr<sim::MasterNode> asking_master(const cansync::SlotTimes& times) {
  const cansync::SlaveNumber slave = *cansync::SlaveNumber::from(kBusySlave);
  sim::MasterNodeSettings settings;
  settings.master.send_margin = cansync::default_send_margin(cansync::BitRate::mbit1);
  settings.master.slaves[kBusySlave].configured = true;
  settings.master.slaves[kBusySlave].block_limit = 1000;
  settings.master.process.maximum_slave = slave;
  settings.master.process.polling.fill({cansync::Cursor::Kind::fixed, slave});
  settings.first_edge = times.interval;
  settings.references[0] = {.kind = sim::ReferenceCurve::Kind::ramp, .step = 1};
  for (const unsigned number : {400u, 500u}) {
    for (const bool write : {false, true}) {
      cansync::ParameterRequest request;
      request.id = number + write;
      request.slave = slave;
      request.number = *cansync::ParameterNumber::from(number);
      request.write = write;
      request.value = 9;
      settings.routines.push_back({0, 50, request});
    }
  }
  add_transfer(settings, 300, true, 1);
  add_transfer(settings, 300, false, 100);
  add_transfer(settings, 600, true, 200);
  add_transfer(settings, 600, false, 300);
  return std::make_unique<sim::MasterNode>(settings);
}

TEST(RealtimeRules, TheLoopOfASlaveNeitherAllocatesNorLocksNorWritesAnythingButItsWakeSignal) {
  const cansync::SlotTimes& times = cansync::slot_times(cansync::BitRate::mbit1);
  std::vector<std::unique_ptr<sim::Node>> nodes;
  nodes.push_back(asking_master(times));
  sim::LineSettings line_settings;
  line_settings.bits_per_second = times.bits_per_second;
  line_settings.protocol = &sim::drive_faults();
  line_settings.user_number = kBusySlave;
  sim::Line line(line_settings, std::move(nodes));
  SlaveExchange exchange(256);
  ServedBus served(line, exchange);
  SlaveMachineSettings settings;
  settings.slave.number = *cansync::SlaveNumber::from(kBusySlave);
  settings.slave.block_limit = 1000;
  settings.service.parameters = {{400, false, {}, 7, 0, 100, true}, {500, true}, {301, false}};
  settings.supervision.interval = times.interval;
  settings.supervision.lock_time = 10 * times.interval;
  settings.supervision.edges_until_fault = 2;
  settings.lock.interval = times.interval;
  settings.lock.greatest_step = times.interval / 1000;
  settings.lock.holdover = 20 * times.interval;
  settings.inputs.wire = &line;
  SlaveMachine machine(settings, served, exchange);

  DeadlineLoop<SlaveMachine> loop(machine, served);
  served.end = [&loop] { loop.request_stop(); };
  loop.run();

  EXPECT_GT(served.answered, 50u);
  EXPECT_GT(served.dropped, 0u);
  EXPECT_GT(served.blocks_done, 4u);
  EXPECT_GT(served.references, 500u);
  EXPECT_EQ(served.after.allocations, served.before.allocations);
  EXPECT_EQ(served.after.locks, served.before.locks);
  // Nobody takes the signal, so that it is given once, before the turns that are watched.
  EXPECT_EQ(served.after.writes, served.before.writes);
}

}  // namespace
}  // namespace cansyncd
