#include "daemon/cansync/realtime/bus_watch.h"

#include <chrono>

namespace cansyncd {
namespace {

/// A fault that has stayed away for so long is over.
constexpr can::Time kQuiet = std::chrono::seconds(3);

/// A controller that is off the bus for so long is no short interruption: what its slaves did meanwhile is
/// not known.
constexpr can::Time kOffBus = std::chrono::seconds(1);

}  // namespace

void BusWatch::begin() noexcept {
  status_ = bus_.status();
  watch_link(can::LinkState::up);
  rows_[static_cast<unsigned>(BusFaultKind::not_acknowledged)].seen = status_.acknowledge_errors;
  rows_[static_cast<unsigned>(BusFaultKind::error_frames)].seen = status_.error_frames;
  rows_[static_cast<unsigned>(BusFaultKind::overrun)].seen = status_.overruns;
  rows_[static_cast<unsigned>(BusFaultKind::dropped)].seen = status_.dropped;
}

void BusWatch::sent(can::SendResult result) noexcept {
  // The interface has reports of its own, and so has a bus on which nobody acknowledges.
  if (result == can::SendResult::interface_down) {
    ++without_link_;
    return;
  }
  if (result == can::SendResult::not_delivered) {
    ++held_back_;
    return;
  }
  const can::SendResult before = last_send_;
  last_send_ = result;
  if (result != can::SendResult::queued) ++failed_sends_;
  if (result == before) return;
  reporter_.report(SendingChanged{reporter_.moment(), result, failed_sends_});
  if (result == can::SendResult::queued) failed_sends_ = 0;
}

void BusWatch::look(can::Time now) noexcept {
  const can::ControllerState state = status_.state;
  const can::LinkState link = status_.link;
  const can::Delivery delivery = status_.delivery;
  const std::uint64_t restarts = status_.restarts;
  const bool was_away = away() || delivery != can::Delivery::normal;
  status_ = bus_.status();
  watch_bus_off(now);
  const bool is_away = away() || status_.delivery != can::Delivery::normal;
  returned_ = !is_away && (was_away || status_.restarts != restarts);
  watch_link(link);
  watch_delivery(delivery);
  // A controller without its interface has no state worth a report.
  if (status_.state != state && status_.state != can::ControllerState::stopped &&
      state != can::ControllerState::stopped) {
    reporter_.report(ControllerChanged{reporter_.moment(), state, status_.state});
  }
  watch_row(BusFaultKind::not_acknowledged, status_.acknowledge_errors, now);
  watch_row(BusFaultKind::error_frames, status_.error_frames, now);
  watch_row(BusFaultKind::overrun, status_.overruns, now);
  watch_row(BusFaultKind::dropped, status_.dropped, now);
}

void BusWatch::watch_bus_off(can::Time now) noexcept {
  if (status_.state != can::ControllerState::bus_off) {
    bus_off_since_.reset();
  } else if (!bus_off_since_) {
    bus_off_since_ = now;
  }
  off_bus_ = bus_off_since_ && now - *bus_off_since_ >= kOffBus;
}

void BusWatch::watch_link(can::LinkState before) noexcept {
  if (status_.link == before) return;
  const bool up = status_.link == can::LinkState::up;
  reporter_.report(
      LinkChanged{reporter_.moment(), before, status_.link, status_.bits_per_second, up ? without_link_ : 0});
  if (up) without_link_ = 0;
}

void BusWatch::watch_delivery(can::Delivery before) noexcept {
  const bool normal = status_.delivery == can::Delivery::normal;
  if (status_.delivery != before) {
    DeliveryChanged change{reporter_.moment(), before, status_.delivery, 0, 0};
    if (normal) {
      change.never_sent = status_.unacknowledged - never_sent_;
      change.left_out = held_back_;
    }
    reporter_.report(change);
  }
  // What a late echo has held back is told by nobody: it was an interval's.
  if (normal) held_back_ = 0;
  if (normal) never_sent_ = status_.unacknowledged;
}

void BusWatch::watch_row(BusFaultKind kind, std::uint64_t counter, can::Time now) noexcept {
  Row& row = rows_[static_cast<unsigned>(kind)];
  if (counter != row.seen) {
    const bool first = row.count == 0;
    row.count += counter - row.seen;
    row.seen = counter;
    row.last = now;
    if (first) reporter_.report(BusFault{reporter_.moment(), kind, false, row.count});
  } else if (row.count != 0 && now - row.last >= kQuiet) {
    reporter_.report(BusFault{reporter_.moment(), kind, true, row.count});
    row.count = 0;
  }
}

}  // namespace cansyncd
