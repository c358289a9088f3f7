// Draws single faults of every kind.
#include <algorithm>
#include <array>

#include "cansync/telegram/telegram.h"
#include "plan.h"

namespace cansyncd::campaign {
namespace {

using cansync::SlaveNumber;
using sim::FaultKind;

constexpr std::uint32_t kChannelMask = 0x780;
constexpr std::uint32_t kChannels[] = {cansync::identifier::action,        cansync::identifier::reference_one,
                                       cansync::identifier::reference_two, cansync::identifier::actual_one,
                                       cansync::identifier::actual_two,    cansync::identifier::command,
                                       cansync::identifier::response};
/// No client asks for a parameter from here on: an answer for one belongs to nobody.
constexpr std::uint64_t kNeverAsked = 2000;

SlaveNumber any_slave(Dice& dice, const Plan& plan) {
  return plan.drives[dice.below(plan.drives.size())].slave.number;
}

can::Frame noise(Dice& dice) {
  can::Frame frame;
  frame.id = static_cast<std::uint32_t>(dice.below(0x800));
  frame.dlc = static_cast<std::uint8_t>(dice.below(9));
  return frame;
}

/// Random data bytes; those beyond the length are zero.
void fill(Dice& dice, can::Frame& frame) {
  for (std::size_t i = 0; i < frame.dlc; ++i) frame.data[i] = static_cast<std::uint8_t>(dice.next());
}

/// A telegram of the protocol that nobody has asked for and that no slave or job can take for its own.
can::Frame stray_telegram(Dice& dice, const Plan& plan) {
  switch (dice.below(4)) {
    case 0: {  // an answer about a parameter that nobody reads
      cansync::ParameterReply reply;
      reply.slave = any_slave(dice, plan);
      reply.number = *cansync::ParameterNumber::from(dice.between(kNeverAsked, 4095));
      reply.busy = dice.chance(200);
      reply.payload_size = 4;
      return encode(reply);
    }
    case 1: {  // data at an offset that no block has
      cansync::TransferReply reply;
      reply.slave = any_slave(dice, plan);
      reply.offset = *cansync::BlockOffset::from(dice.below(600) * 6 + 3);
      reply.payload_size = 6;
      return encode(reply);
    }
    case 2: {  // a second master moves a value
      cansync::ReferenceTelegram telegram;
      telegram.channel = dice.chance(500) ? cansync::Channel::one : cansync::Channel::two;
      telegram.polled = dice.chance(500) ? any_slave(dice, plan).value() : cansync::kPollNobody;
      return encode(telegram);
    }
    default: {  // a second master reads what nobody here reads
      cansync::ParameterCommand command;
      command.slave = any_slave(dice, plan);
      command.number = *cansync::ParameterNumber::from(dice.between(kNeverAsked, 4095));
      return encode(command);
    }
  }
}

/// Frames that must be rejected: on CANsync's channels none but with a wrong length, or not standard.
can::Frame malformed(Dice& dice, const Plan& plan) {
  can::Frame frame = noise(dice);
  switch (dice.below(4)) {
    case 0:
      frame.extended = true;
      frame.id = static_cast<std::uint32_t>(dice.below(0x20000000));
      break;
    case 1:
      frame.remote = true;
      break;
    case 2:  // actual values and answers are 2..8 bytes, and never an odd number
      frame.id = (dice.chance(500) ? cansync::identifier::actual_one : cansync::identifier::response) |
                 any_slave(dice, plan).value();
      frame.dlc = dice.chance(500) ? 1 : 3;
      break;
    default:  // no channel of CANsync
      frame.id = static_cast<std::uint32_t>(0x600 + dice.below(0x200));
      break;
  }
  fill(dice, frame);
  return frame;
}

Window draw_span(Dice& dice, std::uint64_t last) {
  const std::uint64_t from = dice.between(1, last);
  const std::uint64_t longest = dice.chance(800) ? 60 : last;
  return {from, std::min(last, from + dice.below(longest))};
}

/// Which frames a fault of the bus hits.
void draw_filter(Dice& dice, const Plan& plan, sim::Fault& fault) {
  if (dice.chance(500)) fault.node = any_slave(dice, plan).value();
  if (!dice.chance(500)) return;
  fault.identifier = dice.one_of(kChannels);
  fault.mask = kChannelMask;
}

void draw_receivers(Dice& dice, sim::Fault& fault) {
  if (dice.chance(400)) return;
  fault.receivers.bits = static_cast<std::uint32_t>(dice.next());
  fault.lost_to_master = dice.chance(500);
}

}  // namespace

FaultKind draw_kind(Dice& dice, const std::vector<sim::Fault>& others) {
  const auto delays = [](FaultKind kind) { return kind == FaultKind::late || kind == FaultKind::duplicated; };
  while (true) {
    const auto kind = static_cast<FaultKind>(dice.below(sim::kFaultKinds));
    const bool clash = std::any_of(others.begin(), others.end(), [&](const sim::Fault& other) {
      return (delays(kind) && other.kind == FaultKind::wrong_answer) ||
             (kind == FaultKind::wrong_answer && delays(other.kind));
    });
    if (!clash) return kind;
  }
}

sim::Fault draw_fault(Dice& dice, FaultKind kind, const Plan& plan, std::uint64_t last) {
  constexpr double kProbabilities[] = {1.0, 1.0, 0.5, 0.1, 0.02};
  constexpr std::uint64_t kCounts[] = {1, 2, 3, 10, 40, sim::Fault::kNoLimit};
  static_assert(sim::kFaultKinds == 9, "draw the new kind here");
  sim::Fault fault;
  const Window window = draw_span(dice, last);
  fault.kind = kind;
  fault.from = window.from;
  fault.to = window.to;
  fault.probability = dice.one_of(kProbabilities);
  fault.count = dice.one_of(kCounts);
  const auto interval = static_cast<std::uint64_t>(plan.interval().count());
  switch (kind) {
    case FaultKind::lost:
      draw_filter(dice, plan, fault);
      draw_receivers(dice, fault);
      break;
    case FaultKind::late:
      draw_filter(dice, plan, fault);
      fault.delay = can::Time(dice.between(1, (kLatestIntervals - 1) * interval));
      fault.count = std::min<std::uint64_t>(fault.count, 10);
      break;
    case FaultKind::corrupted:
    case FaultKind::duplicated:
      draw_filter(dice, plan, fault);
      break;
    case FaultKind::wrong_answer:
    case FaultKind::busy:
      if (dice.chance(500)) fault.node = any_slave(dice, plan).value();
      break;
    case FaultKind::silent:
      fault.probability = dice.chance(800) ? 1.0 : fault.probability;
      fault.count = sim::Fault::kNoLimit;
      if (dice.chance(850)) fault.node = any_slave(dice, plan).value();
      break;
    case FaultKind::missing_sync:
      if (dice.chance(700)) fault.node = any_slave(dice, plan).value();
      break;
    case FaultKind::inject:
      fault.delay = can::Time(dice.below(interval));
      fault.frame = dice.chance(500) ? malformed(dice, plan) : stray_telegram(dice, plan);
      break;
  }
  return fault;
}

}  // namespace cansyncd::campaign
