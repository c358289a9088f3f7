// The fault campaign: seeded random schedules of faults and jobs in virtual time. docs/reliability.md.
#include <algorithm>
#include <atomic>
#include <charconv>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "course.h"

namespace {

using namespace cansyncd::campaign;

struct Options {
  std::uint64_t schedules = 10'000;
  std::uint64_t seed = 1;
  std::uint64_t intervals = 0;
  std::uint64_t jobs = std::max(1u, std::thread::hardware_concurrency());
  bool one = false;
  bool help = false;
};

constexpr const char* kUsage =
    "usage: fault_campaign [--schedules N] [--seed S] [--jobs N] [--intervals N]\n"
    "       fault_campaign --one SEED [--intervals N]\n"
    "  --schedules N  how many schedules (10000); number k has seed S + k\n"
    "  --seed S       first seed (1)\n"
    "  --one SEED     exactly that schedule, and everything that happens in words\n"
    "  --jobs N       threads (as many as there are processors); the result does not depend on it\n"
    "  --intervals N  length of each schedule's part with faults (0: 150 to 600, drawn)\n";

bool number(const char* text, std::uint64_t& value) {
  const char* end = text + std::strlen(text);
  const auto [rest, error] = std::from_chars(text, end, value);
  return error == std::errc() && rest == end;
}

bool parse(int argc, char** argv, Options& options) {
  for (int i = 1; i < argc; ++i) {
    const std::string name = argv[i];
    if (name == "--help") {
      options.help = true;
      return true;
    }
    std::uint64_t* value = nullptr;
    if (name == "--schedules") value = &options.schedules;
    if (name == "--seed" || name == "--one") value = &options.seed;
    if (name == "--jobs") value = &options.jobs;
    if (name == "--intervals") value = &options.intervals;
    options.one = options.one || name == "--one";
    if (value == nullptr || i + 1 == argc || !number(argv[++i], *value)) {
      std::fprintf(stderr, "fault_campaign: %s: unknown option, or no whole number from 0 on behind it\n%s",
                   name.c_str(), kUsage);
      return false;
    }
  }
  return true;
}

int run_one(const Options& options) {
  const Plan plan = draw_plan(options.seed, options.intervals);
  std::printf("%s", describe(plan).c_str());
  Course course(plan, nullptr, [](const std::string& text) { std::printf("%s\n", text.c_str()); });
  const Verdict verdict = course.run();
  std::printf(
      "digest %016llx, %llu intervals, back in normal operation after %llu of %llu\n",
      static_cast<unsigned long long>(verdict.digest), static_cast<unsigned long long>(verdict.intervals),
      static_cast<unsigned long long>(verdict.took), static_cast<unsigned long long>(verdict.allowed));
  if (!verdict.violation) return 0;
  std::printf("VIOLATED after interval %llu: %s: %s\n",
              static_cast<unsigned long long>(verdict.violation->interval),
              verdict.violation->invariant.c_str(), verdict.violation->what.c_str());
  return 1;
}

/// All schedules, shared out among threads.
class Campaign {
 public:
  explicit Campaign(const Options& options) : options_(options), digests_(options.schedules) {}

  int run(const char* program) {
    const auto begun = std::chrono::steady_clock::now();
    std::vector<std::thread> threads;
    const std::uint64_t wanted = std::max<std::uint64_t>(1, std::min(options_.jobs, options_.schedules));
    for (std::uint64_t i = 0; i < wanted; ++i) threads.emplace_back([this] { work(); });
    for (std::thread& thread : threads) thread.join();
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begun;
    return report(program, took.count());
  }

 private:
  struct Failure {
    std::uint64_t seed = 0;
    Violation violation;
  };

  void work() {
    for (std::uint64_t k = next_++; k < options_.schedules; k = next_++) {
      const Plan plan = draw_plan(options_.seed + k, options_.intervals);
      const Verdict verdict = Course(plan, nullptr, {}).run();
      digests_[k] = verdict.digest;
      const std::lock_guard lock(mutex_);
      intervals_ += verdict.intervals;
      coverage_.add(verdict.coverage);
      if (verdict.allowed != 0) {
        slowest_ =
            std::max(slowest_, static_cast<double>(verdict.took) / static_cast<double>(verdict.allowed));
      }
      if (verdict.violation) failures_.push_back({plan.seed, *verdict.violation});
    }
  }

  int report(const char* program, double seconds) {
    constexpr std::size_t kShown = 20;
    std::sort(failures_.begin(), failures_.end(),
              [](const Failure& a, const Failure& b) { return a.seed < b.seed; });
    for (std::size_t i = 0; i < std::min(failures_.size(), kShown); ++i) {
      const Failure& failure = failures_[i];
      std::printf("VIOLATED in interval %llu: %s: %s\n  again: %s --one %llu",
                  static_cast<unsigned long long>(failure.violation.interval),
                  failure.violation.invariant.c_str(), failure.violation.what.c_str(), program,
                  static_cast<unsigned long long>(failure.seed));
      if (options_.intervals != 0) {
        std::printf(" --intervals %llu", static_cast<unsigned long long>(options_.intervals));
      }
      std::printf("\n");
    }
    std::uint64_t digest = 0;
    for (const std::uint64_t one : digests_) digest = (digest ^ one) * 0x100000001B3u + (digest >> 29);
    std::printf("%s", coverage_.text().c_str());
    std::printf("%llu schedules, %llu intervals, %.1f s; slowest recovery took %.0f %% of its bound\n",
                static_cast<unsigned long long>(options_.schedules),
                static_cast<unsigned long long>(intervals_), seconds, slowest_ * 100);
    std::printf("digest %016llx, %zu schedules with a violation\n", static_cast<unsigned long long>(digest),
                failures_.size());
    return failures_.empty() && everything_met() ? 0 : 1;
  }

  /// So many schedules meet everything there is to meet.
  bool everything_met() const {
    constexpr std::uint64_t kEnough = 2000;
    if (options_.schedules < kEnough) return true;
    for (const std::string& name : coverage_.missing()) std::printf("NEVER MET: %s\n", name.c_str());
    return coverage_.missing().empty();
  }

  const Options& options_;
  std::atomic<std::uint64_t> next_{0};
  std::vector<std::uint64_t> digests_;
  std::mutex mutex_;
  std::uint64_t intervals_ = 0;
  double slowest_ = 0;
  Coverage coverage_;
  std::vector<Failure> failures_;
};

}  // namespace

int main(int argc, char** argv) {
  Options options;
  if (!parse(argc, argv, options)) return 2;
  if (options.help) {
    std::printf("%s", kUsage);
    return 0;
  }
  return options.one ? run_one(options) : Campaign(options).run(argv[0]);
}
