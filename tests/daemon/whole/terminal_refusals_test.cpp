// Exactly one terminal reply for each request that is refused, for whatever reason: real DDS, the gateway on
// its own thread, and the realtime loop with simulated drives in virtual time.
#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <vector>

#include "whole_requests.h"

namespace cansyncd {
namespace {

/// One request of each type that reaches the master only if nothing is wrong, spoiled by a row of the table.
struct Refused {
  const char* name;
  std::function<void(Config&)> configure;
  /// Asks with numbers 1 to `count`; the last three must be refused, what is before must not.
  std::function<void(WholeRig&, TestClient&)> ask;
  std::uint64_t count = 3;
};

void ask_two(TestClient& client, std::uint64_t first, std::uint32_t of_slave = 1) {
  client.write(transfer(first, of_slave, 0));
  auto word = command(first + 1, cansync_COMMAND_CONTROL_WORD);
  word.slave = of_slave;
  client.write(word);
}
void ask_three(TestClient& client, std::uint64_t first, std::uint32_t of_slave = 1) {
  client.write(parameter(first, of_slave, true, 0));
  ask_two(client, first + 1, of_slave);
}

void ask_out_of_range(WholeRig& /*rig*/, TestClient& client) {
  auto number = parameter(1, 1, false, 0);
  number.number = 4096;
  client.write(number);
  auto block = transfer(2, 1, 0);
  block.block_size = 4093;
  client.write(block);
  auto word = command(3, cansync_COMMAND_CONTROL_WORD);
  word.control_word = 65536;
  client.write(word);
}

void ask_at(TestClient& client, dds_time_t time) {
  client.write_at(parameter(1, 1, true, 0), time);
  client.write_at(transfer(2, 1, 0), time);
  client.write_at(command(3, cansync_COMMAND_CONTROL_WORD), time);
}

void ask_for_changes(WholeRig& /*rig*/, TestClient& client) {
  client.write(parameter(1, 1, true, 0));
  auto down = transfer(2, 1, 0);
  std::vector<std::uint8_t> data(down.length);
  down.direction = cansync_DIRECTION_DOWNLOAD;
  down.data = {down.length, down.length, data.data(), false};
  client.write(down);
  client.write(command(3, cansync_COMMAND_CONTROL_WORD));
}

void ask_a_silent_slave(WholeRig& rig, TestClient& client) {
  rig.hold();
  add(rig, sim::FaultKind::silent);
  rig.run(2000);
  rig.release();
  ask_three(client, 1);
}

void ask_a_stopped_line(WholeRig& rig, TestClient& client) {
  order(rig, cansync_MODE_STOP);
  ASSERT_TRUE(rig.watch([](const auto& status) {
    return status.option_status == static_cast<std::uint16_t>(cansync::State::waiting_for_start);
  }));
  ask_three(client, 1);
}

void ask_too_much(WholeRig& rig, TestClient& client) {
  rig.hold();
  for (std::uint64_t number = 1; number <= JobBook::kPerClient; ++number) {
    client.write(parameter(number, 1, false, 0));
  }
  // After these, because it goes the same way.
  client.deliver(parameter(JobBook::kPerClient + 1, 1, true, 0));
  pass_marker(rig);
  ask_two(client, JobBook::kPerClient + 2);
  EXPECT_TRUE(rig.all_answered(3));
  rig.release();
}

const std::vector<Refused>& refusals() {
  static const auto nothing = [](Config&) {};
  static const auto an_hour = [](Config& config) { config.dds.request_max_age = std::chrono::hours(1); };
  static const std::vector<Refused> all = {
      {"unknown slave", nothing, [](WholeRig&, TestClient& client) { ask_three(client, 1, 9); }},
      {"out of range", nothing, ask_out_of_range},
      {"stale", an_hour, [](WholeRig&, TestClient& client) { ask_at(client, dds_time() - DDS_SECS(7200)); }},
      {"from the future", an_hour,
       [](WholeRig&, TestClient& client) { ask_at(client, dds_time() + DDS_SECS(7200)); }},
      {"read-only", [](Config& config) { config.access.read_only = true; }, ask_for_changes},
      {"the slave does not answer", nothing, ask_a_silent_slave},
      {"the line is stopped", nothing, ask_a_stopped_line},
      {"too many open", nothing, ask_too_much, JobBook::kPerClient + 3},
  };
  return all;
}

class RefusedRequests : public testing::TestWithParam<std::size_t> {};

TEST_P(RefusedRequests, HaveExactlyOneReply) {
  const Refused& row = refusals().at(GetParam());
  SCOPED_TRACE(row.name);
  Config config = whole_config();
  row.configure(config);
  WholeRig rig(config);
  rig.release();
  const auto asker = rig.new_asker();
  row.ask(rig, asker->client);
  const auto codes = only_replies(rig, row.count);
  for (std::size_t i = 0; i < codes.size(); ++i) {
    const bool refused = i + 3 >= row.count;
    EXPECT_EQ(codes[i], refused ? gateway_REPLY_REFUSED : gateway_REPLY_DONE) << "request " << i + 1;
  }
}

INSTANTIATE_TEST_SUITE_P(Reasons, RefusedRequests, testing::Range<std::size_t>(0, refusals().size()));

/// A number that was used gets its own reply once more: a refusal, whatever became of the first.
TEST(TerminalReplies, ANumberUsedTwiceHasTwoAndIsExecutedOnce) {
  WholeRig rig;
  const auto asker = rig.new_asker();
  asker->client.deliver(parameter(1, 1, true, 0));
  asker->client.deliver(parameter(1, 1, true, 0));
  rig.release();
  EXPECT_TRUE(eventually(rig.watcher().signal(), [&] {
    const auto found = rig.replies().find(1);
    return found != rig.replies().end() && found->second.size() >= 2;
  }));
  pass_marker(rig);
  EXPECT_EQ(rig.replies().at(1), (std::vector{gateway_REPLY_REFUSED, gateway_REPLY_DONE}));
}

}  // namespace
}  // namespace cansyncd
