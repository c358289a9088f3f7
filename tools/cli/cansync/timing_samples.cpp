#include "cli/cansync/timing_samples.h"

#include <chrono>

#include "cli/base/interrupt.h"

namespace cansync::cli {
namespace {

constexpr auto kSampleWait = std::chrono::milliseconds(3000);
constexpr auto kLook = std::chrono::milliseconds(20);
constexpr std::size_t kMost = 16;  // nobody asks for older ones

}  // namespace

SampleQueue::SampleQueue(client::Client& client)
    : subscription_(client.on_timing([this](const client::Timing& timing) { put(timing); })) {}

std::optional<client::Timing> SampleQueue::next() {
  const auto end = std::chrono::steady_clock::now() + kSampleWait;
  while (std::chrono::steady_clock::now() < end) {
    if (auto sample = take()) return sample;
    if (wait_until(std::chrono::steady_clock::now() + kLook)) return std::nullopt;
  }
  return std::nullopt;
}

void SampleQueue::put(const client::Timing& timing) {
  const std::lock_guard lock(mutex_);
  if (samples_.size() == kMost) samples_.pop_front();
  samples_.push_back(timing);
}

std::optional<client::Timing> SampleQueue::take() {
  const std::lock_guard lock(mutex_);
  if (samples_.empty()) return std::nullopt;
  const client::Timing first = samples_.front();
  samples_.pop_front();
  return first;
}

}  // namespace cansync::cli
