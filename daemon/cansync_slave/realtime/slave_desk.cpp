#include "daemon/cansync_slave/realtime/slave_desk.h"

#include <utility>

namespace cansyncd {
namespace {

using cansync::ParameterError;

constexpr std::uint16_t kSynchronizedBit = 0x8000;

}  // namespace

std::uint16_t SlaveDesk::status_word() const noexcept {
  const unsigned low = bits_ & ~unsigned{kSynchronizedBit};
  return static_cast<std::uint16_t>(synchronized_ ? low | kSynchronizedBit : low);
}

std::optional<SlaveAction> SlaveDesk::take_action() noexcept {
  return std::exchange(action_, std::nullopt);
}

cansync::ParameterAnswer SlaveDesk::read_parameter(cansync::ParameterNumber number, cansync::Element element,
                                                   cansync::SubSlave sub) noexcept {
  if (sub.value != 0) return {.error = ParameterError::not_present};
  if (number.value() != parameter_) return {.error = ParameterError::not_available_now};
  if (element != cansync::kValueElement) return {.error = ParameterError::not_present};
  return {.value = status_word()};
}

cansync::ParameterAnswer SlaveDesk::write_parameter(cansync::ParameterNumber number,
                                                    cansync::Element /*element*/, cansync::SubSlave sub,
                                                    bool /*doubleword*/, std::uint32_t /*value*/) noexcept {
  if (sub.value != 0) return {.error = ParameterError::not_present};
  return {.error = number.value() == parameter_ ? ParameterError::not_changeable
                                                : ParameterError::not_available_now};
}

SlaveDesk::BlockAnswer SlaveDesk::begin_block(const cansync::TransferInitialise& /*initialise*/) noexcept {
  return {.error = cansync::TransferError::not_possible};
}

SlaveDesk::BlockAnswer SlaveDesk::read_block(std::uint16_t /*offset*/,
                                             std::span<std::uint8_t> /*out*/) noexcept {
  return {.error = cansync::TransferError::cancelled_by_slave};
}

SlaveDesk::BlockAnswer SlaveDesk::write_block(std::uint16_t /*offset*/,
                                              std::span<const std::uint8_t> /*data*/) noexcept {
  return {.error = cansync::TransferError::cancelled_by_slave};
}

void SlaveDesk::end_block(bool /*complete*/) noexcept {}

void SlaveDesk::control_word(std::uint16_t /*word*/) noexcept {
  action_ = SlaveAction::control_word;
}

void SlaveDesk::action(std::uint8_t /*command*/, std::uint8_t /*data_byte*/,
                       std::uint16_t /*data_word*/) noexcept {
  action_ = SlaveAction::user;
}

}  // namespace cansyncd
