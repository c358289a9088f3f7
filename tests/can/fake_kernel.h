#pragma once

#include <gtest/gtest.h>
#include <linux/can.h>
#include <linux/can/raw.h>
#include <linux/errqueue.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "can/link_kernel.h"
#include "can/socketcan/kernel.h"

namespace can::test {

/// A frame on its way to a socket.
struct Arriving {
  can_frame frame{};
  bool own = false;
  std::optional<Time> software;        ///< CLOCK_REALTIME
  std::optional<Time> hardware;        ///< any clock
  std::optional<std::uint32_t> drops;  ///< of the socket so far
  std::size_t size = sizeof(can_frame);
};

/// Stands in for the kernel: time passes with sleeping alone, and every call is counted by its name.
class FakeKernel : public Kernel {
 public:
  Time now{1'000'000'000};
  Time wall_offset{500'000'000'000};  ///< CLOCK_REALTIME - CLOCK_MONOTONIC
  int open_error = 0;                 ///< of the next socket
  std::set<int> sockets;              ///< that are open
  int bind_result = 0;
  int send_result = sizeof(can_frame);
  int receive_error = 0;   ///< what the next look says, once
  bool interrupt = false;  ///< the next sleep is ended by a signal
  std::deque<Arriving> arriving;
  std::vector<can_frame> sent;
  std::map<std::string, unsigned> calls;
  unsigned clock_readings = 0;  ///< of CLOCK_MONOTONIC
  Time reading_takes{};         ///< time that passes with each
  std::vector<can_filter> filters;
  std::map<std::pair<int, int>, int> options;
  std::vector<int> bound;
  unsigned total() const {
    unsigned sum = 0;
    for (const auto& [name, count] : calls) sum += count;
    return sum;
  }

  int open_socket() noexcept override {
    if (open_error != 0) return open_error;
    sockets.insert(next_socket_);
    return next_socket_++;
  }
  void close_socket(int socket) noexcept override { EXPECT_EQ(sockets.erase(socket), 1u) << socket; }
  int set_option(int, int level, int name, const void* value, std::size_t size) noexcept override {
    ++calls["setsockopt"];
    if (level == SOL_CAN_RAW && name == CAN_RAW_FILTER) {
      const auto* first = static_cast<const can_filter*>(value);
      filters.assign(first, first + size / sizeof(can_filter));
    } else {
      int number = 0;
      std::memcpy(&number, value, std::min(size, sizeof(number)));
      options[{level, name}] = number;
    }
    return 0;
  }
  int bind_to(int, int interface) noexcept override {
    ++calls["bind"];
    if (bind_result >= 0) bound.push_back(interface);
    return bind_result;
  }
  int send_frame(int socket, const can_frame& frame) noexcept override {
    EXPECT_TRUE(sockets.contains(socket)) << socket;
    ++calls["send"];
    if (send_result == static_cast<int>(sizeof(can_frame))) sent.push_back(frame);
    return send_result;
  }
  int receive(int socket, mmsghdr* messages, unsigned count) noexcept override {
    EXPECT_TRUE(sockets.contains(socket)) << socket;
    ++calls["recvmmsg"];
    if (receive_error != 0) return std::exchange(receive_error, 0);
    unsigned taken = 0;
    for (; taken < count && !arriving.empty(); ++taken) {
      write(arriving.front(), messages[taken]);
      arriving.pop_front();
    }
    return taken == 0 ? -EAGAIN : static_cast<int>(taken);
  }
  int sleep_until(Time deadline) noexcept override {
    ++calls["clock_nanosleep"];
    if (std::exchange(interrupt, false)) return -EINTR;
    now = std::max(now, deadline);
    return 0;
  }
  int wait_readable(int, Time timeout) noexcept override {
    ++calls["ppoll"];
    if (std::exchange(interrupt, false)) return -EINTR;
    if (!arriving.empty()) return 1;
    now += timeout;
    return 0;
  }
  Time monotonic() noexcept override {
    ++clock_readings;
    return now += reading_takes;
  }
  Time realtime() noexcept override { return (now += reading_takes) + wall_offset; }

 private:
  int next_socket_ = 7;

  static timespec stamp(const std::optional<Time>& time) {
    if (!time) return {0, 0};
    return {static_cast<time_t>(time->count() / 1'000'000'000),
            static_cast<long>(time->count() % 1'000'000'000)};
  }

  static void write(const Arriving& from, mmsghdr& to) {
    std::memcpy(to.msg_hdr.msg_iov->iov_base, &from.frame, sizeof(can_frame));
    to.msg_len = static_cast<unsigned>(from.size);
    to.msg_hdr.msg_flags = from.own ? MSG_CONFIRM | MSG_DONTROUTE : 0;
    cmsghdr* part = CMSG_FIRSTHDR(&to.msg_hdr);
    std::size_t used = 0;
    const auto add = [&](int type, const auto& value) {
      part->cmsg_level = SOL_SOCKET;
      part->cmsg_type = type;
      part->cmsg_len = CMSG_LEN(sizeof(value));
      std::memcpy(CMSG_DATA(part), &value, sizeof(value));
      used += CMSG_SPACE(sizeof(value));
      part = CMSG_NXTHDR(&to.msg_hdr, part);
    };
    std::memset(to.msg_hdr.msg_control, 0, to.msg_hdr.msg_controllen);
    if (from.drops) add(SO_RXQ_OVFL, *from.drops);
    if (from.software || from.hardware) {
      scm_timestamping stamps{};
      stamps.ts[0] = stamp(from.software);
      stamps.ts[2] = stamp(from.hardware);
      add(SO_TIMESTAMPING, stamps);
    }
    to.msg_hdr.msg_controllen = used;
  }
};

/// Stands in for the interfaces of the kernel: there is one, as `facts` says.
class FakeLinks final : public LinkKernel {
 public:
  LinkFacts facts;
  int restart_result = 0;
  int set_up_result = 0;
  int up_result = 0;  ///< of setting it up alone
  unsigned interrupts = 0;
  std::vector<std::string> asked;
  std::function<void(bool)> on_set_up = [](bool) {};
  std::function<void()> on_wait = [] {};

  LinkFacts read(const std::string&) noexcept override { return facts; }
  void wait(std::chrono::milliseconds) noexcept override { on_wait(); }
  void interrupt() noexcept override { ++interrupts; }
  int restart(std::uint32_t index) noexcept override {
    asked.push_back("restart " + std::to_string(index));
    if (restart_result == 0) facts.state = ControllerState::error_active;
    return restart_result;
  }
  int set_up(std::uint32_t index, bool up) noexcept override {
    asked.push_back((up ? "up " : "down ") + std::to_string(index));
    const int result = up && up_result != 0 ? up_result : set_up_result;
    if (result == 0) {
      facts.up = up;
      on_set_up(up);
    }
    return result;
  }
};

/// An interface `can0` with index 5, up, at `bits_per_second`.
inline LinkFacts can0(std::uint32_t bits_per_second = 1'000'000) {
  LinkFacts facts;
  facts.present = true;
  facts.index = 5;
  facts.is_can = true;
  facts.up = true;
  facts.timing = LinkTiming{bits_per_second, 600};
  facts.state = ControllerState::error_active;
  facts.restart_ms = 0;
  return facts;
}

}  // namespace can::test
