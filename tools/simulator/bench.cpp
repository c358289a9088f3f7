#include "simulator/bench.h"

#include <algorithm>
#include <bit>
#include <utility>
#include <variant>

#include "cansync/telegram.h"
#include "sync/software_sync.h"

namespace cansync_sim {
namespace {

constexpr std::uint32_t kIdentifiers = 0x800;
constexpr std::size_t kFramesPerDrive = 8;
constexpr std::size_t kForeignFrames = 64;

template <class Action>
void for_each_bit(std::uint32_t mask, Action&& action) {
  for (; mask != 0; mask &= mask - 1) action(static_cast<std::uint8_t>(std::countr_zero(mask)));
}

}  // namespace

Bench::Bench(const BenchSettings& settings, std::vector<std::unique_ptr<sim::Drive>> drives)
    : drives_(std::move(drives)),
      sync_identifier_(settings.sync_identifier),
      bits_per_second_(cansync::slot_times(settings.bit_rate).bits_per_second),
      interval_(cansync::slot_times(settings.bit_rate).interval),
      faults_(settings.faults, settings.seed),
      acceptance_(kIdentifiers),
      waiting_(drives_.size() * kFramesPerDrive + kForeignFrames) {
  for (std::size_t index = 0; index < drives_.size(); ++index) {
    for (std::uint32_t identifier = 0; identifier < kIdentifiers; ++identifier) {
      if (drives_[index]->accepts(identifier)) acceptance_[identifier] |= DriveMask{1} << index;
    }
  }
}

void Bench::receive(const can::ReceivedFrame& received, can::Time now) noexcept {
  const can::Frame& frame = received.frame;
  if (frame.error) {
    ++counters_.error_frames;
    return;
  }
  if (sync_line::is_software_sync(frame, sync_identifier_)) {
    sync(sync_line::edge_of(received, bits_per_second_));
    return;
  }
  ++counters_.received;
  const auto fate = faults_.at_start(frame, false);
  const DriveMask receivers = accepting(frame) & ~silent_ & ~drives_of(fate.lost);
  deliver(frame, received.end, now, receivers);
  if (fate.duplicated) deliver(frame, received.end, now, receivers);
}

void Bench::sync(can::Time edge) noexcept {
  faults_.begin_interval(counters_.syncs++);
  silent_ = drives_of(faults_.silent());
  for_each_bit(silent_, [&](std::uint8_t index) { waiting_.drop(index); });
  const DriveMask deaf = silent_ | drives_of(faults_.missing_sync());
  for (std::size_t index = 0; index < drives_.size(); ++index) {
    if (((deaf >> index) & 1u) == 0) drives_[index]->on_sync(edge);
  }
  std::size_t cursor = 0;
  while (const sim::Fault* fault = faults_.next_injection(cursor)) {
    if (!push(fault->frame, edge + fault->delay, kForeign, true)) ++counters_.faults_missed;
  }
}

void Bench::deliver(const can::Frame& frame, can::Time end, can::Time now, DriveMask receivers) noexcept {
  if (receivers == 0) return;
  const cansync::Decoded decoded = cansync::decode(frame);
  const auto* telegram = std::get_if<cansync::Telegram>(&decoded);
  for_each_bit(receivers, [&](std::uint8_t index) {
    if (const auto answer = drives_[index]->on_frame(frame, telegram, end)) {
      hand_over(index, *answer, end, now);
    }
  });
}

void Bench::hand_over(std::uint8_t index, const sim::Transmission& answer, can::Time end,
                      can::Time now) noexcept {
  // After a standstill of this process the master waits for none of these answers any more.
  if (now - end > interval_) {
    ++counters_.too_late;
    return;
  }
  can::Frame frame = answer.frame;
  const cansync::Duration delay = faults_.at_hand_over(frame);
  if (!push(frame, answer.not_before + delay, index, false)) ++counters_.not_sent;
}

bool Bench::push(const can::Frame& frame, can::Time ready, std::uint8_t sender, bool repeated) noexcept {
  sim::PendingFrame pending;
  pending.frame = frame;
  pending.ready = ready;
  pending.order = order_++;
  pending.key = sim::arbitration_key(frame);
  pending.sender = sender;
  pending.repeated = repeated;
  return waiting_.push(pending);
}

can::Time Bench::next_due() const noexcept {
  return waiting_.earliest().value_or(can::Time::max());
}

std::optional<can::Frame> Bench::next(can::Time now) noexcept {
  while (const sim::PendingFrame* winner = waiting_.winner(now)) {
    const sim::PendingFrame chosen = *winner;
    waiting_.remove(*winner);
    if (chosen.sender == kForeign) return chosen.frame;
    const auto fate = faults_.at_start(chosen.frame, chosen.repeated);
    if (fate.duplicated) push(chosen.frame, chosen.ready, chosen.sender, true);
    // A socket does not hear itself: the other drives of this program are told here.
    const DriveMask others = ~(DriveMask{1} << chosen.sender);
    deliver(chosen.frame, now, now, accepting(chosen.frame) & others & ~silent_ & ~drives_of(fate.lost));
    // On a real bus a frame cannot be hidden from one receiver: lost to the master is not sent at all.
    if (!fate.lost_to_master) return chosen.frame;
  }
  return std::nullopt;
}

void Bench::sent(can::SendResult result) noexcept {
  ++(result == can::SendResult::queued ? counters_.sent : counters_.not_sent);
}

void Bench::link_lost() noexcept {
  for (std::size_t index = 0; index < drives_.size(); ++index) {
    waiting_.drop(static_cast<std::uint8_t>(index));
  }
  waiting_.drop(kForeign);
}

Bench::DriveMask Bench::drives_of(cansync::SlaveMask slaves) const noexcept {
  if (slaves.empty()) return 0;
  DriveMask mask = 0;
  for (std::size_t index = 0; index < drives_.size(); ++index) {
    if (slaves.has(drives_[index]->number())) mask |= DriveMask{1} << index;
  }
  return mask;
}

Bench::DriveMask Bench::accepting(const can::Frame& frame) const noexcept {
  return frame.is_standard_data() ? acceptance_[frame.id & (kIdentifiers - 1)] : 0;
}

}  // namespace cansync_sim
