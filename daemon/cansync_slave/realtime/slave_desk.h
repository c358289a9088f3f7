#pragma once

#include <cstdint>
#include <optional>

#include "cansync/slave/slave.h"
#include "daemon/cansync_slave/exchange.h"

namespace cansyncd {

/// What stands behind the slave on the realtime thread: it answers with the status word, and takes down what
/// the master ordered. Realtime safe.
class SlaveDesk final : public cansync::SlaveApplication {
 public:
  /// `parameter`: number of the status word; `bits`: its bits 0..14.
  SlaveDesk(std::uint16_t parameter, std::uint16_t bits) noexcept : parameter_(parameter), bits_(bits) {}

  /// Bit 15 of the status word.
  void set_synchronized(bool synchronized) noexcept { synchronized_ = synchronized; }
  /// As the master reads it.
  std::uint16_t status_word() const noexcept;
  /// What the action was that came last, and forgets it; nothing: none has come.
  std::optional<SlaveAction> take_action() noexcept;

  cansync::ParameterAnswer read_parameter(cansync::ParameterNumber number, cansync::Element element,
                                          cansync::SubSlave sub) noexcept override;
  cansync::ParameterAnswer write_parameter(cansync::ParameterNumber number, cansync::Element element,
                                           cansync::SubSlave sub, bool doubleword,
                                           std::uint32_t value) noexcept override;
  BlockAnswer begin_block(const cansync::TransferInitialise& initialise) noexcept override;
  BlockAnswer read_block(std::uint16_t offset, std::span<std::uint8_t> out) noexcept override;
  BlockAnswer write_block(std::uint16_t offset, std::span<const std::uint8_t> data) noexcept override;
  void end_block(bool complete) noexcept override;
  void sync_activated() noexcept override { action_ = SlaveAction::sync_mode; }
  void control_word(std::uint16_t word) noexcept override;
  void action(std::uint8_t command, std::uint8_t data_byte, std::uint16_t data_word) noexcept override;

 private:
  const std::uint16_t parameter_;
  const std::uint16_t bits_;
  bool synchronized_ = false;
  std::optional<SlaveAction> action_;
};

}  // namespace cansyncd
