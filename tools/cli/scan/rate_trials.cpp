#include "cli/scan/rate_trials.h"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>
#include <stdexcept>

namespace cansync::cli {
namespace {

/// The time quantum and segments of a bit as `ip -details link show` has them, as words for `ip link set`.
std::vector<std::string> segments_of(const std::string& shown) {
  std::vector<std::string> out;
  std::istringstream words(shown);
  std::string word;
  std::string value;
  while (words >> word) {
    const bool wanted =
        word == "tq" || word == "prop-seg" || word == "phase-seg1" || word == "phase-seg2" || word == "sjw";
    if (!wanted || std::find(out.begin(), out.end(), word) != out.end() || !(words >> value)) continue;
    if (value.find_first_not_of("0123456789") != std::string::npos) continue;
    out.insert(out.end(), {word, value});
  }
  constexpr std::size_t kAll = 10;
  return out.size() == kAll ? out : std::vector<std::string>{};
}

/// An interface that is set for a while, and set back at the end.
class BorrowedInterface {
 public:
  BorrowedInterface(std::string name, const can::LinkFacts& before, const RateTools& tools)
      : name_(std::move(name)), before_(before), tools_(tools) {
    const ChildResult shown = tools_.ip({"-details", "link", "show", name_});
    listened_ = shown.output.find("LISTEN-ONLY") != std::string::npos;
    segments_ = segments_of(shown.output);
    guard_ = tools_.guard ? tools_.guard(commands_back()) : nullptr;
  }
  ~BorrowedInterface() {
    // What fails here was said already, or `ip link show` tells it.
    try {
      for (const auto& words : commands_back()) tools_.ip(words);
    } catch (const std::exception&) {
    }
  }
  BorrowedInterface(const BorrowedInterface&) = delete;
  BorrowedInterface& operator=(const BorrowedInterface&) = delete;

  void set(BitRate rate) {
    expect_done({"link", "set", name_, "down"});
    const ChildResult set = tools_.ip(rate_words(slot_times(rate).bits_per_second, true));
    if (set.status != 0 && set.errors.find("not supported") != std::string::npos)
      throw std::runtime_error(fmt::format(
          "{}: its driver cannot only listen ({}), and at a wrong bit rate it would disturb the line; "
          "nothing was tried. Take the bit rate from the old PLC's program",
          name_, set.errors));
    if (set.status != 0) fail(rate_words(slot_times(rate).bits_per_second, true), set);
    expect_done({"link", "set", name_, "up"});
  }

 private:
  /// A driver that takes no segments refuses the last of the three timings and keeps the one before.
  std::vector<std::vector<std::string>> commands_back() const {
    std::vector<std::vector<std::string>> out{{"link", "set", name_, "down"}};
    if (before_.timing) {
      auto words = rate_words(before_.timing->bits_per_second, listened_);
      out.push_back(words);
      const unsigned point = before_.timing->sample_point;
      if (point > 0) {
        words.insert(words.end(), {"sample-point", fmt::format("{}.{:03}", point / 1000, point % 1000)});
        out.push_back(std::move(words));
      }
      if (!segments_.empty()) {
        out.push_back({"link", "set", name_, "type", "can"});
        out.back().insert(out.back().end(), segments_.begin(), segments_.end());
      }
    }
    if (before_.up) out.push_back({"link", "set", name_, "up"});
    return out;
  }
  std::vector<std::string> rate_words(std::uint32_t bits_per_second, bool listens) const {
    return {"link",
            "set",
            name_,
            "type",
            "can",
            "bitrate",
            fmt::format("{}", bits_per_second),
            "listen-only",
            listens ? "on" : "off"};
  }
  void expect_done(const std::vector<std::string>& words) {
    const ChildResult result = tools_.ip(words);
    if (result.status != 0) fail(words, result);
  }
  [[noreturn]] static void fail(const std::vector<std::string>& words, const ChildResult& result) {
    std::string typed = "ip";
    for (const std::string& word : words) typed += " " + word;
    throw std::runtime_error(fmt::format("`{}` failed: {} (it needs root)", typed, result.errors));
  }

  std::string name_;
  const can::LinkFacts& before_;
  const RateTools& tools_;
  bool listened_ = false;
  std::vector<std::string> segments_;  ///< "tq", "125", ...; empty: not shown
  std::shared_ptr<void> guard_;        ///< does the same when this process is killed
};

std::uint64_t good_frames(const observe::Census& census) {
  return census.frames - census.error_frames;
}

}  // namespace

std::vector<RateTrial> try_rates(const std::string& interface, const can::LinkFacts& before,
                                 const RateTools& tools) {
  std::vector<RateTrial> trials;
  BorrowedInterface borrowed(interface, before, tools);
  for (const SlotTimes& times : kSlotTimes) {
    if (tools.stopped()) break;
    borrowed.set(times.bit_rate);
    trials.push_back({times.bit_rate, tools.listen()});
  }
  return trials;
}

const RateTrial* heard_trial(const std::vector<RateTrial>& trials) {
  const RateTrial* best = nullptr;
  const auto fits = [](const RateTrial& trial) {
    return trial.census.interval.votes > 0 && trial.census.interval.bit_rate == trial.bit_rate;
  };
  for (const RateTrial& trial : trials) {
    if (good_frames(trial.census) == 0 || trial.census.error_frames > good_frames(trial.census)) continue;
    const bool better = best == nullptr || (fits(trial) && !fits(*best)) ||
                        (fits(trial) == fits(*best) && good_frames(trial.census) > good_frames(best->census));
    if (better) best = &trial;
  }
  return best;
}

}  // namespace cansync::cli
