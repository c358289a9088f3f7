#include "j1939/provider.h"

#include <algorithm>
#include <array>
#include <utility>

namespace j1939 {
Provider::Provider(std::vector<Provided> provided, const AddressClaim& claim, FrameQueue& replies,
                   Outbox& outbox)
    : provided_(std::move(provided)),
      due_(provided_.size(), Time::max()),
      claim_(claim),
      replies_(replies),
      outbox_(outbox) {}

void Provider::requested(const Message& request, Pgn number) noexcept {
  if (!claim_.address() || request.source >= kNullAddress) return;
  const auto found = std::find_if(provided_.begin(), provided_.end(),
                                  [number](const Provided& each) { return each.number == number; });
  if (found == provided_.end()) return acknowledge(request, number, Acknowledgement::Kind::negative);
  if (found->data.empty()) return;
  const bool for_all = request.destination == kGlobalAddress;
  if (send(*found, for_all ? kGlobalAddress : request.source, false) != Outbox::OwnMessage::full) return;
  unanswered_ += for_all;
  acknowledge(request, number, Acknowledgement::Kind::cannot_respond);
}

/// `by_itself`: while the one before waits, another is not sent.
Outbox::OwnMessage Provider::send(const Provided& provided, Address to, bool by_itself) noexcept {
  if (provided.data.size() > 8)
    return outbox_.send_own(provided.number, provided.priority, to, provided.data);
  can::Frame frame;
  frame.extended = true;
  frame.id = compose(identifier_of(provided.number, provided.priority, to, *claim_.address()));
  frame.dlc = static_cast<std::uint8_t>(provided.data.size());
  std::copy(provided.data.begin(), provided.data.end(), frame.data.begin());
  if (by_itself && replies_.has(frame.id)) return Outbox::OwnMessage::waiting;
  replies_.push(frame);
  return Outbox::OwnMessage::taken;
}

void Provider::advance(Time now) noexcept {
  for (std::size_t i = 0; i < provided_.size(); ++i) {
    const Provided& provided = provided_[i];
    if (provided.period <= Time{0} || provided.data.empty()) continue;
    Time& due = due_[i];
    if (stopped_ || !claim_.address()) {
      due = Time::max();
      continue;
    }
    if (due == Time::max()) due = now;
    if (due > now) continue;
    left_out_ += send(provided, kGlobalAddress, true) != Outbox::OwnMessage::taken;
    due += ((now - due) / provided.period + 1) * provided.period;
  }
}

Time Provider::next_deadline(Time now) const noexcept {
  Time next = Time::max();
  if (stopped_ || !claim_.address()) return next;
  for (std::size_t i = 0; i < provided_.size(); ++i) {
    if (provided_[i].period > Time{0} && !provided_[i].data.empty())
      next = std::min(next, due_[i] == Time::max() ? now : due_[i]);
  }
  return next;
}

/// Requests to all are never answered so: every node would.
void Provider::acknowledge(const Message& request, Pgn number, Acknowledgement::Kind kind) noexcept {
  if (request.destination != kGlobalAddress)
    replies_.push(frame_of(Acknowledgement{kind, request.source, number}, *claim_.address()));
}

}  // namespace j1939
