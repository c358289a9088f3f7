// The simulator program's loop on a scripted interface in virtual time.

#include "simulator/run.h"

#include <gtest/gtest.h>
#include <linux/can.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <csignal>

#include "rig.h"
#include "simulator/drive_log.h"
#include "simulator/socket_port.h"

namespace {

using namespace std::chrono_literals;
using cansync_sim::Bench;
using cansync_sim::Link;
using Sent = ScriptedPort::Sent;

class RunTest : public testing::Test {
 protected:
  void run(Bench& bench, bool verbose = false) {
    const auto remark = [&](const std::string& line) { said_.push_back(line); };
    cansync_sim::DriveLog log(bench, remark);
    cansync_sim::run(bench, port_,
                     {"vcan7", remark, verbose ? [&] { log.look(); } : std::function<void()>()});
  }

  ScriptedPort port_;
  std::vector<std::string> said_;
};

TEST_F(RunTest, AnswersAtOnceAndStopsWhenAsked) {
  Bench bench(bench_settings(), drives({3}));
  port_.arrives(1ms, "080#");
  port_.arrives(2ms, "503#70670000");
  port_.stops(10ms);
  run(bench);
  EXPECT_EQ(port_.sent(), (std::vector<Sent>{{2ms, "583#006703000000"}}));
  EXPECT_EQ(said_, std::vector<std::string>{});
  EXPECT_EQ(
      cansync_sim::summary(bench, 4),
      "1 drive, 1 SYNC, 1 frame received, 1 sent, 0 not sent, 0 answers too late, 0 error frames, 4 frames "
      "lost by the kernel, 0 foreign frames without room");
}

TEST_F(RunTest, WakesForALateAnswer) {
  sim::Fault late;
  late.kind = sim::FaultKind::late;
  late.delay = 300us;
  Bench bench(bench_settings({late}), drives({3}));
  port_.arrives(1ms, "080#");
  port_.arrives(2ms, "503#70670000");
  port_.stops(10ms);
  run(bench);
  EXPECT_EQ(port_.sent(), (std::vector<Sent>{{2300us, "583#006703000000"}}));
}

TEST_F(RunTest, ALostInterfaceIsToldOnceAndWaitedFor) {
  Bench bench(bench_settings(), drives({3}));
  port_.arrives(1ms, "080#");
  port_.link_becomes(2ms, Link::down);
  port_.link_becomes(3ms, Link::down);
  port_.link_becomes(4ms, Link::missing);
  port_.link_becomes(5ms, Link::up);
  port_.arrives(6ms, "503#70670000");
  port_.stops(10ms);
  run(bench);
  ASSERT_EQ(said_.size(), 3u);
  EXPECT_EQ(said_[0].substr(0, 34), "vcan7 is down; waiting for it. ip ");
  EXPECT_NE(said_[1].find("vcan7 does not exist; waiting for it."), std::string::npos);
  EXPECT_NE(said_[1].find("ip link add dev vcan7 type vcan"), std::string::npos);
  EXPECT_EQ(said_[2], "vcan7 is up; on the bus again");
  EXPECT_EQ(port_.sent().size(), 1u);
}

TEST_F(RunTest, CountsWhatTheInterfaceDoesNotTake) {
  Bench bench(bench_settings(), drives({3}));
  port_.arrives(1ms, "503#70670000");
  port_.sending_becomes(0ms, can::SendResult::queue_full);
  port_.stops(10ms);
  run(bench);
  EXPECT_EQ(bench.counters().not_sent, 1u);
  EXPECT_EQ(bench.counters().sent, 0u);
}

TEST_F(RunTest, VerboseTellsEveryChangeOfADrive) {
  Bench bench(bench_settings(), drives({3}));
  port_.arrives(0ms, "010#FFFFFFFF02010000");
  for (int n = 0; n < 7; ++n) port_.arrives(1ms + n * 2ms, "080#");
  port_.arrives(15ms, "010#0800000001000300");  // control word 0x0003
  port_.arrives(15ms, "010#0800000080000500");  // provoke fault 5
  port_.arrives(15ms, "080#");
  port_.stops(100ms);
  run(bench, true);
  EXPECT_EQ(said_, (std::vector<std::string>{
                       "SYNC 0: drive 3 was activated", "SYNC 5: drive 3 is synchronized",
                       "SYNC 7: drive 3 has control word 0x0003", "SYNC 7: drive 3 has fault 5"}));
}

/// The real port on a pair of sockets. SIGTERM comes while `frames` frames wait to be taken; the process ends
/// with 0 when the loop does.
void stop_while_frames_wait(int frames) {
  ::alarm(20);  // what hangs is killed
  std::array<int, 2> ends{};
  if (::socketpair(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK, 0, ends.data()) != 0) ::_exit(2);
  cansync_sim::SocketPort port("pair", ends[0]);
  Bench bench(bench_settings(), drives({3}));
  const can_frame sync{.can_id = 0x080, .len = 0};
  for (int i = 0; i < frames; ++i) {
    if (::write(ends[1], &sync, sizeof sync) != sizeof sync) ::_exit(3);
  }
  ::raise(SIGTERM);
  cansync_sim::run(bench, port, {"pair", [](const std::string&) {}});
  ::_exit(0);
}

TEST(SocketPort, StopsAtOnceWithNothingToReceive) {
  EXPECT_EXIT(stop_while_frames_wait(0), testing::ExitedWithCode(0), "");
}

// A signal is not delivered to a wait that has something to return, so the loop must look at what is pending.
TEST(SocketPort, StopsAtOnceWhileFramesWait) {
  EXPECT_EXIT(stop_while_frames_wait(5), testing::ExitedWithCode(0), "");
}

}  // namespace
