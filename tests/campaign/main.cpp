// The fault campaign: seeded random schedules of faults and jobs in virtual time. docs/reliability.md.
#include <algorithm>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "course.h"
#include "schedules.h"
#include "small/small_course.h"

namespace {

using namespace cansyncd::campaign;

struct Options {
  std::uint64_t schedules = 10'000;
  std::uint64_t seed = 1;
  std::uint64_t intervals = 0;
  std::uint64_t jobs = std::max(1u, std::thread::hardware_concurrency());
  const SmallCourse* course = nullptr;  ///< null: the great one
  bool one = false;
  bool help = false;
};

constexpr const char* kUsage =
    "usage: fault_campaign [--schedules N] [--seed S] [--jobs N] [--intervals N]\n"
    "       fault_campaign --one SEED [--intervals N]\n"
    "  --schedules N  how many schedules (10000); number k has seed S + k\n"
    "  --seed S       first seed (1)\n"
    "  --one SEED     exactly that schedule, and everything that happens in words\n"
    "  --course NAME  instead of the great course: other_master, which_drive\n"
    "  --jobs N       threads (as many as there are processors); the result does not depend on it\n"
    "  --intervals N  length of each schedule's part with faults (0: 150 to 600, drawn)\n";

bool number(const char* text, std::uint64_t& value) {
  const char* end = text + std::strlen(text);
  const auto [rest, error] = std::from_chars(text, end, value);
  return error == std::errc() && rest == end;
}

const SmallCourse* course_of(const std::string& name) {
  for (const SmallCourse* course : small_courses()) {
    if (name == course->name) return course;
  }
  return nullptr;
}

bool parse(int argc, char** argv, Options& options) {
  for (int i = 1; i < argc; ++i) {
    const std::string name = argv[i];
    if (name == "--help") {
      options.help = true;
      return true;
    }
    if (name == "--course" && i + 1 < argc && (options.course = course_of(argv[i + 1])) != nullptr) {
      ++i;
      continue;
    }
    std::uint64_t* value = nullptr;
    if (name == "--schedules") value = &options.schedules;
    if (name == "--seed" || name == "--one") value = &options.seed;
    if (name == "--jobs") value = &options.jobs;
    if (name == "--intervals") value = &options.intervals;
    options.one = options.one || name == "--one";
    if (value == nullptr || i + 1 == argc || !number(argv[++i], *value)) {
      std::fprintf(stderr,
                   "fault_campaign: %s: unknown option, or no course or whole number from 0 on behind it\n%s",
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

/// All schedules of the great course, shared out among threads.
class Campaign {
 public:
  explicit Campaign(const Options& options) : options_(options), digests_(options.schedules) {}

  int run(const char* program) {
    return report(program,
                  share_out(options_.schedules, options_.jobs, [this](std::uint64_t k) { play(k); }));
  }

 private:
  void play(std::uint64_t k) {
    const Plan plan = draw_plan(options_.seed + k, options_.intervals);
    const Verdict verdict = Course(plan, nullptr, {}).run();
    digests_[k] = verdict.digest;
    const std::lock_guard lock(mutex_);
    intervals_ += verdict.intervals;
    coverage_.add(verdict.coverage);
    if (verdict.allowed != 0) {
      slowest_ = std::max(slowest_, static_cast<double>(verdict.took) / static_cast<double>(verdict.allowed));
    }
    if (verdict.violation) failures_.push_back({plan.seed, *verdict.violation});
  }

  int report(const char* program, double seconds) {
    const std::string length =
        options_.intervals != 0 ? " --intervals " + std::to_string(options_.intervals) : std::string();
    print_failures(failures_, std::string(program) + " --one ", length);
    const std::uint64_t digest = joined(digests_);
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
    if (options_.schedules < kEnough) return true;
    for (const std::string& name : coverage_.missing()) std::printf("NEVER MET: %s\n", name.c_str());
    return coverage_.missing().empty();
  }

  const Options& options_;
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
  if (options.course != nullptr) {
    if (options.one) return play_small_one(*options.course, options.seed);
    return play_small(*options.course, options.schedules, options.seed, options.jobs, argv[0]);
  }
  return options.one ? run_one(options) : Campaign(options).run(argv[0]);
}
