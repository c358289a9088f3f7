#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <span>

#include "cansync/slave/slave.h"
#include "cansync/telegram/errors.h"
#include "cansync/telegram/numbers.h"
#include "cansync/telegram/telegram.h"

namespace cansync {

/// Bytes of the block area: 75 doublewords (M 3.2.3.7).
inline constexpr std::uint16_t kBlockAreaBytes = 300;

/// A block that the master has begun.
struct AskedBlock {
  using Direction = TransferInitialise::Direction;
  std::uint64_t id = 0;  ///< never given twice
  Direction direction = Direction::upload;
  std::uint32_t address = 0;  ///< start address as the master says it, 0x100 and over
  std::uint16_t length = 0;   ///< bytes; an upload may leave it to the slave: 0
  bool area = false;          ///< the block is moved as a whole, else telegram by telegram
};

/// One telegram of a block that is moved telegram by telegram (O 7.2.3).
struct AskedStep {
  std::uint16_t offset = 0;            ///< of its first byte in the block
  std::uint8_t bytes = 0;              ///< 1..6
  std::array<std::uint8_t, 6> data{};  ///< of a download
};

/// Why a block is over.
enum class BlockEnd : std::uint8_t {
  done,         ///< the answer to its last telegram was on the bus
  cancelled,    ///< the master cancelled it, began another one, or the slave left synchronous operation
  refused,      ///< the application refused it
  timed_out,    ///< nothing of it moved for the monitoring time
  application,  ///< the application is gone
};

/// Is told of the blocks that wait for an application. Called on the slave's thread; must not allocate,
/// block or throw, nor call back.
class BlockAreaListener {
 public:
  virtual ~BlockAreaListener() = default;
  /// Status 0x55 or 0x05: the block waits for `allow` or `refuse`.
  virtual void block_begun(const AskedBlock& block) noexcept = 0;
  /// Status 0x5D: a whole download lies in the area and waits for `take` or `refuse`.
  virtual void block_complete(std::uint64_t id) noexcept = 0;
  /// A telegram of a block without area waits for `step` or `refuse`.
  virtual void step_asked(std::uint64_t id, const AskedStep& step) noexcept = 0;
  /// The block is over; said once for each that was begun.
  virtual void block_ended(std::uint64_t id, BlockEnd end) noexcept = 0;
};

/// How blocks reach the application.
struct BlockAreaSettings {
  bool area = true;  ///< b_EN_UPDOWNBLK1: blocks of up to 300 bytes go through the area
  Duration monitoring = std::chrono::seconds(30);  ///< in which something of a block has to move; 0: none
};

/// The transfer part of a slave's application (M 3.2.3.7, O 7.2.3): whole blocks in an area of 300 bytes, or
/// every telegram by itself, for an application that answers when it likes; the master is answered busy
/// meanwhile. One block is open at a time. Without an application every block is refused as 0x0104; when it
/// goes, and when the monitoring time is over, the open one ends with 0x0103. Addresses 0x00 to 0xFF are the
/// operating system's, and there are no sub-slaves. Nothing allocates, blocks or throws; not thread safe.
class BlockArea {
 public:
  using BlockAnswer = SlaveApplication::BlockAnswer;

  /// `listener` must outlive the area.
  BlockArea(const BlockAreaSettings& settings, BlockAreaListener& listener) noexcept
      : settings_(settings), listener_(listener) {}

  // --- of the slave, from its `SlaveApplication`

  /// The slave's `begin_block`; asked again with the same telegram while it answers busy.
  BlockAnswer begin(const TransferInitialise& initialise) noexcept;
  /// The slave's `read_block`, likewise.
  BlockAnswer read(std::uint16_t offset, std::span<std::uint8_t> out) noexcept;
  /// The slave's `write_block`, likewise.
  BlockAnswer write(std::uint16_t offset, std::span<const std::uint8_t> data) noexcept;
  /// The slave's `end_block`.
  void end(bool complete) noexcept;
  /// The answer was on the bus (`SlaveApplication::transfer_answered`).
  void sent() noexcept;

  /// It was not, and the master waits for it no more (`SlaveApplication::transfer_dropped`).
  void dropped() noexcept;

  /// Tells the time, on any one clock, in every interval; ends a block whose monitoring time is over, also
  /// one whose last answer was never on the bus.
  void at(Duration now) noexcept;

  // --- of the application; false: that block does not wait for it

  /// There is one (its lease runs), or there is none (any more).
  void set_application(bool present) noexcept;
  /// The block may be moved. An upload through the area brings all of its data, 1..300 bytes, which is then
  /// its length; one without area may fix its length, 0: as asked.
  bool allow(std::uint64_t id, std::span<const std::uint8_t> upload = {}, std::uint16_t length = 0) noexcept;
  /// The block is refused or ends with an error; 0x0100 and over (M 3.2.3.7), others count as 0x0104.
  bool refuse(std::uint64_t id, TransferError error) noexcept;
  /// The data of a whole download were taken.
  bool take(std::uint64_t id) noexcept;
  /// The telegram asked for last is done; of an upload with its bytes, as many as were asked for.
  bool step(std::uint64_t id, std::span<const std::uint8_t> upload = {}) noexcept;

  /// The bytes of the block in the area, whole once it is complete.
  std::span<const std::uint8_t> data() const noexcept { return std::span(area_).first(length_); }
  /// Bytes moved so far (w_COUNTER_UPDOWNBLK1).
  std::uint16_t counter() const noexcept { return counter_; }
  /// The block that is open; its id is 0 when there is none.
  const AskedBlock& open() const noexcept { return block_; }

 private:
  enum class Phase : std::uint8_t {
    none,
    asked,     ///< waits for allow or refuse
    allowed,   ///< allowed; the master has not been told yet
    moving,    ///< telegrams move
    waiting,   ///< the end of a download, or a single telegram, waits for the application
    answered,  ///< the application has answered that
    ended,     ///< over, with an error that the master still has to learn
  };

  BlockAnswer failure() const noexcept;
  bool waits_for(std::uint64_t id) const noexcept { return id != 0 && block_.id == id; }
  BlockAnswer ask_step(const AskedStep& step) noexcept;
  void fail(TransferError error, BlockEnd end) noexcept;
  void end_sending(BlockEnd end) noexcept;
  void progress() noexcept { moved_ = now_; }

  BlockAreaSettings settings_;
  BlockAreaListener& listener_;
  bool application_ = false;
  Phase phase_ = Phase::none;
  AskedBlock block_;
  std::uint16_t length_ = 0;
  std::uint16_t counter_ = 0;
  AskedStep step_;
  TransferError error_ = TransferError::none;
  std::uint64_t sending_ = 0;  ///< the block whose last answer is on its way
  std::uint64_t ids_ = 0;
  Duration now_{};
  Duration moved_{};
  std::array<std::uint8_t, kBlockAreaBytes> area_ = {};
};

}  // namespace cansync
