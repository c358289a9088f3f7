#include "schedules.h"

#include <cstdio>
#include <map>
#include <mutex>

namespace cansyncd::campaign {

void print_failures(std::vector<Failure> failures, const std::string& again, const std::string& options) {
  constexpr std::size_t kShown = 20;
  std::sort(failures.begin(), failures.end(),
            [](const Failure& a, const Failure& b) { return a.seed < b.seed; });
  for (std::size_t i = 0; i < std::min(failures.size(), kShown); ++i) {
    const Failure& failure = failures[i];
    std::printf("VIOLATED in interval %llu: %s: %s\n  again: %s%llu%s\n",
                static_cast<unsigned long long>(failure.violation.interval),
                failure.violation.invariant.c_str(), failure.violation.what.c_str(), again.c_str(),
                static_cast<unsigned long long>(failure.seed), options.c_str());
  }
}

std::uint64_t joined(const std::vector<std::uint64_t>& digests) noexcept {
  std::uint64_t digest = 0;
  for (const std::uint64_t one : digests) digest = (digest ^ one) * 0x100000001B3u + (digest >> 29);
  return digest;
}

int play_small(const SmallCourse& course, std::uint64_t schedules, std::uint64_t seed, std::uint64_t jobs,
               const char* program) {
  std::vector<std::uint64_t> digests(schedules);
  std::vector<Failure> failures;
  std::map<std::string, std::uint64_t> met;
  std::uint64_t intervals = 0;
  std::mutex mutex;
  const double seconds = share_out(schedules, jobs, [&](std::uint64_t k) {
    const SmallVerdict verdict = course.play(seed + k, nullptr, {});
    digests[k] = verdict.digest;
    const std::lock_guard lock(mutex);
    intervals += verdict.intervals;
    for (const auto& [name, times] : verdict.met) met[name] += times;
    if (verdict.violation) failures.push_back({seed + k, *verdict.violation});
  });
  print_failures(failures, std::string(program) + " --course " + course.name + " --one ", "");
  bool all_met = true;
  std::printf("met:");
  for (const auto& [name, times] : met) {
    std::printf(" %s %llu,", name.c_str(), static_cast<unsigned long long>(times));
    all_met = all_met && times != 0;
  }
  std::printf("\n%llu schedules of %s, %llu intervals, %.1f s\n", static_cast<unsigned long long>(schedules),
              course.name, static_cast<unsigned long long>(intervals), seconds);
  std::printf("digest %016llx, %zu schedules with a violation\n",
              static_cast<unsigned long long>(joined(digests)), failures.size());
  if (schedules >= kEnough && !all_met) std::printf("NEVER MET: a situation above\n");
  return failures.empty() && (schedules < kEnough || all_met) ? 0 : 1;
}

int play_small_one(const SmallCourse& course, std::uint64_t seed) {
  const SmallVerdict verdict =
      course.play(seed, nullptr, [](const std::string& text) { std::printf("%s\n", text.c_str()); });
  std::printf("digest %016llx, %llu intervals\n", static_cast<unsigned long long>(verdict.digest),
              static_cast<unsigned long long>(verdict.intervals));
  if (!verdict.violation) return 0;
  std::printf("VIOLATED in interval %llu: %s: %s\n",
              static_cast<unsigned long long>(verdict.violation->interval),
              verdict.violation->invariant.c_str(), verdict.violation->what.c_str());
  return 1;
}

}  // namespace cansyncd::campaign
