#include "cli/base/retry.h"

#include <fmt/format.h>

#include <algorithm>

#include "text/counts.h"

namespace cansync::cli {
namespace {

constexpr std::chrono::milliseconds kLongestPause{1000};

}  // namespace

bool worth_repeating(Effect effect, const client::Reply& reply) {
  switch (reply.retry()) {
    case client::Retry::soon:
    case client::Retry::when_state_over:
      return true;
    case client::Retry::look_first:
      return effect == Effect::reads;
    case client::Retry::never:
    case client::Retry::after_change:
      break;
  }
  return false;
}

Retry::~Retry() {
  if (repeated_ > 0) world_.say("tried again " + text::counted(repeated_, "time"));
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
