#pragma once

#include <optional>
#include <variant>

#include "can/frame.h"
#include "cansync/telegram/telegram.h"

namespace given {

/// What a frame says, when it is a telegram of CANsync of this kind; nothing: it is another one.
template <class Telegram>
std::optional<Telegram> telegram_of(const can::Frame& frame) {
  const cansync::Decoded decoded = cansync::decode(frame);
  const auto* telegram = std::get_if<cansync::Telegram>(&decoded);
  const Telegram* one = telegram != nullptr ? std::get_if<Telegram>(telegram) : nullptr;
  return one != nullptr ? std::optional<Telegram>(*one) : std::nullopt;
}

}  // namespace given
