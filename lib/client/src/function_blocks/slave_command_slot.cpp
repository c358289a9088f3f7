#include <cansync/function_blocks/slave_command_slot.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "client/src/cansync_slave/slave_side.h"
#include "client/src/causes.h"

namespace cansync::client::function_blocks {
namespace {

cansync_slave_SlaveMode to_idl(Mode mode) noexcept {
  switch (mode) {
    case Mode::setup:
      return cansync_slave_SLAVE_MODE_SETUP;
    case Mode::run:
      return cansync_slave_SLAVE_MODE_RUN;
    case Mode::stop:
      return cansync_slave_SLAVE_MODE_STOP;
    case Mode::reset_can:
      return cansync_slave_SLAVE_MODE_RESET_CAN;
    case Mode::restart:
      break;
  }
  return cansync_slave_SLAVE_MODE_RESTART;
}

}  // namespace

void SlaveCommandSlot::enter(const cansync_slave_SlaveCommand& wanted) {
  const gateway::dds::Begun begun = connection_->side().client().command(wanted);
  daemon_ = connection_->side().daemon();
  request_ = begun.request;
  sent_ = false;
  code_ = ReplyCode::done;
  cause_ = RefusalCause::none;
  error_.clear();
  if (!begun.not_begun) return;
  refuse(detail::cause_of(*begun.not_begun), "client: " + begun.not_begun->reason);
}

void SlaveCommandSlot::mode(Mode mode) {
  cansync_slave_SlaveCommand wanted = {};
  wanted.kind = cansync_slave_SLAVE_COMMAND_MODE;
  wanted.mode = to_idl(mode);
  enter(wanted);
}

void SlaveCommandSlot::mapping(const MappingBytes& references, const MappingBytes& actual_values) {
  cansync_slave_SlaveCommand wanted = {};
  wanted.kind = cansync_slave_SLAVE_COMMAND_MAPPING;
  std::copy(references.begin(), references.end(), std::begin(wanted.reference_mapping));
  std::copy(actual_values.begin(), actual_values.end(), std::begin(wanted.actual_mapping));
  enter(wanted);
}

void SlaveCommandSlot::listen(std::uint8_t other, const MappingBytes& actual_values) {
  cansync_slave_SlaveCommand wanted = {};
  wanted.kind = cansync_slave_SLAVE_COMMAND_LISTEN;
  wanted.other = other;
  std::copy(actual_values.begin(), actual_values.end(), std::begin(wanted.actual_mapping));
  enter(wanted);
}

void SlaveCommandSlot::poll() {
  if (!open()) return;
  detail::SlaveSide& side = connection_->side();
  if (const auto reply = side.take_command_reply(request_)) {
    request_ = 0;
    sent_ = reply->code == ReplyCode::done;
    code_ = reply->code;
    cause_ = reply->cause;
    error_ = sent_ ? "" : "daemon: " + reply->reason;
  } else if (!side.daemon_present() || other_daemon()) {
    request_ = 0;
    code_ = ReplyCode::refused;
    cause_ = RefusalCause::other_daemon;
    error_ = "client: the daemon has gone before it answered";
  }
}

void SlaveCommandSlot::refuse(RefusalCause cause, std::string reason) {
  request_ = 0;
  sent_ = false;
  code_ = ReplyCode::refused;
  cause_ = cause;
  error_ = std::move(reason);
}

bool SlaveCommandSlot::passes() const noexcept {
  return refused() && retry(code_, cause_) == Retry::soon;
}

bool SlaveCommandSlot::other_daemon() const {
  return daemon_ != connection_->side().daemon();
}

}  // namespace cansync::client::function_blocks
