#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <string>
#include <thread>
#include <vector>

#include "small/small_course.h"

namespace cansyncd::campaign {

/// So many schedules meet everything there is to meet.
inline constexpr std::uint64_t kEnough = 2000;

/// A schedule that has violated an invariant.
struct Failure {
  std::uint64_t seed = 0;
  Violation violation;
};

/// Calls `play` with 0..schedules-1, on so many threads. Returns how many seconds it took.
template <class Play>
double share_out(std::uint64_t schedules, std::uint64_t jobs, const Play& play) {
  const auto begun = std::chrono::steady_clock::now();
  std::atomic<std::uint64_t> next{0};
  std::vector<std::thread> threads;
  for (std::uint64_t i = std::max<std::uint64_t>(1, std::min(jobs, schedules)); i > 0; --i) {
    threads.emplace_back([&] {
      for (std::uint64_t k = next++; k < schedules; k = next++) play(k);
    });
  }
  for (std::thread& thread : threads) thread.join();
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begun;
  return took.count();
}

/// Prints the first failures, each with the command that plays it again: `again`, the seed, `options`.
void print_failures(std::vector<Failure> failures, const std::string& again, const std::string& options);

/// One digest of all.
std::uint64_t joined(const std::vector<std::uint64_t>& digests) noexcept;

/// Plays so many schedules of a small course and prints what became of them; 0: well.
int play_small(const SmallCourse& course, std::uint64_t schedules, std::uint64_t seed, std::uint64_t jobs,
               const char* program);
/// Plays one of them and prints everything that happens.
int play_small_one(const SmallCourse& course, std::uint64_t seed);

}  // namespace cansyncd::campaign
