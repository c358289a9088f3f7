#include "small/other_master_truth.h"

#include <algorithm>

namespace cansyncd::campaign {
namespace {

constexpr can::Time kQuiet = std::chrono::seconds(3);
constexpr can::Time kLongAgo = -std::chrono::hours(1);

constexpr const char* kListens = "it_listens_before_its_first_frame";
constexpr const char* kSilent = "no_frame_of_ours_while_another_master_is_there";
constexpr const char* kCommand = "after_another_master_it_waits_for_the_command";

std::string ms(can::Time time) {
  return std::to_string(static_cast<double>(time.count()) / 1e6) + " ms";
}

}  // namespace

OtherMasterTruth::OtherMasterTruth(const OtherMasterPlan& plan, const Outages& outages)
    : plan_(plan),
      outages_(outages),
      interval_(plan.line.interval()),
      last_other_(kLongAgo),
      last_edge_(kLongAgo),
      last_reference_(kLongAgo) {
  for (const Lateness& late : plan.line.lateness) late_ = std::max(late_, late.most);
  may_run_ = plan.line.target == StartTarget::active ||
             std::any_of(plan.orders.begin(), plan.orders.end(),
                         [](const Order& order) { return order.mode == Mode::run; });
}

void OtherMasterTruth::violated(const char* invariant, const std::string& what, can::Time now) {
  if (!violation_) violation_ = Violation{invariant, what, static_cast<std::uint64_t>(now / interval_)};
}

void OtherMasterTruth::ordered(const Order& order, can::Time now) noexcept {
  if (order.force) forced_ = now;
}

void OtherMasterTruth::obeyed(const Order& order, can::Time now) noexcept {
  hear(now);
  if (order.mode == Mode::stop || order.mode == Mode::restart) forced_.reset();
  if (order.mode == Mode::set_up || order.mode == Mode::restart) {
    if (std::exchange(needs_command_, false)) ++met["begun_by_a_command"];
  }
}

/// Has the daemon read the state of its controller since then, or was there time enough?
bool OtherMasterTruth::looked_since(can::Time from, can::Time now) const noexcept {
  return outages_.look() >= from || now - from > 2 * interval_ + late_;
}

bool OtherMasterTruth::forced(can::Time now) {
  if (!forced_) return false;
  const Outages::Gap* const gap = outages_.newest(now);
  const can::Time back = gap != nullptr && gap->back <= now ? gap->back : kLongAgo;
  const can::Time alone = now - std::max({*forced_, last_other_, back});
  if ((back > *forced_ && looked_since(back, now)) ||
      alone > std::max(kQuiet, plan_.line.settings.startup.listen) + 3 * interval_ + late_)
    forced_.reset();
  return forced_.has_value();
}

void OtherMasterTruth::hear(can::Time now) {
  while (!coming_.empty() && coming_.front() <= now) {
    const can::Time end = coming_.front();
    coming_.pop_front();
    if (outages_.at(end) != nullptr) continue;
    const bool judged = !forced(end);
    if (end - last_other_ > kQuiet) {
      row_judged_ = judged;
      edges_ = 0;
      if (judged) first_of_a_row(end);
    }
    last_other_ = end;
    if (judged && plan_.after == AfterOtherMaster::command) needs_command_ = true;
  }
}

void OtherMasterTruth::first_of_a_row(can::Time end) {
  taken_ = false;
  const Outages::Gap* const gap = outages_.newest(end);
  if (end - last_reference_ <= 2 * interval_) {
    ++met["came_in_run"];
  } else if (end - last_edge_ <= 2 * interval_) {
    ++met["came_while_SYNC_ran"];
  } else if (gap != nullptr && end - gap->back < plan_.line.settings.startup.listen) {
    constexpr const char* kAfter[] = {"came_after_bus_off", "came_after_the_interface_was_down",
                                      "came_after_the_cable_was_off"};
    ++met[kAfter[static_cast<unsigned>(gap->outage.kind)]];
  } else if (last_edge_ == kLongAgo) {
    ++met["came_before_our_first_frame"];
  }
}

void OtherMasterTruth::acts(bool edge, bool reference, can::Time now) {
  hear(now);
  if (forced(now)) {
    ++met["sent_by_force"];
  } else {
    check_listening(edge, now);
    check_other(edge, now);
  }
  if (edge && last_other_ > kLongAgo && now - last_other_ > kQuiet && now - last_edge_ > kQuiet)
    ++met["began_when_the_other_had_gone"];
  if (edge) {
    ++edges_;
    last_edge_ = now;
  }
  if (reference) last_reference_ = now;
}

void OtherMasterTruth::check_listening(bool edge, can::Time now) {
  const char* const what = edge ? "a SYNC edge" : "a telegram";
  const Outages::Gap* const gap = outages_.newest(now);
  if (gap != nullptr && !looked_since(gap->outage.from, now)) return;
  if (gap != nullptr && now < gap->back) {
    // With the cable off the wire of SYNC is there, and who is on the bus is not known.
    if (gap->outage.kind != Outage::Kind::cable_off)
      violated(kListens, std::string(what) + " while the bus is not there", now);
    return;
  }
  const can::Time there = gap != nullptr ? gap->back : can::Time{0};
  if (now - there >= plan_.line.settings.startup.listen) return;
  violated(kListens, std::string(what) + " after " + ms(now - there) + " on the bus", now);
}

void OtherMasterTruth::check_other(bool edge, can::Time now) {
  const std::string what = edge ? "a SYNC edge " : "a telegram ";
  if (needs_command_ && (taken_ || edges_ > 1)) violated(kCommand, what + "without a command", now);
  if (now - last_other_ > kQuiet) return;
  const bool after_silence = now - last_edge_ > 3 * interval_ / 2;
  const bool at_once = edge ? after_silence : !may_run_;
  if (!taken_ && row_judged_ && edges_ == 0 && !at_once) return;
  violated(kSilent, what + ms(now - last_other_) + " after a frame of the other master", now);
}

}  // namespace cansyncd::campaign
