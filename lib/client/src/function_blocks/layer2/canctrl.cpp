#include <cansync/function_blocks/layer2/canctrl.h>
#include <cansync/function_blocks/module_codes.h>

#include <optional>
#include <utility>

#include "client/src/layer2/frame_side.h"

namespace cansync::client::function_blocks {
namespace {

constexpr INT kStartTimer = 1;
constexpr INT kStopTimer = 2;
constexpr INT kClearQueues = 6;
constexpr INT kResetOverflow = 7;
constexpr INT kLastTimer = 16;

/// What the daemon is asked for; nothing: there is no such function.
std::optional<layer2_ControlKind> kind_of(INT function) {
  switch (function) {
    case kStartTimer:
      return layer2_CONTROL_START_TIMER;
    case kStopTimer:
      return layer2_CONTROL_STOP_TIMER;
    case 5:
      return layer2_CONTROL_RESET_CONTROLLER;
    case kClearQueues:
      return layer2_CONTROL_CLEAR_QUEUES;
    case kResetOverflow:
      return layer2_CONTROL_RESET_OVERFLOW;
    default:
      return std::nullopt;
  }
}

}  // namespace

struct CANCTRL::Asked {
  UINT open = 0;
  std::string error;
};

CANCTRL::CANCTRL(FrameConnection& connection) : connection_(&connection), asked_(std::make_shared<Asked>()) {}
CANCTRL::~CANCTRL() = default;

UINT CANCTRL::open() const noexcept {
  return asked_->open;
}

const std::string& CANCTRL::error() const noexcept {
  return asked_->error;
}

void CANCTRL::call() {
  detail::FrameSide& side = connection_->side();
  side.look();
  RETVAL = ask();
  STAT = side.status_word();
}

INT CANCTRL::ask() {
  detail::FrameSide& side = connection_->side();
  const auto kind = kind_of(Func);
  if (!kind)
    return refuse(module_code::input_invalid,
                  "client: Func " + std::to_string(Func) + ": no such function; allowed 1, 2, 5, 6, 7");
  if ((Func == kStartTimer || Func == kStopTimer) && (Param < 1 || Param > kLastTimer))
    return refuse(module_code::input_invalid,
                  "client: Param " + std::to_string(Param) + ": no such timer; allowed 1..16");
  if (!side.daemon_present()) return refuse(module_code::not_ready, "client: no daemon serves the bus");
  if (side.full())
    return refuse(module_code::in_use, "client: too many requests are open; call again when some have ended");
  (void)side.take_restart();  // nothing here depends on what was before
  layer2_ControlRequest wanted = {};
  wanted.kind = *kind;
  wanted.number = static_cast<std::uint8_t>(Param);
  asked_->error.clear();
  const bool begun = side.control(wanted, [asked = asked_](const detail::FrameSide::Result& result) {
    --asked->open;
    if (!result.replied || result.code != gateway_REPLY_DONE) asked->error = "daemon: " + result.reason;
  });
  if (!begun) return refuse(module_code::not_ready, "client: " + side.problem());
  ++asked_->open;
  if (Func == kClearQueues) side.queues().clear();
  if (Func == kResetOverflow) side.queues().reset_overflow();
  return module_code::done;
}

INT CANCTRL::refuse(INT code, std::string reason) {
  asked_->error = std::move(reason);
  return code;
}

}  // namespace cansync::client::function_blocks
