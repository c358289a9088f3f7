// The station on the SocketCAN bus, with a kernel that gives each frame back at once.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "can/fake_kernel.h"
#include "can/link_watch.h"
#include "can/socketcan/socketcan_bus.h"
#include "daemon/bus/socketcan_line.h"
#include "daemon/layer2/segment/layer2_segment.h"
#include "frame_machine_rig.h"

namespace cansyncd::layer2_test {
namespace {

class EchoingKernel final : public can::test::FakeKernel {
 public:
  int send_frame(int socket, const can_frame& frame) noexcept override {
    can::test::Arriving echo;
    echo.frame = frame;
    echo.own = true;
    echo.software = now + wall_offset;
    arriving.push_back(echo);
    sent_at.push_back(now);
    return FakeKernel::send_frame(socket, frame);
  }
  std::vector<can::Time> sent_at;
};

BusPlan of_a_configuration() {
  Layer2Config config;
  config.bus.kind = BusKind::socketcan;
  config.bus.interface = "can0";
  return Layer2Parts::bus_plan(config);
}

TEST(FrameMachine, AllTimersDueAtOnceSendAtOnce) {
  FrameMachineSettings settings = everything();
  std::string script;
  for (unsigned number = 1; number <= layer2::Timers::kMost; ++number) {
    layer2::TimerSettings timer;
    timer.frame = data_frame(0x200 + number, {});
    timer.period = milliseconds(10);
    settings.module.timers[number - 1] = timer;
    script += "Start " + std::to_string(number) + "\n";
  }
  settings.module.run = layer2::parse_script(script);
  EchoingKernel kernel;
  can::test::FakeLinks links;
  links.facts = can::test::can0();
  can::LinkBoard board;
  const BusPlan plan = of_a_configuration();
  can::BusSockets sockets(plan.filters, kernel);
  can::LinkWatch watch(links, board, sockets, {"can0", 1'000'000});
  watch.look();
  can::SocketcanBus bus(socketcan_settings(plan), board, links, kernel);
  Layer2Exchange exchange(16, 64);
  FrameMachine machine(settings, bus, exchange);
  DeadlineLoop<FrameMachine> loop(machine, bus);
  loop.begin();
  const can::Time end = kernel.now + milliseconds(31);
  while (kernel.now < end) loop.turn(end);
  loop.end();
  ASSERT_EQ(kernel.sent_at.size(), 4 * layer2::Timers::kMost) << "at 0, 10, 20 and 30 ms";
  // At the start one frame alone shows that somebody acknowledges (`can::EchoGuard`).
  for (std::size_t first = layer2::Timers::kMost; first < kernel.sent_at.size();
       first += layer2::Timers::kMost) {
    EXPECT_EQ(kernel.sent_at[first + layer2::Timers::kMost - 1] - kernel.sent_at[first], can::Time{0});
  }
}

}  // namespace
}  // namespace cansyncd::layer2_test
