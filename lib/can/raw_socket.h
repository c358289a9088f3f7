#pragma once

#include <cstdint>
#include <string>

#include "can/bus.h"
#include "can/frame.h"
#include "system/descriptor.h"

namespace can {

/// What an operation on a raw socket came to.
enum class SocketResult : std::uint8_t {
  done,
  nothing,         ///< no frame is waiting
  queue_full,      ///< no room on the way to the controller; leave the frame out
  interface_down,  ///< the interface is there but not up; the socket works again when it is
  interface_gone,  ///< the interface does not exist (any more); close, and open when it is back
  no_can,          ///< this kernel has no CAN sockets
  failed,          ///< anything else; `RawSocket::error` has the system's number
};

/// One raw CAN socket (AF_CAN, CAN_RAW) on one network interface, never blocking. All classic frames are
/// received, error frames too; own frames are not. Times come from the kernel's receive time stamp, moved to
/// CLOCK_MONOTONIC. Not thread safe; nothing allocates or throws after `open`.
class RawSocket {
 public:
  /// Opens and binds to `interface` (1..15 characters); closes what was open before. `done`,
  /// `interface_gone`, `no_can` or `failed`. An interface that is down can be opened.
  SocketResult open(const std::string& interface) noexcept;
  /// Takes over a socket of somebody else that carries frames as those of the kernel do and belongs to no
  /// interface: a stand-in for a bus. It must not block; its link is always up.
  void adopt(int descriptor) noexcept;
  void close() noexcept;
  bool is_open() const noexcept { return socket_.is_open(); }

  /// Descriptor for `poll`; -1 while closed.
  int descriptor() const noexcept { return socket_.number(); }
  /// `errno` of the operation that failed last.
  int error() const noexcept { return error_; }
  /// Frames the kernel has dropped because nobody took them in time, since `open`.
  std::uint64_t dropped() const noexcept { return dropped_; }

  /// Takes the oldest received frame: `done`, `nothing`, `interface_down`, `interface_gone` or `failed`.
  SocketResult receive(ReceivedFrame& out) noexcept;

  /// Hands a frame over: `done`, `queue_full`, `interface_down`, `interface_gone` or `failed`. Error frames
  /// cannot be sent.
  SocketResult send(const Frame& frame) noexcept;

  /// The interface's state now: `done` (up), `interface_down`, `interface_gone` or `failed`. A closed socket
  /// is `interface_gone`.
  SocketResult link() noexcept;

 private:
  SocketResult failure(int error) noexcept;

  sys::Descriptor socket_;
  int index_ = 0;  // of the interface; 0: none
  int error_ = 0;
  std::uint64_t dropped_ = 0;
};

}  // namespace can
