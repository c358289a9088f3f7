#include "sync/pps.h"

#include <gtest/gtest.h>

#include <optional>

#include "sync/fake_system.h"

namespace {

using namespace sync_line;
using namespace sync_line::test;
using std::chrono::milliseconds;
using std::chrono::seconds;

/// The first edge of as many looks as cause a system call.
std::optional<Time> look(PpsInput& input) {
  std::optional<Time> found;
  Time at{0};
  for (unsigned i = 0; i < PpsInput::kLookEvery; ++i) {
    if (input.take(Time{0}, at)) found = at;
  }
  return found;
}

TEST(PpsInput, CarriesPulsesOverToTheMonotonicClock) {
  FakeSystem system;
  system.pulse_at(seconds(50));
  PpsInput input(system, {}, "sync.pps_device");
  EXPECT_FALSE(look(input)) << "a pulse of unknown age";
  system.pulse_at(seconds(101) + milliseconds(3));
  system.now = seconds(101) + milliseconds(9);
  EXPECT_EQ(look(input), Time(seconds(101) + milliseconds(3)));
  EXPECT_FALSE(look(input)) << "each pulse once";
  system.pulse_at(seconds(102) + milliseconds(3));
  EXPECT_EQ(look(input), Time(seconds(102) + milliseconds(3)));
}

TEST(PpsInput, LooksRarely) {
  FakeSystem system;
  PpsInput input(system, {}, "sync.pps_device");
  Time at{0};
  for (int i = 0; i < 1600; ++i) input.take(Time{0}, at);
  EXPECT_EQ(system.fetches, 100U);
}

TEST(PpsInput, AnEdgeThatCannotBeCapturedIsRefused) {
  FakeSystem system;
  EXPECT_EQ(refusal([&] {
              PpsInput(system, {FakeSystem::kPps, Edge::falling}, "sync.pps_device");
            }),
            "sync.pps_device: /dev/pps0 cannot capture the clear edge; choose the other one with "
            "sync.pps_edge");
}

TEST(PpsInput, TurnsCapturingOnWhereItIsOff) {
  FakeSystem system;
  system.pps_mode = 0;
  PpsInput input(system, {}, "sync.pps_device");
  EXPECT_NE(system.pps_mode & PPS_CAPTUREASSERT, 0);
  system.pps_mode = 0;
  system.control_error[PPS_SETPARAMS] = EPERM;
  EXPECT_NE(refusal([&] { PpsInput(system, {}, "sync.pps_device"); }).find("Operation not permitted"),
            std::string::npos);
}

TEST(PpsInput, MissingAndFailingDevicesAreTold) {
  FakeSystem system;
  EXPECT_NE(refusal([&] {
              PpsInput(system, {"/dev/pps5", Edge::rising}, "sync.pps_device");
            }).find("sync.pps_device: /dev/pps5: No such file or directory; plug"),
            std::string::npos);
  PpsInput input(system, {}, "sync.pps_device");
  system.control_error[PPS_FETCH] = EIO;
  EXPECT_FALSE(look(input));
  EXPECT_EQ(input.error(), EIO);
}

}  // namespace
