#pragma once

#include <memory>
#include <string>

#include "can/frame.h"
#include "can/raw_socket.h"
#include "cansync/telegram/numbers.h"

namespace cansync::cli {

/// A line on which questions are asked: a clock, frames of others, and what sends. A test stands in for it.
/// One thread.
class LinePort {
 public:
  virtual ~LinePort() = default;
  /// A clock that never falls.
  virtual Duration now() = 0;
  /// Sleeps until `deadline` or a frame, and not much longer than 20 ms.
  virtual void wait(Duration deadline) = 0;
  /// Takes the oldest frame of somebody else; false: there is none.
  virtual bool receive(can::Frame& out) = 0;
  /// Hands a frame over at once, or says why not.
  virtual can::SocketResult send(const can::Frame& frame) = 0;
};

/// A CAN interface of the kernel. Throws std::runtime_error with the remedy when it cannot be opened.
std::unique_ptr<LinePort> open_line_port(const std::string& interface);

}  // namespace cansync::cli
