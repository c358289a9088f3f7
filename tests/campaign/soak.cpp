// The soak: hours of bus time in virtual time with faults now and then. docs/reliability.md.
#include <unistd.h>

#include <charconv>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <string>
#include <vector>

#include "course.h"
#include "support/heap.h"

namespace {

using namespace cansyncd::campaign;

/// Something is provoked in the first intervals of each round; then the line has time to come back.
constexpr std::uint64_t kRound = 20'000;
constexpr std::uint64_t kFaulty = 5'000;
constexpr std::size_t kFaultsAtOnce = 3;
constexpr std::uint64_t kAftermath = 100;
/// Memory may grow by so much after the first tenth: pages touched late and jobs that are open, not what
/// leaks.
constexpr std::uint64_t kGrowth = 512ull * 1024;

struct Options {
  double hours = 24;
  std::uint64_t slaves = 8;
  std::uint64_t seed = 1;
};

constexpr const char* kUsage =
    "usage: soak [--hours H] [--slaves N] [--seed S]\n"
    "  --hours H   bus time at 1 ms an interval (24)\n"
    "  --slaves N  drives on the line, 1..32 (8)\n"
    "  --seed S    of faults and jobs (1)\n";

template <class T>
bool number(const char* text, T& value) {
  const char* end = text + std::strlen(text);
  const auto [rest, error] = std::from_chars(text, end, value);
  return error == std::errc() && rest == end;
}

bool parse(int argc, char** argv, Options& options) {
  for (int i = 1; i < argc; i += 2) {
    const std::string name = argv[i];
    const char* value = i + 1 < argc ? argv[i + 1] : "";
    const bool known = (name == "--hours" && number(value, options.hours)) ||
                       (name == "--slaves" && number(value, options.slaves)) ||
                       (name == "--seed" && number(value, options.seed));
    if (known) continue;
    std::fprintf(stderr, "soak: %s %s: unknown option, or no number behind it\n%s", name.c_str(), value,
                 kUsage);
    return false;
  }
  const bool right = options.hours > 0 && options.slaves >= 1 && options.slaves <= cansync::kSlaves;
  if (!right) std::fprintf(stderr, "soak: more than 0 hours, and 1 to 32 slaves\n%s", kUsage);
  return right;
}

/// Memory of this process that is in use, in bytes.
std::uint64_t resident_bytes() {
  std::ifstream statm("/proc/self/statm");
  std::uint64_t size = 0;
  std::uint64_t resident = 0;
  statm >> size >> resident;
  return resident * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

Plan soak_plan(const Options& options, std::uint64_t intervals) {
  Plan plan;
  plan.seed = options.seed;
  plan.settings.startup.status_period = std::chrono::milliseconds(100);
  plan.settings.process.maximum_slave = *cansync::SlaveNumber::from(options.slaves - 1);
  for (unsigned i = 0; i < options.slaves; ++i) {
    plan.settings.slaves[i].configured = true;
    sim::DriveSettings drive;
    drive.slave.number = *cansync::SlaveNumber::from(i);
    drive.lock_time = std::chrono::milliseconds(100);
    drive.memory.size = 4096;
    plan.drives.push_back(drive);
  }
  plan.sizes.terminals = cansyncd::terminals_for(plan.settings.command_channel, plan.sizes.requests);
  plan.last_fault = intervals;
  plan.stop_at = intervals;
  plan.mix = {.parameters = 200,
              .transfers = 50,
              .control_words = 20,
              .broadcasts = 5,
              .cancels = 5,
              .departures = 1,
              .bursts = 1,
              .references = 1000};
  // Taken up again and again: each round puts others in their place.
  sim::Fault none;
  none.count = 0;
  plan.faults.assign(kFaultsAtOnce, none);
  return plan;
}

/// Puts new faults in the place of the last round's, and looks at what the last round has left behind.
class Rounds {
 public:
  Rounds(Plan& plan, const Options& options) : plan_(plan), dice_(options.seed ^ 0x50A4) {}

  std::optional<std::string> begin(Course& course) {
    const std::uint64_t now = course.line().intervals();
    const cansyncd::MasterSnapshot& state = course.snapshot();
    const bool well = cansync::is_active(state.state) && state.synchronized == state.configured;
    if (rounds_++ != 0 && !well) {
      return "not every slave is synchronized in active operation " + std::to_string(kRound - kFaulty) +
             " intervals after the last fault";
    }
    plan_.restless_until = now + kFaulty + kAftermath;
    std::vector<sim::Fault> faults;
    for (std::size_t i = 0; i < kFaultsAtOnce; ++i) {
      sim::Fault fault = draw_fault(dice_, draw_kind(dice_, faults), plan_, kFaulty);
      fault.from += now;
      fault.to += now;
      faults.push_back(fault);
      hit_.hit(plan_.faults[i].kind, course.line().faults().hits(i));
      course.line().faults().replace(i, fault);
    }
    plan_.faults = faults;
    return std::nullopt;
  }

  std::uint64_t rounds() const noexcept { return rounds_; }
  /// Faults of all rounds but the last, which the course counts itself.
  const Coverage& hit() const noexcept { return hit_; }

 private:
  Plan& plan_;
  Dice dice_;
  std::uint64_t rounds_ = 0;
  Coverage hit_;
};

/// Tells how far it is, and watches the memory.
class Progress {
 public:
  explicit Progress(std::uint64_t intervals) : intervals_(intervals) {}

  void at(std::uint64_t done) {
    const std::uint64_t tenth = done * 10 / intervals_;
    if (tenth == tenth_) return;
    tenth_ = tenth;
    const std::uint64_t percent = 10 * tenth;
    last_ = {resident_bytes(), cansyncd::support::heap_in_use()};
    if (tenth == 1) first_ = last_;
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begun_;
    std::printf(
        "%3llu %%, %llu intervals, %.0f s, %.0f times real time, %llu KiB resident, %llu KiB in use\n",
        static_cast<unsigned long long>(percent), static_cast<unsigned long long>(done), took.count(),
        static_cast<double>(done) / 1000 / took.count(),
        static_cast<unsigned long long>(last_.resident / 1024),
        static_cast<unsigned long long>(last_.in_use / 1024));
    std::fflush(stdout);
  }
  bool grown() const noexcept {
    return last_.in_use > first_.in_use + kGrowth ||
           (!cansyncd::support::kSanitizedHeap && last_.resident > first_.resident + kGrowth);
  }

 private:
  struct Memory {
    std::uint64_t resident = 0;
    std::uint64_t in_use = 0;  ///< of the heap
  };

  std::uint64_t intervals_;
  std::uint64_t tenth_ = 0;
  Memory first_;
  Memory last_;
  std::chrono::steady_clock::time_point begun_ = std::chrono::steady_clock::now();
};

}  // namespace

int main(int argc, char** argv) {
  Options options;
  if (!parse(argc, argv, options)) return 2;
  const auto intervals = static_cast<std::uint64_t>(options.hours * 3600 * 1000);
  Plan plan = soak_plan(options, intervals);
  Course course(plan, nullptr, {});
  Rounds rounds(plan, options);
  Progress progress(intervals);
  course.on_interval = [&](std::uint64_t tick) -> std::optional<std::string> {
    if (tick % 1000 == 0) progress.at(tick);
    return tick % kRound == 0 ? rounds.begin(course) : std::nullopt;
  };
  std::printf("%llu intervals of 1 ms with %llu slaves, seed %llu\n",
              static_cast<unsigned long long>(intervals), static_cast<unsigned long long>(options.slaves),
              static_cast<unsigned long long>(options.seed));
  Verdict verdict = course.run();
  verdict.coverage.add(rounds.hit());
  std::printf("%s%llu intervals, %llu frames, %llu requests, %llu rounds of faults, %llu faults hit\n",
              verdict.coverage.text().c_str(), static_cast<unsigned long long>(verdict.intervals),
              static_cast<unsigned long long>(course.line().counters().frames),
              static_cast<unsigned long long>(course.requests()),
              static_cast<unsigned long long>(rounds.rounds()),
              static_cast<unsigned long long>(verdict.coverage.hits()));
  if (verdict.violation) {
    std::printf("VIOLATED after interval %llu: %s: %s\n",
                static_cast<unsigned long long>(verdict.violation->interval),
                verdict.violation->invariant.c_str(), verdict.violation->what.c_str());
  }
  if (progress.grown()) std::printf("VIOLATED: the memory has grown\n");
  return verdict.violation || progress.grown() ? 1 : 0;
}
