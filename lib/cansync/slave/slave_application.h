#pragma once

#include <cstdint>
#include <span>

#include "cansync/telegram/errors.h"
#include "cansync/telegram/numbers.h"
#include "cansync/telegram/telegram.h"

namespace cansync {

/// Answer of a slave's application to one parameter access.
struct ParameterAnswer {
  bool busy = false;  ///< not ready: the master asks again
  ParameterError error = ParameterError::none;
  bool doubleword = false;  ///< format of the parameter
  std::uint32_t value = 0;  ///< read: the value

  /// It takes longer.
  static ParameterAnswer later() noexcept { return {.busy = true}; }
  /// With an error number.
  static ParameterAnswer refused(ParameterError error) noexcept { return {.error = error}; }
};

/// What stands behind a slave: parameters, memory and control word. Called on the slave's thread; must not
/// allocate, block or throw, nor call the slave.
class SlaveApplication {
 public:
  /// Answer to one step of an upload or download.
  struct BlockAnswer {
    bool busy = false;  ///< not ready: the master sends the same telegram again
    TransferError error =
        TransferError::none;   ///< `cancelled_by_slave` closes the block, others leave it open
    std::uint16_t length = 0;  ///< `begin_block` of an upload: length fixed by the slave; 0 = as asked

    /// It takes longer.
    static BlockAnswer later() noexcept { return {.busy = true}; }
    /// With an error number.
    static BlockAnswer refused(TransferError error) noexcept { return {.error = error}; }
  };

  virtual ~SlaveApplication() = default;

  /// Reads element 0..7 of a parameter; 7 is the value.
  virtual ParameterAnswer read_parameter(ParameterNumber number, Element element, SubSlave sub) noexcept = 0;

  /// Writes a parameter; the element is always 7 (others are refused before). Answers `wrong_format` when
  /// `doubleword` is not the parameter's format.
  virtual ParameterAnswer write_parameter(ParameterNumber number, Element element, SubSlave sub,
                                          bool doubleword, std::uint32_t value) noexcept = 0;

  /// The parameter access answered busy last is dropped: the master has asked for another one. Also when the
  /// slave leaves synchronous operation, for one whose answer was not on the bus.
  virtual void parameter_dropped() noexcept {}

  /// The write answered last comes again, and its answer was never on the bus. False: that was too long ago,
  /// and it is a write of its own; else it gets the same answer.
  virtual bool keeps_answer() noexcept { return true; }

  /// Begins a block. For an upload the answer may fix another length, 1..4095 bytes. Asked again with the
  /// same telegram while it answers busy.
  virtual BlockAnswer begin_block(const TransferInitialise& initialise) noexcept = 0;

  /// False: the block begun last is over by itself, and the master has not learnt it yet. The same beginning
  /// is then asked for again instead of being answered as before.
  virtual bool block_open() const noexcept { return true; }

  /// Fills up to 6 bytes at `offset` of the block begun last; `out` is as long as the block still has bytes.
  virtual BlockAnswer read_block(std::uint16_t offset, std::span<std::uint8_t> out) noexcept = 0;

  /// Takes up to 6 bytes at `offset` of the block begun last; padding of the last telegram is not in `data`.
  virtual BlockAnswer write_block(std::uint16_t offset, std::span<const std::uint8_t> data) noexcept = 0;

  /// The block is complete (`complete`), or it was cancelled or replaced. Also called with false for a block
  /// that `begin_block` answered busy and the master then dropped.
  virtual void end_block(bool complete) noexcept = 0;

  /// The answer to the parameter access, other than busy, was on the bus (M 3.2.3.7: bit 6 is cleared).
  virtual void parameter_answered() noexcept {}

  /// The answer to the newest transfer telegram, other than busy, was on the bus (bit 6 is cleared).
  virtual void transfer_answered() noexcept {}

  /// The answer to the last telegram of a complete block was not on the bus, and the master does not wait for
  /// it any more: it has cancelled the block or sent what is no part of one, or the slave left synchronous
  /// operation.
  virtual void transfer_dropped() noexcept {}

  /// The action "SYNC mode: activate" arrived, for the first time or again.
  virtual void sync_activated() noexcept {}

  /// A control word arrived (action command 1).
  virtual void control_word(std::uint16_t word) noexcept = 0;

  /// Any other action command 2..255 arrived, also that of "SYNC mode" with other data (M 3.2.3.7).
  virtual void action(std::uint8_t command, std::uint8_t data_byte, std::uint16_t data_word) noexcept = 0;
};

}  // namespace cansync
