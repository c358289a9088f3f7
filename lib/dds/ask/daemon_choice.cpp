#include "dds/ask/daemon_choice.h"

#include <algorithm>

namespace gateway::dds {

void DaemonChoice::heard(Place place, const DaemonIdentity& identity) {
  ++heard_;
  for (Known& known : known_) {
    if (known.place != place || known.identity != identity) continue;
    known.last = heard_;
    known.fresh = true;
    return;
  }
  std::erase_if(known_, [place](const Known& known) { return known.place == place; });
  Known& known = known_.emplace_back();
  known.place = place;
  known.identity = identity;
  known.first = known.last = heard_;
}

void DaemonChoice::look(Clock::time_point now, std::span<const Place> matched) {
  if (begun_) watched_ += std::min<std::chrono::nanoseconds>(now - looked_, kLook);
  looked_ = now;
  begun_ = true;
  std::erase_if(known_, [&](const Known& known) {
    return std::find(matched.begin(), matched.end(), known.place) == matched.end();
  });
  for (Known& known : known_) {
    if (known.fresh) known.when = watched_;
    known.fresh = false;
  }
  find_silent();
  view_ = look_at_living();
  choose();
}

void DaemonChoice::find_silent() {
  const auto is_silent = [this](const Known& known) { return watched_ - known.when >= kSilence; };
  // When nothing is heard of anybody, that says nothing of one of them.
  const bool all = std::all_of(known_.begin(), known_.end(), is_silent);
  for (Known& known : known_) known.silent = !all && is_silent(known);
}

DaemonChoice::View DaemonChoice::look_at_living() const {
  std::uint64_t newest = 0;
  std::size_t living = 0;
  for (const Known& known : known_) {
    if (known.silent) continue;
    ++living;
    newest = std::max(newest, known.first);
  }
  if (living <= 1) return living == 0 ? View::none : View::one;
  const bool both = std::any_of(known_.begin(), known_.end(), [newest](const Known& known) {
    return !known.silent && known.first < newest && known.last > newest;
  });
  return both ? View::several : View::unsure;
}

void DaemonChoice::choose() {
  if (view_ != View::one) return;
  const auto only =
      std::find_if(known_.begin(), known_.end(), [](const Known& known) { return !known.silent; });
  const bool first = program_ == DaemonIdentity{};
  if (first || (told_ && only->identity != daemon_)) program_ = only->identity;
  daemon_ = only->identity;
  told_ = false;
}

std::vector<DaemonChoice::Place> DaemonChoice::living() const {
  std::vector<Place> places;
  for (const Known& known : known_) {
    if (!known.silent) places.push_back(known.place);
  }
  return places;
}

bool DaemonChoice::may_answer(const DaemonIdentity& start) const noexcept {
  return std::any_of(known_.begin(), known_.end(),
                     [&start](const Known& known) { return known.identity == start && !known.silent; });
}

void DaemonChoice::program_told() noexcept {
  if (view_ == View::one) {
    program_ = daemon_;
  } else {
    told_ = true;
  }
}

void DaemonChoice::program_told_of(const DaemonIdentity& start) noexcept {
  program_ = start;
}

}  // namespace gateway::dds
