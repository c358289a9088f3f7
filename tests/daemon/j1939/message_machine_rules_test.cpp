// What the realtime thread of a bus of J1939 must not do, watched in virtual time on a busy bus.
#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "daemon/j1939/realtime/message_machine.h"
#include "daemon/loop/deadline_loop.h"
#include "daemon/loop/flight_tap.h"
#include "j1939/node_rig.h"
#include "j1939/sim/ecu_node.h"
#include "rt/flight_recorder.h"
#include "sim/line.h"
#include "support/watched_turns.h"

namespace cansyncd {
namespace {

using std::chrono::milliseconds;

/// Plays the gateway between two turns of the loop: orders, takes back, reads everything.
class CrowdedBus final : public test::WatchedTurns {
 public:
  CrowdedBus(can::Bus& line, J1939Exchange& exchange) : WatchedTurns(line, 10, 5000), exchange_(exchange) {}

  std::uint64_t answers = 0;
  std::uint64_t frames = 0;
  std::uint64_t long_messages = 0;

  // Now and then the bus takes nothing.
  can::SendResult send(const can::Frame& frame) noexcept override {
    return turns % 50 < 5 ? can::SendResult::queue_full : behind_.send(frame);
  }

 private:
  void work() noexcept override {
    ++number_;
    // Long and short ones, to all and to one, and requests.
    j1939::Order order{.id = number_, .number = 0xFEF1, .timeout = milliseconds(2)};
    if (number_ % 5 == 1)
      order = {.id = number_,
               .number = 0xEF00,
               .destination = 0x21,
               .timeout = milliseconds(300),
               .memory = long_};
    if (number_ % 5 == 2) order.memory = long_;
    if (number_ % 5 == 3)
      order = {.id = number_,
               .kind = j1939::OrderKind::request,
               .number = 0xFEEB,
               .destination = 0x21,
               .timeout = milliseconds(100),
               .memory = answer_};
    exchange_.requests.try_push(order);
    if (number_ % 7 == 0) exchange_.requests.try_push(CancelMessage{number_});
    MessageDone done;
    while (exchange_.done.try_pop(done)) ++answers;
    MessageReport report;
    LongData data;
    while (exchange_.messages.try_pop(report)) ++frames;
    while (exchange_.long_data.try_pop(data)) ++long_messages;
  }

  J1939Exchange& exchange_;
  std::uint64_t number_ = 0;
  std::vector<std::uint8_t> long_ = j1939::test::counting(40);
  std::vector<std::uint8_t> answer_ = std::vector<std::uint8_t>(j1939::kMostBytes);
};

TEST(RealtimeRules, TheLoopOfMessagesNeitherAllocatesNorLocksNorWritesAnythingButItsWakeSignal) {
  std::vector<std::unique_ptr<sim::Node>> nodes;
  sim::EcuSettings ecu;
  ecu.claim.preferred = 0x21;
  ecu.claim.name = 1;
  ecu.group = 0xFEEB;
  ecu.data = j1939::test::counting(30);
  nodes.push_back(std::make_unique<sim::EcuNode>(std::move(ecu)));
  sim::Line line({}, std::move(nodes));
  J1939Exchange exchange(64, 64, 65'536);
  CrowdedBus busy(line, exchange);
  rt::FlightRecorder recorder(4096, 10);
  FlightTap tap(recorder, {});
  RecordedBus recorded(busy, tap);
  MessageMachineSettings settings;
  settings.tap = &tap;
  settings.node = j1939::test::settings_at(0x80);
  MessageMachine machine(settings, recorded, exchange);

  DeadlineLoop<MessageMachine> loop(machine, recorded);
  busy.end = [&loop] { loop.request_stop(); };
  loop.run();

  EXPECT_GT(busy.answers, 1000u);
  EXPECT_GT(busy.frames, 20u);
  EXPECT_GT(busy.long_messages, 20u);
  EXPECT_EQ(busy.after.allocations, busy.before.allocations);
  EXPECT_EQ(busy.after.locks, busy.before.locks);
  // Nobody takes the signal, so that it is given once, before the turns that are watched.
  EXPECT_EQ(busy.after.writes, busy.before.writes);
}

}  // namespace
}  // namespace cansyncd
