#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <future>
#include <optional>
#include <thread>

#include "client/child.h"
#include "client/fake_daemon.h"
#include "support/dds_places.h"
#include "support/long_wait.h"

/// Runs the C programs of this folder, linked with the shared library, against the fake daemon.
namespace {

std::string command_line(const char* program, const TwoPlaces& places) {
  return std::string(program) + " " + std::to_string(places.here.domain) + " " + places.here.partition;
}

TEST(CFace, EveryCheckOfTheCProgramHolds) {
  const TwoPlaces places;
  FakeDaemon daemon(places.here);
  daemon.publish_actual(2, 0xABCD);
  daemon.publish_event(17);
  const Child child = run_child(command_line(CANSYNC_C_FACE, places));
  EXPECT_EQ(child.exit_code, 0) << child.output;

  const auto commands = daemon.commands();
  ASSERT_EQ(commands.size(), 8u);
  EXPECT_EQ(commands[0].kind, cansync_COMMAND_CONTROL_WORD);
  EXPECT_EQ(commands[0].control_word, 0x0Fu);
  EXPECT_EQ(commands[1].kind, cansync_COMMAND_BROADCAST);
  EXPECT_EQ(commands[1].slave_mask, 3u);
  EXPECT_EQ(commands[2].mode, cansync_MODE_RUN);
  EXPECT_TRUE(commands[2].force);
  EXPECT_EQ(commands[3].kind, cansync_COMMAND_RELEASE);
  EXPECT_EQ(commands[4].control_word, 7u);
  EXPECT_EQ(commands[5].kind, cansync_COMMAND_POLLING);
  EXPECT_EQ(commands[5].polling_two, -128);
  EXPECT_EQ(commands[6].kind, cansync_COMMAND_CHANNEL_CURSORS);
  EXPECT_EQ(commands[6].cursor_parameter, -128);
  EXPECT_EQ(commands[7].kind, cansync_COMMAND_REFERENCE_MAPPING);
}

/// True when the daemon has got the value.
bool comes(const FakeDaemon& daemon, std::int32_t value) {
  const auto end = std::chrono::steady_clock::now() + gateway::kLongWait;
  while (std::chrono::steady_clock::now() < end) {
    const auto got = daemon.references();
    if (std::count(got.begin(), got.end(), value) != 0) return true;
    std::this_thread::yield();
  }
  return false;
}

// The values are those of c_face_restart.c: odd ones are given, even ones after the program was told.
TEST(CFace, AfterARestartOrAnotherMappingNothingIsGivenUntilItIsTakenUp) {
  const TwoPlaces places;
  std::optional<FakeDaemon> daemon(std::in_place, places.here);
  auto program =
      std::async(std::launch::async, [&] { return run_child(command_line(CANSYNC_C_FACE_RESTART, places)); });
  EXPECT_TRUE(comes(*daemon, 1));
  daemon.reset();
  daemon.emplace(places.here);
  EXPECT_TRUE(comes(*daemon, 3));
  daemon->change_mapping();
  EXPECT_TRUE(comes(*daemon, 5));
  const Child child = program.get();
  EXPECT_EQ(child.exit_code, 0) << child.output;

  const auto taken = daemon->references();
  const auto refused = daemon->refused_references();
  EXPECT_EQ(std::count(taken.begin(), taken.end(), 1), 0) << "moves after the restart";
  for (const std::int32_t told : {2, 4}) {
    EXPECT_EQ(std::count(taken.begin(), taken.end(), told), 0) << told << " moves";
    EXPECT_EQ(std::count(refused.begin(), refused.end(), told), 0) << told << " was written";
  }
}

}  // namespace
