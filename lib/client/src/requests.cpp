#include <cansync/client.h>
#include <cansync/topics.h>

#include <algorithm>
#include <atomic>
#include <utility>

#include "client/src/link.h"

/// Jobs and commands of a Client.
namespace cansync::client {
namespace {

/// A command whose fields change nothing.
cansync_Command command_of(cansync_CommandKind kind) {
  cansync_Command command = {};
  command.kind = kind;
  command.polling_one = command.polling_two = command.maximum_slave = kUnchanged;
  command.cursor_control_word = command.cursor_parameter = command.cursor_transfer = kUnchanged;
  return command;
}

static_assert(static_cast<int>(Mode::setup) == cansync_MODE_SETUP);
static_assert(static_cast<int>(Mode::run) == cansync_MODE_RUN);
static_assert(static_cast<int>(Mode::stop) == cansync_MODE_STOP);
static_assert(static_cast<int>(Mode::reset_can) == cansync_MODE_RESET_CAN);
static_assert(static_cast<int>(Mode::restart) == cansync_MODE_RESTART);

const std::atomic<bool> kNeverStop = false;

/// Of a function that waits for the reply.
template <class R>
R refused_in_a_callback() {
  R reply;
  reply.code = ReplyCode::refused;
  reply.cause = RefusalCause::field;
  reply.speaker = Speaker::client;
  reply.reason =
      "a callback of this client cannot wait for a reply, which comes only when it has returned; nothing was sent; use "
      "submit and then(), or another thread";
  return reply;
}

}  // namespace

ParameterJob Client::submit(const ParameterRequest& request) {
  return ParameterJob(link_->submit(request));
}
TransferJob Client::submit(const TransferRequest& request) {
  return TransferJob(link_->submit(request));
}

ParameterReply Client::read(std::uint32_t slave, std::uint32_t number, std::uint32_t timeout_ms) {
  if (link_->is_receiver()) return refused_in_a_callback<ParameterReply>();
  return submit(ParameterRequest{.slave = slave, .number = number, .timeout_ms = timeout_ms}).wait();
}

ParameterReply Client::write(std::uint32_t slave, std::uint32_t number, std::uint32_t value,
                             std::uint32_t timeout_ms) {
  if (link_->is_receiver()) return refused_in_a_callback<ParameterReply>();
  return submit(
             ParameterRequest{
                 .write = true, .slave = slave, .number = number, .value = value, .timeout_ms = timeout_ms})
      .wait();
}

TransferReply Client::upload(std::uint32_t slave, std::uint32_t address, std::uint32_t length,
                             const OnProgress& on_progress) {
  if (link_->is_receiver()) return refused_in_a_callback<TransferReply>();
  return submit(TransferRequest{.slave = slave, .address = address, .length = length})
      .wait(kNeverStop, on_progress);
}

TransferReply Client::download(std::uint32_t slave, std::uint32_t address, std::vector<std::uint8_t> data,
                               const OnProgress& on_progress) {
  if (link_->is_receiver()) return refused_in_a_callback<TransferReply>();
  return submit(
             TransferRequest{.download = true, .slave = slave, .address = address, .data = std::move(data)})
      .wait(kNeverStop, on_progress);
}

CommandJob Client::control_word(std::uint32_t slave, std::uint32_t word, std::uint32_t timeout_ms) {
  cansync_Command command = command_of(cansync_COMMAND_CONTROL_WORD);
  command.slave = slave;
  command.control_word = word;
  command.timeout = timeout_ms;
  return CommandJob(link_->submit(command));
}

CommandJob Client::broadcast(const Broadcast& broadcast) {
  cansync_Command command = command_of(cansync_COMMAND_BROADCAST);
  command.priority = broadcast.priority;
  command.slave_mask = broadcast.slave_mask;
  command.action = broadcast.action;
  command.data_byte = broadcast.data_byte;
  command.data_word = broadcast.data_word;
  command.timeout = broadcast.timeout_ms;
  return CommandJob(link_->submit(command));
}

CommandJob Client::mode(Mode mode, bool force) {
  cansync_Command command = command_of(cansync_COMMAND_MODE);
  command.mode = static_cast<cansync_Mode>(mode);
  command.force = force;
  return CommandJob(link_->submit(command));
}

CommandJob Client::release(std::uint32_t slave, bool force) {
  cansync_Command command = command_of(cansync_COMMAND_RELEASE);
  command.slave = slave;
  command.force = force;
  return CommandJob(link_->submit(command));
}

CommandJob Client::polling(const Polling& polling) {
  cansync_Command command = command_of(cansync_COMMAND_POLLING);
  command.polling_one = polling.one;
  command.polling_two = polling.two;
  command.maximum_slave = polling.maximum_slave;
  return CommandJob(link_->submit(command));
}

CommandJob Client::cursors(const Cursors& cursors) {
  cansync_Command command = command_of(cansync_COMMAND_CHANNEL_CURSORS);
  command.cursor_control_word = cursors.control_word;
  command.cursor_parameter = cursors.parameter;
  command.cursor_transfer = cursors.transfer;
  return CommandJob(link_->submit(command));
}

CommandJob Client::map_references(const MappingBytes& mapping) {
  cansync_Command command = command_of(cansync_COMMAND_REFERENCE_MAPPING);
  std::copy(mapping.begin(), mapping.end(), std::begin(command.mapping));
  return CommandJob(link_->submit(command));
}

CommandJob Client::map_actuals(std::uint32_t slave, const MappingBytes& mapping) {
  cansync_Command command = command_of(cansync_COMMAND_ACTUAL_MAPPING);
  command.slave = slave;
  std::copy(mapping.begin(), mapping.end(), std::begin(command.mapping));
  return CommandJob(link_->submit(command));
}

}  // namespace cansync::client
