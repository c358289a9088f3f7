#include "daemon/cansync_slave/realtime/release_store.h"

#include <utility>

namespace cansyncd {

using cansync::ActualRelease;
using cansync::Channel;

namespace {

constexpr std::array<Channel, cansync::kChannels> kBothChannels = {Channel::one, Channel::two};

}  // namespace

void ReleaseStore::take(const ReleaseOrder& order, cansync::Slave& slave) noexcept {
  Waiting& waiting = waiting_[index(order.channel)];
  const ActualRelease now = slave.release(order.channel);
  // What the master has asked for already is not taken back, and not counted.
  const bool asked = waiting.in_slave && now != ActualRelease::released && now != ActualRelease::none;
  if (waiting.left != 0 && !asked) ++waiting.unused;
  waiting.left = order.intervals;
  waiting.in_slave = false;
  if (order.intervals == 0) {
    slave.withdraw_actual(order.channel);
    for_lead_[index(order.channel)] = 0;
    return;
  }
  const unsigned first = index(order.channel) * cansync::kWords;
  for (unsigned i = 0; i < cansync::kWords; ++i) {
    if (((order.valid >> i) & 1u) != 0) values_[first + i] = order.values[i];
  }
  for_lead_[index(order.channel)] |= order.valid;
  const bool free = now == ActualRelease::none || now == ActualRelease::released;
  if (free) hand_on(order.channel, slave);
}

void ReleaseStore::interval_ends(const cansync::Slave& slave, std::uint64_t passed) noexcept {
  // Over intervals that were skipped everything is too old for the lower bus.
  if (passed > 1) for_lead_ = {};
  for (const Channel channel : kBothChannels) {
    Waiting& waiting = waiting_[index(channel)];
    if (waiting.left == 0 || !waiting.in_slave) continue;
    waiting.in_slave = false;
    if (slave.release(channel) != ActualRelease::released) {
      waiting.left = 0;  // it was asked for: one release, one telegram, whatever became of it
      continue;
    }
    waiting.left = passed < waiting.left ? waiting.left - static_cast<std::uint32_t>(passed) : 0;
    if (waiting.left == 0) ++waiting.unused;
  }
}

void ReleaseStore::interval_begins(cansync::Slave& slave) noexcept {
  for (const Channel channel : kBothChannels) {
    const std::uint8_t fresh = std::exchange(for_lead_[index(channel)], std::uint8_t{0});
    if (fresh != 0 && lead_ != nullptr) lead_->released(channel, fresh, values_);
    if (waiting_[index(channel)].left != 0) hand_on(channel, slave);
  }
}

void ReleaseStore::drop() noexcept {
  for_lead_ = {};
  for (Waiting& waiting : waiting_) {
    if (waiting.left != 0) ++waiting.unused;
    waiting.left = 0;
    waiting.in_slave = false;
  }
}

void ReleaseStore::hand_on(Channel channel, cansync::Slave& slave) noexcept {
  slave.release_actual(channel, values_);
  waiting_[index(channel)].in_slave = true;
}

}  // namespace cansyncd
