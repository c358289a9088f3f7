#include "cansync/ask/question.h"

#include "cansync/telegram/telegram.h"

namespace cansync::ask {
namespace {

Telegram telegram_of(const ReadQuestion& question) noexcept {
  ParameterCommand command;
  command.slave = question.slave;
  command.kind = ParameterCommand::Kind::read;
  command.number = question.number;
  return command;
}

Telegram telegram_of(const BlockQuestion& question) noexcept {
  TransferInitialise initialise;
  initialise.slave = question.slave;
  initialise.direction = TransferInitialise::Direction::upload;
  initialise.length = question.length;
  initialise.address = question.address;
  return initialise;
}

Telegram telegram_of(const CloseQuestion& question) noexcept {
  return cancel_transfer(question.slave);
}

}  // namespace

// std::visit could throw.
SlaveNumber asked_slave(const Question& question) noexcept {
  if (const auto* read = std::get_if<ReadQuestion>(&question)) return read->slave;
  if (const auto* block = std::get_if<BlockQuestion>(&question)) return block->slave;
  return std::get_if<CloseQuestion>(&question)->slave;
}

can::Frame frame_of(const Question& question) noexcept {
  if (const auto* read = std::get_if<ReadQuestion>(&question)) return encode(telegram_of(*read));
  if (const auto* block = std::get_if<BlockQuestion>(&question)) return encode(telegram_of(*block));
  return encode(telegram_of(*std::get_if<CloseQuestion>(&question)));
}

}  // namespace cansync::ask
