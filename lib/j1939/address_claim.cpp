#include "j1939/address_claim.h"

#include <algorithm>

#include "j1939/codec.h"

namespace j1939 {

void ClaimTable::claimed(Address address, Name name) noexcept {
  bool changed = false;
  for (unsigned i = 0; i < kAddresses; ++i) {
    if (i == address || names_[i] != name) continue;
    names_[i].reset();
    changed = true;
  }
  if (address < kAddresses && names_[address] != name) {
    names_[address] = name;
    changed = true;
  }
  if (changed) ++revision_;
}

void ClaimTable::clear() noexcept {
  names_ = {};
  ++revision_;
}

std::optional<Name> ClaimTable::at(Address address) const noexcept {
  return address < kAddresses ? names_[address] : std::nullopt;
}

namespace {

can::Frame request_for_all() noexcept {
  return request_frame(pgn::kAddressClaimed, kNullAddress, kGlobalAddress);
}

}  // namespace

void AddressClaim::start(Time now) noexcept {
  now_ = now;
  if (!settings_.preferred) return;  // who listens sends nothing
  ask_ = true;
  name_twice_ = false;
  const Address own = address_ <= 253 ? address_ : *settings_.preferred;
  if (settings_.ask_time <= Time{0}) return claim(own);
  enter(ClaimEvent::ask);
  table_.clear();  // those who are there answer
  address_ = own;
  asked_until_ = Time::max();
  say_ = false;
}

void AddressClaim::enter(ClaimEvent event) noexcept {
  state_ = next(state_, event).value_or(state_);
  claimed_at_ = Time::max();
}

bool AddressClaim::own_name_heard() const noexcept {
  for (unsigned i = 0; i < ClaimTable::kAddresses; ++i) {
    if (table_.at(static_cast<Address>(i)) == settings_.name) return true;
  }
  return false;
}

/// The answers are there: another's address is left to it.
void AddressClaim::claim_what_is_free(Time now) noexcept {
  name_twice_ = own_name_heard();
  if (!name_twice_ && !table_.at(address_)) return claim(address_);
  const auto other = another();
  if (other) return claim(*other);
  give_up(now);
}

void AddressClaim::claim(Address address) noexcept {
  enter(ClaimEvent::claim);
  address_ = address;
  say_ = true;
  say_not_before_ = now_;
}

/// Those who cannot claim must not all say so in the same instant: 0 to 153 ms, by the NAME.
Time AddressClaim::answer_delay() const noexcept {
  unsigned sum = 0;
  for (unsigned i = 0; i < 8; ++i) sum += static_cast<unsigned>(settings_.name >> 8 * i & 0xFF);
  return std::chrono::microseconds(600) * (sum & 0xFF);
}

void AddressClaim::give_up(Time now) noexcept {
  enter(ClaimEvent::none_left);
  address_ = kNullAddress;
  say_ = true;
  say_not_before_ = now + answer_delay();
}

std::optional<Address> AddressClaim::another() const noexcept {
  if (!fields_of(settings_.name).arbitrary_address || name_twice_) return std::nullopt;
  for (unsigned i = settings_.first_other; i <= settings_.last_other; ++i) {
    const auto address = static_cast<Address>(i);
    if (address != address_ && !table_.at(address)) return address;
  }
  return std::nullopt;
}

void AddressClaim::claim_received(Address source, Name name, Time now) noexcept {
  now_ = std::max(now_, now);
  table_.claimed(source, name);
  if (!wanted()) return;
  if (name == settings_.name) {
    // Who cannot claim takes nothing away.
    if (source == kNullAddress) return;
    // Two with one NAME would answer each other's claims for ever.
    name_twice_ = true;
    ++losses_;
    give_up(now);
    return;
  }
  if (source != address_) return;
  if (settings_.name < name) {
    say_ = true;
    say_not_before_ = now;
    return;
  }
  ++losses_;
  if (const auto other = another()) {
    claim(*other);
  } else {
    give_up(now);
  }
}

void AddressClaim::claim_requested(Time now) noexcept {
  if (state_ == ClaimState::listening || state_ == ClaimState::asking || say_) return;
  say_ = true;
  say_not_before_ = now + (state_ == ClaimState::cannot_claim ? answer_delay() : Time{0});
}

bool AddressClaim::commanded(Name name, Address address, Time now) noexcept {
  if (!settings_.takes_commands || state_ == ClaimState::listening) return false;
  if (name != settings_.name || address >= ClaimTable::kAddresses) return false;
  now_ = std::max(now_, now);
  if (wanted() != address) claim(address);
  return true;
}

void AddressClaim::own_address_used(Time now) noexcept {
  ++intruders_;
  if (state_ != ClaimState::claimed) return;
  if (defended_ != Time::min() && now < defended_ + kDefenceTime) return;
  defended_ = now;
  say_ = true;
  say_not_before_ = now;
}

std::optional<can::Frame> AddressClaim::next_frame() const noexcept {
  if (ask_) {
    return request_for_all();
  }
  if (say_ && say_not_before_ <= now_) return claim_frame(settings_.name, address_);
  return std::nullopt;
}

void AddressClaim::handed_over() noexcept {
  if (ask_) {
    ask_ = false;
  } else {
    say_ = false;
  }
}

void AddressClaim::sent(const can::Frame& frame, Time end) noexcept {
  if (state_ == ClaimState::asking && asked_until_ == Time::max() && frame == request_for_all())
    asked_until_ = end + settings_.ask_time;
  if (state_ != ClaimState::claiming || claimed_at_ != Time::max() ||
      frame != claim_frame(settings_.name, address_))
    return;
  claimed_at_ = end + kClaimTime;
}

void AddressClaim::unseen(const can::Frame& frame) noexcept {
  if (state_ == ClaimState::asking && asked_until_ == Time::max() && frame == request_for_all()) ask_ = true;
  if (state_ != ClaimState::claiming || claimed_at_ != Time::max() ||
      frame != claim_frame(settings_.name, address_))
    return;
  say_ = true;
  say_not_before_ = now_;
}

void AddressClaim::advance(Time now) noexcept {
  now_ = now;
  if (state_ == ClaimState::asking && asked_until_ <= now) claim_what_is_free(now);
  if (state_ == ClaimState::claiming && claimed_at_ <= now) enter(ClaimEvent::undisturbed);
}

Time AddressClaim::next_deadline() const noexcept {
  Time next = Time::max();
  if (state_ == ClaimState::claiming && claimed_at_ > now_) next = claimed_at_;
  if (state_ == ClaimState::asking) next = asked_until_;
  if (say_ && say_not_before_ > now_) next = std::min(next, say_not_before_);
  return next;
}

std::optional<Address> AddressClaim::address() const noexcept {
  return state_ == ClaimState::claimed ? std::optional(address_) : std::nullopt;
}

std::optional<Address> AddressClaim::wanted() const noexcept {
  const bool has = state_ == ClaimState::claiming || state_ == ClaimState::claimed;
  return has ? std::optional(address_) : std::nullopt;
}

}  // namespace j1939
