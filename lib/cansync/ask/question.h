#pragma once

#include <cstdint>
#include <variant>

#include "can/frame.h"
#include "cansync/telegram/numbers.h"

/// What may be asked on a line that nobody knows: nothing else has a type here, so that no SYNC, action,
/// write, download or reference value can leave. Pure; realtime safe.
namespace cansync::ask {

/// Reads the value of one parameter of a slave itself (M 3.2.1.3).
struct ReadQuestion {
  SlaveNumber slave;
  ParameterNumber number;
  friend bool operator==(const ReadQuestion&, const ReadQuestion&) = default;
};

/// Begins an upload of one block and asks for none of its bytes: does the slave take blocks of that length?
/// When it does, a `CloseQuestion` has to follow.
struct BlockQuestion {
  SlaveNumber slave;
  BlockOffset length;                     ///< bytes, over 0: 0 would close
  std::uint32_t address = kFirstAddress;  ///< those below belong to the slave's operating system
  static constexpr std::uint32_t kFirstAddress = 0x100;
  friend bool operator==(const BlockQuestion&, const BlockQuestion&) = default;
};

/// Closes the upload that a `BlockQuestion` has begun.
struct CloseQuestion {
  SlaveNumber slave;
  friend bool operator==(const CloseQuestion&, const CloseQuestion&) = default;
};

using Question = std::variant<ReadQuestion, BlockQuestion, CloseQuestion>;

/// The slave that is asked.
SlaveNumber asked_slave(const Question& question) noexcept;

/// The question as a frame: a parameter read, or the initialisation of an upload.
can::Frame frame_of(const Question& question) noexcept;

}  // namespace cansync::ask
