#include "cli/scan/line_port.h"

#include <fmt/format.h>
#include <poll.h>

#include <algorithm>
#include <stdexcept>
#include <system_error>

#include "system/clock.h"

namespace cansync::cli {
namespace {

/// Ctrl-C is noticed so soon.
constexpr Duration kLongestSleep = std::chrono::milliseconds(20);

class SocketLinePort final : public LinePort {
 public:
  explicit SocketLinePort(const std::string& interface) {
    const can::SocketResult opened = socket_.open(interface);
    if (opened == can::SocketResult::done) return;
    if (opened == can::SocketResult::no_can)
      throw std::runtime_error("this kernel has no CAN sockets; `modprobe can_raw` loads them");
    throw std::runtime_error(
        fmt::format("{}: {}", interface,
                    opened == can::SocketResult::interface_gone
                        ? "there is no such CAN interface; `ip -br link show type can` lists them"
                        : std::generic_category().message(socket_.error())));
  }

  Duration now() override { return sys::read_clock(CLOCK_MONOTONIC); }

  void wait(Duration deadline) override {
    const Duration left = std::clamp<Duration>(deadline - now(), Duration{0}, kLongestSleep);
    const auto nanoseconds = left.count();
    const timespec time{nanoseconds / 1'000'000'000, nanoseconds % 1'000'000'000};
    pollfd ready{socket_.descriptor(), POLLIN, 0};
    ::ppoll(&ready, 1, &time, nullptr);
  }

  bool receive(can::Frame& out) override {
    can::ReceivedFrame received;
    if (socket_.receive(received) != can::SocketResult::done) return false;
    out = received.frame;
    return true;
  }

  can::SocketResult send(const can::Frame& frame) override { return socket_.send(frame); }

 private:
  can::RawSocket socket_;
};

}  // namespace

std::unique_ptr<LinePort> open_line_port(const std::string& interface) {
  return std::make_unique<SocketLinePort>(interface);
}

}  // namespace cansync::cli
