#include <gtest/gtest.h>

#include "client/child.h"
#include "client/fake_daemon.h"
#include "support/dds_places.h"

/// Runs the C program c_face_test.c, linked with the shared library, against the fake daemon.
namespace {

TEST(CFace, EveryCheckOfTheCProgramHolds) {
  const TwoPlaces places;
  FakeDaemon daemon(places.here);
  daemon.publish_actual(2, 0xABCD);
  daemon.publish_event(17);
  const Child child = run_child(std::string(CANSYNC_C_FACE) + " " + std::to_string(places.here.domain) + " " +
                                places.here.partition);
  EXPECT_EQ(child.exit_code, 0) << child.output;

  const auto commands = daemon.commands();
  ASSERT_EQ(commands.size(), 4u);
  EXPECT_EQ(commands[0].kind, cansync_COMMAND_CONTROL_WORD);
  EXPECT_EQ(commands[0].control_word, 0x0Fu);
  EXPECT_EQ(commands[1].kind, cansync_COMMAND_BROADCAST);
  EXPECT_EQ(commands[1].slave_mask, 3u);
  EXPECT_EQ(commands[2].mode, cansync_MODE_RUN);
  EXPECT_TRUE(commands[2].force);
  EXPECT_EQ(commands[3].kind, cansync_COMMAND_RELEASE);
}

}  // namespace
