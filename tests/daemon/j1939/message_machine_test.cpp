// A node of J1939 on the simulated bus, in virtual time: the realtime loop with the machine on it, and
// simulated nodes beside it.
#include "daemon/j1939/realtime/message_machine.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "daemon/loop/deadline_loop.h"
#include "j1939/node_rig.h"
#include "j1939/sim/ecu_node.h"
#include "sim/line.h"
#include "support/timed_bus.h"

namespace cansyncd {
namespace {

using j1939::Outcome;
using j1939::test::counting;
using std::chrono::milliseconds;
using std::chrono::seconds;

MessageMachineSettings machine_at(j1939::Address address) {
  MessageMachineSettings settings;
  settings.wall_clock = nullptr;
  settings.node = j1939::test::settings_at(address);
  return settings;
}

sim::EcuSettings ecu_at(j1939::Address address) {
  sim::EcuSettings settings;
  settings.claim.preferred = address;
  settings.claim.name = address;  // strong, and of each its own
  return settings;
}

class CountingBus final : public test::TimedBus {
 public:
  using TimedBus::TimedBus;
  std::uint64_t unacknowledged = 0;  ///< as the status says

  can::ControllerStatus status() noexcept override {
    can::ControllerStatus status = behind_.status();
    status.unacknowledged = unacknowledged;
    return status;
  }
};

struct MachineRig {
  explicit MachineRig(const MessageMachineSettings& settings, std::vector<sim::EcuSettings> ecus = {})
      : line({.bits_per_second = 250'000}, nodes_of(std::move(ecus))), machine(settings, bus, exchange) {}

  static std::vector<std::unique_ptr<sim::Node>> nodes_of(std::vector<sim::EcuSettings> ecus) {
    std::vector<std::unique_ptr<sim::Node>> nodes;
    for (auto& ecu : ecus) nodes.push_back(std::make_unique<sim::EcuNode>(std::move(ecu)));
    return nodes;
  }
  void order_at(can::Time when, const j1939::Order& order) {
    bus.script.emplace(when, [this, order] { EXPECT_TRUE(exchange.requests.try_push(order)); });
  }
  void run_until(can::Time end) {
    bus.script.emplace(end, [this] { loop.request_stop(); });
    loop.run();
    MessageDone done;
    while (exchange.done.try_pop(done)) answers.emplace(done.answer.id, done);
    MessageReport report;
    while (exchange.messages.try_pop(report)) {
      received.push_back(report);
      LongData data;
      if (report.size <= report.data.size()) continue;
      EXPECT_TRUE(exchange.long_data.try_pop(data));
      long_data.emplace_back(data.begin(), data.begin() + report.size);
    }
  }
  NodeSnapshot status() {
    NodeSnapshot newest;
    EXPECT_TRUE(exchange.status.read(newest));
    return newest;
  }
  /// Messages of a group that were received.
  long count(j1939::Pgn number) const {
    return std::count_if(received.begin(), received.end(),
                         [&](const auto& one) { return one.number == number; });
  }

  sim::Line line;
  CountingBus bus{line};
  J1939Exchange exchange{16, 256, 65'536};
  MessageMachine machine;
  DeadlineLoop<MessageMachine> loop{machine, bus};
  std::multimap<j1939::OrderId, MessageDone> answers;
  std::vector<MessageReport> received;
  std::vector<std::vector<std::uint8_t>> long_data;
};

TEST(MessageMachine, ClaimsItsAddressAndHearsThoseOfOthers) {
  MachineRig rig(machine_at(0x80), {ecu_at(0x21)});
  rig.run_until(milliseconds(400));
  const NodeSnapshot status = rig.status();
  EXPECT_EQ(status.claim, j1939::ClaimState::claimed);
  EXPECT_EQ(status.address, 0x80);
  AddressSnapshot addresses;
  ASSERT_TRUE(rig.exchange.addresses.read(addresses));
  EXPECT_TRUE(addresses.claimed[0x21]);
  EXPECT_EQ(addresses.names[0x21], 0x21u);
}

TEST(MessageMachine, LosesItsAddressToAStrongerNodeAndTakesAnother) {
  MachineRig rig(machine_at(0x80), {ecu_at(0x80)});
  rig.run_until(milliseconds(600));
  const NodeSnapshot status = rig.status();
  EXPECT_EQ(status.claim, j1939::ClaimState::claimed);
  EXPECT_EQ(status.address, 0x81);
  EXPECT_EQ(status.losses, 1u);
}

TEST(MessageMachine, AConnectionAndABroadcastArriveWhole) {
  sim::EcuSettings to_us = ecu_at(0x21);
  to_us.group = 0xEF00;
  to_us.destination = 0x80;
  to_us.data = counting(1785);
  to_us.period = seconds(1);
  sim::EcuSettings to_all = ecu_at(0x22);
  to_all.group = 0xFEF2;
  to_all.data = counting(20);
  to_all.period = milliseconds(1500);
  MachineRig rig(machine_at(0x80), {to_us, to_all});
  rig.run_until(milliseconds(1980));
  ASSERT_EQ(rig.long_data.size(), 2u);
  for (const auto& data : rig.long_data) {
    std::vector<std::uint8_t> expected = counting(data.size());
    ++expected[0];  // the first byte counts
    EXPECT_EQ(data, expected);
  }
  EXPECT_EQ(rig.count(0xEF00), 1);
  EXPECT_EQ(rig.count(0xFEF2), 1);
  EXPECT_EQ(rig.status().packets.completed, 2u);
}

TEST(MessageMachine, SendsALongMessageThatTheOtherAcknowledges) {
  MachineRig rig(machine_at(0x80), {ecu_at(0x21)});
  std::vector<std::uint8_t> data = counting(1785);
  rig.order_at(
      milliseconds(300),
      {.id = 1, .number = 0xEF00, .priority = 7, .destination = 0x21, .timeout = seconds(5), .memory = data});
  rig.run_until(seconds(3));
  ASSERT_EQ(rig.answers.count(1), 1u);
  EXPECT_EQ(rig.answers.find(1)->second.answer.outcome, Outcome::done);
}

TEST(MessageMachine, ARequestIsAnsweredByTheOtherNode) {
  sim::EcuSettings ecu = ecu_at(0x21);
  ecu.group = 0xFEEB;
  ecu.data = counting(30);
  MachineRig rig(machine_at(0x80), {ecu});
  std::vector<std::uint8_t> memory(j1939::kMostBytes);
  const auto ask = [&](j1939::OrderId id, j1939::Pgn number) {
    return j1939::Order{.id = id,
                        .kind = j1939::OrderKind::request,
                        .number = number,
                        .destination = 0x21,
                        .timeout = milliseconds(1250),
                        .memory = memory};
  };
  rig.order_at(milliseconds(300), ask(1, 0xFEEB));
  rig.order_at(milliseconds(800), ask(2, 0xFEE5));
  rig.run_until(milliseconds(1000));
  const MessageDone answered = rig.answers.find(1)->second;
  EXPECT_EQ(answered.answer.outcome, Outcome::done);
  EXPECT_EQ(answered.answer.size, 30u);
  EXPECT_EQ(memory[29], 30);
  EXPECT_EQ(rig.answers.find(2)->second.answer.outcome, Outcome::refused);
}

TEST(MessageMachine, OrdersWithoutAnAddressAreRefused) {
  MessageMachineSettings settings = machine_at(0x80);
  settings.node.claim.preferred.reset();
  MachineRig rig(settings);
  rig.order_at(milliseconds(5), {.id = 1, .number = 0xFEF1, .timeout = seconds(1)});
  rig.run_until(milliseconds(10));
  EXPECT_EQ(rig.answers.find(1)->second.refusal, j1939::Refusal::no_address);
}

TEST(MessageMachine, AControllerThatWasEmptiedBringsANewClaim) {
  MachineRig rig(machine_at(0x80), {ecu_at(0x21)});
  rig.bus.script.emplace(milliseconds(400), [&] { rig.bus.unacknowledged = 1; });
  rig.run_until(milliseconds(500));
  const NodeSnapshot status = rig.status();
  EXPECT_EQ(status.claim, j1939::ClaimState::claiming);
  EXPECT_EQ(status.address, 0x80);
}

TEST(MessageMachine, TheEndAnswersWhatIsOpen) {
  MachineRig rig(machine_at(0x80), {ecu_at(0x21)});
  std::vector<std::uint8_t> data = counting(20);
  rig.order_at(milliseconds(300), {.id = 1, .number = 0xFEF2, .timeout = seconds(5), .memory = data});
  rig.run_until(milliseconds(320));
  ASSERT_EQ(rig.answers.count(1), 1u);
  const j1939::Answer& answer = rig.answers.find(1)->second.answer;
  EXPECT_EQ(answer.outcome, Outcome::no_answer) << "its announcement was on the bus";
  EXPECT_EQ(answer.ended_by, j1939::JobEnd::stopped);
}

}  // namespace
}  // namespace cansyncd
