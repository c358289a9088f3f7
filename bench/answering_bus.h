#pragma once

#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <ctime>
#include <system_error>

#include "can/bus.h"
#include "cansync/telegram/telegram.h"

namespace bench {

/// A bus that costs a daemon what an interface costs: every telegram is written to a socket and read back
/// from it with its echo's system call, and each slave that is asked answers at once. There is no simulation
/// to be paid for by the realtime thread: frames are "received" at the very instant they are taken.
class AnsweringBus final : public can::Bus {
 public:
  AnsweringBus() {
    if (::socketpair(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK, 0, sockets_.data()) != 0) {
      throw std::system_error(errno, std::generic_category(), "socketpair");
    }
  }
  ~AnsweringBus() override {
    for (const int socket : sockets_) ::close(socket);
  }
  AnsweringBus(const AnsweringBus&) = delete;
  AnsweringBus& operator=(const AnsweringBus&) = delete;

  can::Time now() noexcept override {
    timespec time{};
    ::clock_gettime(CLOCK_MONOTONIC, &time);
    return std::chrono::seconds(time.tv_sec) + can::Time(time.tv_nsec);
  }

  can::Wake wait_until(can::Time deadline) noexcept override {
    const timespec at{deadline.count() / 1'000'000'000, deadline.count() % 1'000'000'000};
    ::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, nullptr);
    return can::Wake::deadline;
  }

  bool receive(can::ReceivedFrame& out) noexcept override {
    if (taken_ == waiting_) {
      taken_ = waiting_ = 0;
      return false;
    }
    if (taken_ == 0) drain();
    out = frames_[taken_++];
    out.end = now();
    return true;
  }

  can::SendResult send(const can::Frame& frame) noexcept override {
    if (::write(sockets_[0], frame.data.data(), frame.data.size()) < 0) return can::SendResult::queue_full;
    put(frame, true);
    const cansync::Decoded decoded = cansync::decode(frame);
    if (const auto* telegram = std::get_if<cansync::Telegram>(&decoded)) answer(*telegram);
    return can::SendResult::queued;
  }

  can::ControllerStatus status() noexcept override { return {}; }
  can::ResetResult reset() noexcept override { return can::ResetResult::done; }
  can::ResetResult reset_result() noexcept override { return can::ResetResult::done; }
  can::TimestampSource timestamp_source() noexcept override { return can::TimestampSource::thread; }

 private:
  void drain() noexcept {
    std::array<std::uint8_t, 64> echo;
    while (::recv(sockets_[1], echo.data(), echo.size(), 0) > 0) {
    }
  }

  void put(const can::Frame& frame, bool own) noexcept {
    if (waiting_ == frames_.size()) return;
    frames_[waiting_].frame = frame;
    frames_[waiting_++].own = own;
  }

  void answer(const cansync::Telegram& telegram) noexcept {
    if (const auto* reference = std::get_if<cansync::ReferenceTelegram>(&telegram)) {
      const auto slave = cansync::SlaveNumber::from(reference->polled);
      if (slave)
        put(cansync::encode(cansync::ActualTelegram{reference->channel, *slave, 4, reference->word}), false);
    } else if (const auto* command = std::get_if<cansync::ParameterCommand>(&telegram)) {
      // A status word with bit 15: synchronized.
      put(cansync::encode(
              cansync::ParameterReply{command->slave, command->number, false, false, 2, {0x00, 0x80}}),
          false);
    }
  }

  std::array<int, 2> sockets_ = {-1, -1};
  std::array<can::ReceivedFrame, 16> frames_ = {};
  std::size_t waiting_ = 0;
  std::size_t taken_ = 0;
};

}  // namespace bench
