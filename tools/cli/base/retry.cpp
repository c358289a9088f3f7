#include "cli/base/retry.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace cansync::cli {
namespace {

constexpr std::chrono::milliseconds kLongestPause{1000};

/// How the reasons of refusals begin that pass by themselves, or when somebody else has done his part. Those
/// of the daemon are in daemon/cansync/texts/refusal_text.cpp and daemon/desk/rejections.cpp; a test
/// compares.
constexpr std::array<std::string_view, 5> kPassing = {"queue full", "state: ", "slaves: not yet",
                                                      "too many clients", "stale: "};
/// Likewise, with a name or a number before.
constexpr std::array<std::string_view, 4> kPassingInside = {" does not answer; check",
                                                            " is held out, so that", "; try again later",
                                                            "; wait for open requests to end"};

bool passes(std::string_view reason) {
  const auto begins = [reason](std::string_view start) { return reason.starts_with(start); };
  const auto holds = [reason](std::string_view part) { return reason.find(part) != std::string_view::npos; };
  return std::any_of(kPassing.begin(), kPassing.end(), begins) ||
         std::any_of(kPassingInside.begin(), kPassingInside.end(), holds);
}

}  // namespace

bool worth_repeating(Effect effect, const client::Reply& reply) {
  using client::ReplyCode;
  switch (reply.code) {
    case ReplyCode::refused:
      return passes(reply.reason);
    case ReplyCode::no_reply:
      return effect == Effect::reads || reply.reason.ends_with("; nothing was sent");
    case ReplyCode::timeout:
    case ReplyCode::no_answer:
    case ReplyCode::slave_lost:
    case ReplyCode::master_stopped:
      return effect == Effect::reads;
    default:
      return false;
  }
}

Retry::~Retry() {
  if (repeated_ > 0)
    world_.say(fmt::format("tried again {} {}", repeated_, repeated_ == 1 ? "time" : "times"));
}

Retry::Verdict Retry::failed(std::string_view reason) {
  if (seconds_ <= 0.0) return Verdict::over;
  if (!failed_) {
    end_ =
        world_.now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds_));
    world_.say(fmt::format("trying again for {:g} s: {}", seconds_, reason));
    failed_ = true;
  }
  if (world_.now() >= end_) return Verdict::over;
  const bool stop = world_.pause(std::min(end_, world_.now() + pause_));
  if (stop) return Verdict::interrupted;
  pause_ = std::min(2 * pause_, kLongestPause);
  ++repeated_;
  return Verdict::again;
}

}  // namespace cansync::cli
