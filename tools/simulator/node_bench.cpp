#include "simulator/node_bench.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "text/counts.h"

namespace cansync_sim {

NodeBench::NodeBench(std::unique_ptr<sim::Node> node, can::Time now) : node_(std::move(node)) {
  push(node_->on_join(now));
}

void NodeBench::push(const std::optional<sim::Transmission>& transmission) noexcept {
  if (!transmission) return;
  sim::PendingFrame pending;
  pending.frame = transmission->frame;
  pending.ready = transmission->not_before;
  pending.order = order_++;
  pending.key = sim::arbitration_key(pending.frame);
  if (!waiting_.push(pending)) ++counters_.not_sent;
}

void NodeBench::receive(const can::ReceivedFrame& received, can::Time) noexcept {
  if (received.frame.error) {
    ++counters_.error_frames;
    return;
  }
  ++counters_.received;
  if (node_->accepts(received.frame)) push(node_->on_frame(received.frame, received.end));
}

can::Time NodeBench::next_due() const noexcept {
  return std::min(waiting_.earliest().value_or(can::Time::max()),
                  node_->next_time().value_or(can::Time::max()));
}

std::optional<can::Frame> NodeBench::next(can::Time now) noexcept {
  while (node_->next_time().value_or(can::Time::max()) <= now) push(node_->on_time(now).transmission);
  const sim::PendingFrame* winner = waiting_.winner(now);
  if (winner == nullptr) return std::nullopt;
  last_ = winner->frame;
  last_taken_ = now;
  waiting_.remove(*winner);
  return last_;
}

void NodeBench::sent(can::SendResult result) noexcept {
  if (result != can::SendResult::queued) {
    ++counters_.not_sent;
    return;
  }
  ++counters_.sent;
  push(node_->on_sent(last_, last_taken_));
}

void NodeBench::link_lost() noexcept {
  waiting_.drop(0);
}

std::string summary(const NodeBench& bench, std::uint64_t dropped) {
  const NodeCounters& counters = bench.counters();
  return fmt::format("{} received, {} sent, {} not sent, {}, {} lost by the kernel",
                     text::counted(counters.received, "frame"), counters.sent, counters.not_sent,
                     text::counted(counters.error_frames, "error frame"), text::counted(dropped, "frame"));
}

}  // namespace cansync_sim
