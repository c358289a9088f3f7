#pragma once

#include <cstdint>
#include <span>

#include "cansync/slave/slave.h"

namespace cansyncd::test {

/// What a slave's master asks for is nothing to it.
class SilentApplication final : public cansync::SlaveApplication {
 public:
  cansync::ParameterAnswer read_parameter(cansync::ParameterNumber, cansync::Element,
                                          cansync::SubSlave) noexcept override {
    return {};
  }
  cansync::ParameterAnswer write_parameter(cansync::ParameterNumber, cansync::Element, cansync::SubSlave,
                                           bool, std::uint32_t) noexcept override {
    return {};
  }
  BlockAnswer begin_block(const cansync::TransferInitialise&) noexcept override { return {}; }
  BlockAnswer read_block(std::uint16_t, std::span<std::uint8_t>) noexcept override { return {}; }
  BlockAnswer write_block(std::uint16_t, std::span<const std::uint8_t>) noexcept override { return {}; }
  void end_block(bool) noexcept override {}
  void control_word(std::uint16_t) noexcept override {}
  void action(std::uint8_t, std::uint8_t, std::uint16_t) noexcept override {}
};

}  // namespace cansyncd::test
