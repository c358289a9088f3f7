#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "can/frame.h"
#include "cansync/errors.h"
#include "cansync/mapping.h"
#include "cansync/mode.h"
#include "cansync/numbers.h"
#include "cansync/telegram.h"
#include "cansync/timing.h"

namespace cansync {

/// Answer of a slave's application to one parameter access.
struct ParameterAnswer {
  bool busy = false;  ///< not ready: the master asks again
  ParameterError error = ParameterError::none;
  bool doubleword = false;  ///< format of the parameter
  std::uint32_t value = 0;  ///< read: the value
};

/// What stands behind a slave: parameters, memory and control word. Called on the slave's thread; must not
/// allocate, block or throw.
class SlaveApplication {
 public:
  virtual ~SlaveApplication() = default;
  virtual ParameterAnswer read_parameter(ParameterNumber number, Element element, SubSlave sub) noexcept = 0;
  virtual ParameterAnswer write_parameter(ParameterNumber number, Element element, SubSlave sub,
                                          bool doubleword, std::uint32_t value) noexcept = 0;
  /// Begins a block of `length` bytes. `length` may be set by the application for an upload (0 = as asked).
  /// `busy` and errors as told by the return value.
  struct BlockAnswer {
    bool busy = false;
    TransferError error = TransferError::none;
    std::uint16_t length = 0;  ///< upload: length fixed by the slave; 0 = as asked
  };
  virtual BlockAnswer begin_block(const TransferInitialise& initialise) noexcept = 0;
  /// Fills or takes up to 6 bytes at `offset` of the block begun last.
  virtual BlockAnswer read_block(std::uint16_t offset, std::span<std::uint8_t> out) noexcept = 0;
  virtual BlockAnswer write_block(std::uint16_t offset, std::span<const std::uint8_t> data) noexcept = 0;
  /// The block is complete, or was cancelled.
  virtual void end_block(bool complete) noexcept = 0;
  virtual void control_word(std::uint16_t word) noexcept = 0;
  virtual void action(std::uint8_t command, std::uint8_t data_byte, std::uint16_t data_word) noexcept = 0;
};

/// Settings of one slave.
struct SlaveSideSettings {
  SlaveNumber number;
  BitRate bit_rate = BitRate::mbit1;
  ProcessMapping reference_mapping = {default_mapping(Channel::one), default_mapping(Channel::two)};
  ProcessMapping actual_mapping = {default_mapping(Channel::one), default_mapping(Channel::two)};
  /// Mapping by which this slave reads other slaves' actual values, if it listens to them.
  std::array<std::optional<ProcessMapping>, kSlaves> monitored = {};
  bool full_length = true;            ///< RDC telegrams always have 8 bytes; false: as many as are mapped
  std::uint16_t block_limit = 300;    ///< longest block it takes
  std::uint8_t activate_command = 2;  ///< action "SYNC mode: activate" (unconfirmed)
  std::uint8_t activate_data = 1;
};

/// The slave's side of CANsync, sans-IO (M 3.2.3): the full counterpart of `Master`.
///
/// `on_sync` at each edge, `receive` for every frame on the bus; a returned frame is this slave's answer, to
/// be started as soon as the bus is free and not after the slot time. Nothing allocates, blocks or throws;
/// not thread safe.
class Slave {
 public:
  Slave(const SlaveSideSettings& settings, SlaveApplication& application);

  /// A SYNC edge arrived.
  void on_sync() noexcept;

  /// A frame was on the bus. Returns the frame this slave answers with, if any.
  std::optional<can::Frame> receive(const can::Frame& frame) noexcept;

  /// The same for a frame that is already decoded.
  std::optional<can::Frame> receive(const Telegram& telegram) noexcept;

  /// Releases actual values for the telegrams of `channel` in this interval (control register 0x05, M 4.17).
  /// A reference telegram that asks for actual values that are not released gets no answer. Values are kept
  /// until the next release.
  void release_actual(Channel channel, const Values& values) noexcept;

  /// Reference values, as the mapping filled them; `reference_fresh` tells if that telegram came since the
  /// last edge.
  const Values& references() const noexcept { return references_; }
  bool reference_fresh(Channel channel) const noexcept { return fresh_[index(channel)]; }

  /// Values taken from another slave's actual value telegrams.
  const Values& monitored(SlaveNumber slave) const noexcept { return monitored_[slave.value()]; }

  /// True after the action "SYNC mode: activate".
  bool sync_activated() const noexcept { return sync_activated_; }

  /// Gives a command of the slave's control register; false: not allowed in this state.
  bool control(ControlCommand command) noexcept;
  State state() const noexcept { return state_; }

  /// True while an upload or download block is open.
  bool transfer_open() const noexcept { return transfer_.open; }

 private:
  struct OpenBlock {
    bool open = false;
    TransferInitialise initialise;
    std::uint16_t length = 0;
    std::uint16_t expected = 0;  ///< next offset
  };

  std::optional<can::Frame> answer(const ReferenceTelegram& telegram) noexcept;
  std::optional<can::Frame> answer(const ParameterCommand& command) noexcept;
  std::optional<can::Frame> answer(const TransferInitialise& initialise) noexcept;
  std::optional<can::Frame> answer(const UploadBlock& block) noexcept;
  std::optional<can::Frame> answer(const DownloadBlock& block) noexcept;
  void take(const ActionCommand& action) noexcept;
  void take(const ActualTelegram& telegram) noexcept;

  SlaveSideSettings settings_;
  SlaveApplication& application_;
  State state_ = State::start_up;
  Values references_ = {};
  Values actual_ = {};
  std::array<bool, kChannels> fresh_ = {};
  std::array<bool, kChannels> released_ = {};
  std::array<Values, kSlaves> monitored_ = {};
  bool sync_activated_ = false;
  OpenBlock transfer_;
};

}  // namespace cansync
