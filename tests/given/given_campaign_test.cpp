// Rows and happenings by chance, two or three at once: the eight rules hold, and afterwards it can be given again.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <iterator>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "../campaign/dice.h"
#include "given_cells.h"
#include "rows.h"

namespace given {
namespace {

using cansyncd::campaign::Dice;
using std::chrono::milliseconds;

/// Every reaction has come, and everything that is periodic has been seen.
constexpr milliseconds kSettles{30};
constexpr milliseconds kSpan{100};
constexpr milliseconds kComesBack{1500};
/// Longer than the monitoring time of the jobs, those before it included.
constexpr milliseconds kAllAnswered{2500};

const Cell& cell(std::string_view row, std::string_view column) {
  return *std::find_if(std::begin(kCells), std::end(kCells),
                       [&](const Cell& one) { return one.row == row && one.column == column; });
}
/// The part of a cell between its ", then "; empty when it has no more.
std::string_view step(std::string_view text, unsigned number) {
  constexpr std::string_view kThen = ", then ";
  for (; number > 0; --number) {
    const auto end = text.find(kThen);
    if (end == std::string_view::npos) return {};
    text.remove_prefix(end + kThen.size());
  }
  return text.substr(0, text.find(kThen));
}
bool has(std::string_view text, std::string_view word) {
  return text.find(word) != std::string_view::npos;
}
/// How often a word is in what `counted_words` made.
unsigned count_of(const std::string& text, const std::string& word) {
  const auto at = text.find(word);
  if (at == std::string::npos) return 0;
  const auto begin = text.rfind(", ", at) == std::string::npos ? 0 : text.rfind(", ", at) + 2;
  return begin == at ? 1 : static_cast<unsigned>(std::strtoul(text.c_str() + begin, nullptr, 10));
}

/// What the table says of a row, as rules.
struct Rules {
  explicit Rules(std::string_view row) {
    const auto bus = [&](std::string_view column) { return cell(row, column).bus; };
    ends_with_giver = bus("dies") == "nothing";
    read_only_refuses = step(bus("read_only"), 1) == "nothing";
    read_only_ends = step(bus("read_only"), 0) == "nothing";
    const std::string_view first = step(cell(row, "stronger").giver, 0);
    stronger_silences =
        step(bus("stronger"), 0) == "second" && (first == "waits" || first == "another has it");
    // The controller of the tests takes reference values whatever else it keeps.
    controller_keeps = row.find("references") == row.npos && row.find("lead_axis") == row.npos;
    for (const Cell& one : kCells) {
      if (one.row == row && !one.bus.empty()) possible.insert(one.column);
    }
  }
  bool ends_with_giver;
  bool read_only_refuses;  ///< what is given meanwhile
  bool read_only_ends;     ///< what was given before
  bool stronger_silences;
  bool controller_keeps;
  std::set<std::string_view> possible;
};

/// What can go on while other things happen.
constexpr std::string_view kHappenings[] = {"ended",   "dies",    "stronger",      "read_only", "reload",
                                            "restart", "bus_off", "in_controller", "full",      "stop_run"};

class Course {
 public:
  Course(std::uint64_t seed, const Rows& rows) : dice_(seed) {
    const auto& all = rows.all();
    do {
      name_ = std::next(all.begin(), static_cast<std::ptrdiff_t>(dice_.below(all.size())))->first;
      rules_ = std::make_unique<Rules>(name_);
    } while (rules_->possible.count("dies") == 0);
    row_ = rows.make(name_);
  }

  void run() {
    SCOPED_TRACE(name_);
    const std::string given = given_now();
    ASSERT_NE(given, "nothing");
    const auto count = 2 + dice_.below(2);
    for (std::uint64_t i = 0; i < count; ++i) begin(dice_.one_of(kHappenings));
    row_->run(kSettles);
    (void)seen();
    row_->run(kSpan);
    holds(seen());
    while (!under_way_.empty()) {
      const auto one =
          std::next(under_way_.begin(), static_cast<std::ptrdiff_t>(dice_.below(under_way_.size())));
      const std::string_view column = *one;
      under_way_.erase(one);
      end(column);
      row_->run(milliseconds(10 * dice_.below(4)));
    }
    row_->run(kComesBack);
    (void)seen();
    row_->run(kSpan);
    holds(seen());
    if (row_->is_job()) row_->run(kAllAnswered);
    (void)seen();
    const std::string again = given_now();
    // Reference and actual values keep what another one gave beside them.
    const bool beside = again == "both" && has(said_, "stronger");
    EXPECT_TRUE(again == given || beside)
        << again << ", not " << given << ": it cannot be given again" << said_ << "; told " << row_->told()
        << "; events " << row_->events();
    if (!row_->is_job()) return;
    row_->run(kAllAnswered);
    (void)seen();
    EXPECT_LE(sent_, asked_) << "more than was asked for" << said_;
    EXPECT_LE(requests_, asked_ + asked_by_second_) << "more than was asked for" << said_;
    EXPECT_EQ(row_->unanswered(), 0u) << "so many requests have no answer" << said_;
  }

 private:
  milliseconds span() const { return row_->is_job() ? milliseconds(500) : kSpan; }

  void give() {
    row_->give(Giver::first);
    gone_ = dead_ = false;
    ++asked_;
  }
  /// What is seen of it when nothing else happens.
  std::string given_now() {
    give();
    row_->run(span());
    if (!row_->is_job()) {
      // What stood there before, or is seen once, does not count.
      (void)seen();
      row_->run(kSpan);
    }
    return seen();
  }
  std::string seen() {
    std::string now = row_->on_bus();
    // The questions of a read come again, and do not count.
    sent_ += count_of(now, "first");
    requests_ += count_of(now, "request");
    return now;
  }
  bool is_under_way(std::string_view column) const { return under_way_.count(column) != 0; }

  void begin(std::string_view column) {
    if (rules_->possible.count(column) == 0 || is_under_way(column)) return;
    // While the daemon is read-only nobody stops the line.
    if (column == "stop_run" && is_under_way("read_only")) return;
    // A program that has begun anew ends nothing that it has not given.
    if (column == "ended" && dead_) return;
    said_ += " / " + std::string(column);
    row_->run(milliseconds(10 * dice_.below(4)));
    if (column == "ended") {
      row_->end(Giver::first);
      gone_ = true;
    } else if (column == "dies") {
      row_->kill(Giver::first);
      gone_ = dead_ = true;
    } else if (column == "reload") {
      if (is_under_way("read_only")) end("read_only");  // which no file of the tests says
      row_->reload();
    } else if (column == "restart") {
      restart();
    } else {
      under_way_.insert(column);
      if (column == "stronger") {
        row_->give(Giver::second);
        ++asked_by_second_;
      }
      if (column == "read_only") row_->set_read_only(true);
      if (column == "bus_off") row_->take_bus_off();
      if (column == "in_controller") row_->keep_in_controller(true);
      if (column == "full") row_->set_full(true);
      if (column == "stop_run") row_->set_running(false);
    }
    if (dice_.chance(300)) {
      said_ += " / given";
      row_->run(milliseconds(10));
      give();
    }
  }
  /// Of the daemon that runs then nothing is known but its file.
  void restart() {
    for (const std::string_view column : std::set<std::string_view>(under_way_)) end(column);
    row_->restart();
    gone_ = true;
  }
  void end(std::string_view column) {
    // Nobody starts the line while the daemon is read-only, nor on a bus that does not carry it.
    for (const std::string_view first : {"read_only", "bus_off", "in_controller", "full"}) {
      if (column == "stop_run" && is_under_way(first)) end(first);
    }
    under_way_.erase(column);
    if (column == "stronger") row_->leave(Giver::second);
    if (column == "read_only") row_->set_read_only(false);
    if (column == "bus_off") row_->bring_bus_back();
    if (column == "in_controller") row_->keep_in_controller(false);
    if (column == "full") row_->set_full(false);
    if (column == "stop_run") row_->set_running(true);
    said_ += " / no " + std::string(column);
  }

  /// `seen`: what stands on the bus now.
  void holds(const std::string& seen) {
    for (const std::string_view column : {"bus_off", "stop_run", "in_controller"}) {
      // Who leads says run again; a timer that is started in stop runs.
      const bool goes_on = column == "stop_run" && (name_ == "layer2.run_lead" || name_ == "layer2.timer");
      if (is_under_way(column) && !goes_on && (column != "in_controller" || rules_->controller_keeps)) {
        EXPECT_EQ(seen, "nothing") << "sent in spite of " << column << said_;
      }
    }
    if (row_->is_job()) return;
    if (gone_ && rules_->ends_with_giver) {
      EXPECT_FALSE(has(seen, "first")) << "its giver is gone" << said_;
    }
    if (is_under_way("read_only") && rules_->read_only_ends) {
      EXPECT_EQ(seen, "nothing") << "read-only" << said_;
    }
    if (is_under_way("stronger") && rules_->stronger_silences && !is_under_way("read_only")) {
      EXPECT_FALSE(has(seen, "first")) << "a stronger one gives" << said_;
    }
  }

  Dice dice_;
  std::string name_;
  std::unique_ptr<Rules> rules_;
  std::unique_ptr<Row> row_;
  std::set<std::string_view> under_way_;
  bool gone_ = false;  ///< the first gives no more
  bool dead_ = false;  ///< its program has died
  unsigned asked_ = 0;
  unsigned asked_by_second_ = 0;
  unsigned sent_ = 0;      ///< frames of the first
  unsigned requests_ = 0;  ///< of both
  std::string said_;
};

std::uint64_t number_of(const char* variable, std::uint64_t otherwise) {
  const char* given = std::getenv(variable);  // NOLINT(concurrency-mt-unsafe): one thread
  return given == nullptr ? otherwise : std::strtoull(given, nullptr, 10);
}

/// CANSYNC_GIVEN_SEEDS: so many; CANSYNC_GIVEN_SEED: from this one on.
TEST(GivenCampaign, TheRulesHoldWhateverHappensAtOnce) {
  const Rows rows = all_rows();
  const std::uint64_t first = number_of("CANSYNC_GIVEN_SEED", 1);
  const std::uint64_t last = first + number_of("CANSYNC_GIVEN_SEEDS", 30);
  for (std::uint64_t seed = first; seed < last; ++seed) {
    SCOPED_TRACE("CANSYNC_GIVEN_SEED=" + std::to_string(seed) + " CANSYNC_GIVEN_SEEDS=1");
    Course(seed, rows).run();
  }
}

}  // namespace
}  // namespace given
