#include "cansync/observe/transfer_watch.h"

#include <algorithm>

#include "cansync/observe/command_watch.h"
#include "cansync/telegram/reply_payload.h"

namespace cansync::observe {
namespace {

/// Start addresses below it belong to the slave's operating system.
constexpr std::uint32_t kLowAddresses = 0x100;
/// A cursor that rises comes back to a slave within 32 intervals; another block after more is another job.
constexpr IntervalNumber kIntervalsBetweenBlocks = 64;
/// No transfer is longer; blocks that go on all the same are another one.
constexpr std::uint32_t kLongestTransfer = 1u << 24;

bool is_cancel(const TransferInitialise& initialise) noexcept {
  return initialise.direction == TransferInitialise::Direction::upload && initialise.length.value() == 0 &&
         initialise.address == 0;
}

}  // namespace

void TransferWatch::command(const Telegram& telegram, bool again, Duration since_first, Instant at) {
  const auto* initialise = std::get_if<TransferInitialise>(&telegram);
  if (initialise != nullptr && !again) begin(*initialise, since_first, at);
  const SlaveNumber slave = std::visit(
      [](const auto& told) {
        if constexpr (requires { told.slave; })
          return told.slave;
        else
          return SlaveNumber{};
      },
      telegram);
  block_[slave.value()].asked = at.interval;
}

/// True when it is the next block of that transfer.
bool TransferWatch::goes_on(const TransferInitialise& initialise, const TransferStep& step,
                            const Block& block, Instant at) {
  if (!block.done || block.before >= kLongestTransfer ||
      at.interval > block.asked + kIntervalsBetweenBlocks || step.direction != initialise.direction ||
      step.sub_slave != initialise.sub_slave)
    return false;
  const bool bytes = initialise.address == block.address + block.length;
  const bool doublewords = block.length % 4 == 0 && initialise.address == block.address + block.length / 4;
  if (!bytes && !doublewords) return false;
  ++(bytes ? out_.address_bytes : out_.address_doublewords);
  SlaveUse& use = out_.slave[initialise.slave.value()];
  use.continued_block = std::max(use.continued_block, static_cast<std::uint16_t>(block.length));
  ++use.continued_blocks;
  return true;
}

void TransferWatch::begin(const TransferInitialise& initialise, Duration since_first, Instant at) {
  SlaveUse& use = out_.slave[initialise.slave.value()];
  Block& block = block_[initialise.slave.value()];
  if (is_cancel(initialise)) {
    ++use.cancels;
    if (block.step && !block.done) block.failed = true;
    return;
  }
  if (use.cancels == 0) ++use.transfers_before_cancel;
  use.longest_block = std::max(use.longest_block, initialise.length.value());
  auto* step = block.step ? &std::get<TransferStep>(out_.steps[*block.step].what) : nullptr;
  const bool anew = step != nullptr && !block.done && step->direction == initialise.direction &&
                    block.address == initialise.address && block.length == initialise.length.value();
  if (anew) {
    block.failed = false;
    step->end = StepEnd::open;
    return;
  }
  if (step != nullptr && goes_on(initialise, *step, block, at)) {
    block.before += block.length;
    step->end = StepEnd::open;
  } else {
    TransferStep begun;
    begun.direction = initialise.direction;
    begun.slave = initialise.slave;
    begun.sub_slave = initialise.sub_slave;
    begun.address = initialise.address;
    begun.whole = true;
    block = {};
    block.step = add_step(out_, {since_first, out_.first_reference.has_value(), 1, std::move(begun)});
    if (!block.step) return;
    step = &std::get<TransferStep>(out_.steps[*block.step].what);
  }
  block.address = initialise.address;
  block.length = initialise.length.value();
  block.done = block.failed = false;
  ++step->blocks;
  step->bytes += block.length;
}

void TransferWatch::take(Block& block, std::uint32_t offset, std::span<const std::uint8_t> bytes, bool last) {
  if (!block.step) return;
  auto& step = std::get<TransferStep>(out_.steps[*block.step].what);
  const std::size_t count =
      std::min<std::size_t>(bytes.size(), block.length - std::min(block.length, offset));
  const std::size_t end = block.before + offset + count;
  if (step.data.size() < end && kept_ + (end - step.data.size()) <= kMostTransferBytes) {
    // What was not on the recording must not look like zeros that were.
    if (step.data.size() < block.before + offset) step.whole = false;
    kept_ += end - step.data.size();
    step.data.resize(end);
  }
  if (step.data.size() >= end)
    std::copy_n(bytes.begin(), count, step.data.data() + block.before + offset);
  else
    step.whole = false;
  if (!last) return;
  block.done = true;
  step.end = StepEnd::done;
}

void TransferWatch::reply(const Telegram& asked, const TransferReply& reply) {
  const unsigned number = reply.slave.value();
  SlaveUse& use = out_.slave[number];
  Block& block = block_[number];
  const auto* initialise = std::get_if<TransferInitialise>(&asked);
  const TransferError error =
      reply.error ? error_answer(reply).value_or(TransferError::none) : TransferError::none;
  if (initialise != nullptr && is_cancel(*initialise)) {
    ++(reply.error ? use.cancels_refused : use.cancels_taken);
    if (reply.error) use.cancel_error = error;
    return;
  }
  if (initialise != nullptr && initialise->address < kLowAddresses)
    ++(reply.error ? out_.low_addresses_refused : out_.low_addresses_taken);
  if (!block.step) return;
  auto& step = std::get<TransferStep>(out_.steps[*block.step].what);
  if (reply.error) {
    block.failed = true;
    step.end = StepEnd::refused;
    step.error = error;
    return;
  }
  if (initialise != nullptr) {
    // The slave may fix a smaller length; 0 says as asked.
    const std::uint32_t fixed = reply.offset.value();
    if (fixed != 0 && fixed < block.length) {
      step.bytes -= block.length - fixed;
      block.length = fixed;
    }
    return;
  }
  if (const auto* download = std::get_if<DownloadBlock>(&asked))
    return take(block, download->offset.value(), download->data, download->last);
  const auto* upload = std::get_if<UploadBlock>(&asked);
  const auto bytes = upload_bytes(reply);
  if (upload != nullptr && bytes) take(block, upload->offset.value(), *bytes, upload->last);
}

}  // namespace cansync::observe
