#pragma once

#include <cansync/types.h>

#include <chrono>
#include <functional>
#include <string>
#include <string_view>

/// Trying again what surely did nothing (`--retry`). Main thread only.
namespace cansync::cli {

/// What a request does to the line.
enum class Effect : unsigned char {
  reads,    ///< repeating it changes nothing
  changes,  ///< it must not be done twice
};

/// Was nothing done, and can the reason pass by itself? True for a refusal because of what is the case now (a
/// full queue, the operating state, a slave that is away or held out), and when there was no daemon to send
/// the request to. For a request that reads also when no answer came. Never for a request that changes
/// something and may have reached the slave.
bool worth_repeating(Effect effect, const client::Reply& reply);

/// The time that `--retry` gives, the pauses, and what is said about them.
class Retry {
 public:
  using Clock = std::chrono::steady_clock;
  /// Clock, pause and remarks, for tests to replace.
  struct World {
    std::function<Clock::time_point()> now;
    std::function<bool(Clock::time_point until)> pause;  ///< true: Ctrl-C came meanwhile
    std::function<void(std::string_view text)> say;
  };
  enum class Verdict : unsigned char { again, over, interrupted };

  /// `seconds`: from the first failure on; 0 = never try again.
  Retry(double seconds, World world) : seconds_(seconds), world_(std::move(world)) {}
  /// Says how often something was tried again.
  ~Retry();
  Retry(const Retry&) = delete;
  Retry& operator=(const Retry&) = delete;

  /// Something failed that is worth repeating: pauses, first 100 ms, then longer up to 1 s, and never beyond
  /// the time. The first failure is said with its `reason`.
  Verdict failed(std::string_view reason);

 private:
  double seconds_;
  World world_;
  Clock::time_point end_;
  std::chrono::milliseconds pause_{100};
  unsigned repeated_ = 0;
  bool failed_ = false;
};

}  // namespace cansync::cli
