#include "dbc/choices.h"

#include <fmt/format.h>

#include <algorithm>

#include "text/counts.h"

namespace dbc {
namespace {

constexpr std::size_t kNone = static_cast<std::size_t>(-1);

/// Does the chain of choices that begins with this signal come to an end?
bool comes_to_an_end(const std::vector<Signal>& signals, std::size_t signal) {
  for (std::size_t steps = 0; steps <= signals.size(); ++steps) {
    if (!signals[signal].chosen_by) return true;
    signal = signals[signal].chosen_by->multiplexor;
  }
  return false;
}

/// Takes out what is wrong, and with it what a signal chooses that goes; `wrong` has a reason for each.
void take_out(Message& message, std::vector<std::string>& wrong) {
  std::vector<Signal>& signals = message.signals;
  for (bool found = true; found;) {
    found = false;
    for (std::size_t i = 0; i < signals.size(); ++i) {
      if (!wrong[i].empty() || !signals[i].chosen_by) continue;
      const std::size_t by = signals[i].chosen_by->multiplexor;
      if (wrong[by].empty()) continue;
      wrong[i] = fmt::format("its multiplexor {} is left out", signals[by].name);
      found = true;
    }
  }
  std::vector<std::size_t> place(signals.size(), kNone);
  std::vector<Signal> kept;
  for (std::size_t i = 0; i < signals.size(); ++i) {
    if (!wrong[i].empty()) continue;
    place[i] = kept.size();
    kept.push_back(std::move(signals[i]));
  }
  for (Signal& signal : kept)
    if (signal.chosen_by) signal.chosen_by->multiplexor = place[signal.chosen_by->multiplexor];
  signals = std::move(kept);
}

}  // namespace

void Choices::add_ranges(std::size_t signal, std::size_t multiplexor,
                         std::vector<std::pair<std::uint64_t, std::uint64_t>> ranges) {
  signals_[signal].named = Choice{multiplexor, std::move(ranges)};
}

Choices::Multiplexors Choices::multiplexors_of(const Message& message) const {
  Multiplexors found;
  for (std::size_t i = 0; i < signals_.size(); ++i) {
    if (!message.signals[i].chooses) continue;
    ++found.all;
    if (signals_[i].mark || signals_[i].named) continue;
    ++found.unchosen;
    found.last_unchosen = i;
  }
  return found;
}

void Choices::resolve(Message& message,
                      const std::function<void(std::size_t, const std::string&)>& left_out) const {
  std::vector<std::string> wrong(message.signals.size());
  const Multiplexors multiplexors = multiplexors_of(message);
  for (std::size_t i = 0; i < message.signals.size(); ++i) {
    const Said& said = signals_[i];
    message.signals[i].chosen_by = said.named;
    if (said.named || !said.mark) continue;
    // Without SG_MUL_VAL_ the multiplexor must be the only one there can be.
    const bool sure = multiplexors.unchosen == 1 && (multiplexors.all == 1 || message.signals[i].chooses);
    if (sure)
      message.signals[i].chosen_by = Choice{multiplexors.last_unchosen, {{*said.mark, *said.mark}}};
    else
      wrong[i] =
          multiplexors.all == 0
              ? "the message has no multiplexor (M)"
              : fmt::format("no SG_MUL_VAL_ names its multiplexor; the message has {}", multiplexors.all);
  }
  for (std::size_t i = 0; i < message.signals.size(); ++i) {
    if (!wrong[i].empty() || comes_to_an_end(message.signals, i)) continue;
    wrong[i] = "its multiplexors choose each other";
  }
  for (std::size_t i = 0; i < message.signals.size(); ++i)
    if (!lies_in(message.signals[i], message.length))
      wrong[i] = fmt::format("it does not fit into the {} of message {}",
                             text::counted(message.length, "byte"), message.name);
  if (std::all_of(wrong.begin(), wrong.end(), [](const std::string& one) { return one.empty(); })) return;
  take_out(message, wrong);
  for (std::size_t i = 0; i < wrong.size(); ++i)
    if (!wrong[i].empty()) left_out(i, wrong[i]);
}

}  // namespace dbc
