#include "cli/scan/rate_trials.h"

#include <fmt/format.h>

#include <stdexcept>

namespace cansync::cli {
namespace {

/// An interface that is set for a while, and set back at the end.
class BorrowedInterface {
 public:
  BorrowedInterface(std::string name, const can::LinkFacts& before, const RateTools& tools)
      : name_(std::move(name)), before_(before), tools_(tools) {
    const ChildResult told = tools_.ip({"-details", "link", "show", name_});
    listened_ = told.output.find("LISTEN-ONLY") != std::string::npos;
  }
  ~BorrowedInterface() {
    // What fails here was said already, or `ip link show` tells it.
    try {
      tools_.ip({"link", "set", name_, "down"});
      if (before_.timing) tools_.ip(rate_words(before_.timing->bits_per_second, listened_));
      if (before_.up) tools_.ip({"link", "set", name_, "up"});
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
