#include "columns.h"

#include <chrono>
#include <functional>
#include <map>
#include <regex>
#include <utility>

namespace given {
namespace {

using std::chrono::milliseconds;

/// Long enough for every reaction, and for some periods of everything that is periodic; and for every job.
constexpr milliseconds kSpan{100};
constexpr milliseconds kJobSpan{500};
/// A frame stays in the controller so long, twice; no node is missed meanwhile.
constexpr milliseconds kInController{5};
/// Longer than the monitoring time of the jobs.
constexpr milliseconds kTooLong{2500};
/// In which a node has its address again, and a line is in run.
constexpr milliseconds kComesBack{1500};

/// Keeps what is seen at each look.
class Course {
 public:
  explicit Course(Row& row) : row_(row) {}

  /// From now on it counts what is seen.
  void begin() {
    row_.run(kSpan);
    forget();
    (void)row_.events();
  }
  /// The reaction is over: what stays is what counts, but of a job everything.
  void look() {
    row_.run(milliseconds(5));
    if (!row_.is_job()) (void)row_.on_bus();
    row_.run(row_.is_job() ? kJobSpan : kSpan);
    add(seen_.bus, row_.on_bus());
    add(seen_.giver, row_.told());
  }
  Seen end() {
    seen_.others = row_.events();
    return std::move(seen_);
  }

 private:
  void forget() {
    (void)row_.on_bus();
    (void)row_.told();
  }
  static void add(std::string& course, const std::string& now) {
    if (!course.empty()) course += ", then ";
    course += now;
  }
  Row& row_;
  Seen seen_;
};

/// Gives, and lets a job wait: whatever happens to it happens before it was sent.
void give_and_wait(Row& row, Course& course) {
  if (row.is_job()) row.set_full(true);
  row.give(Giver::first);
  course.begin();
}
void wait_no_more(Row& row) {
  if (row.is_job()) row.set_full(false);
}

Seen once(Row& row, const std::function<void()>& what) {
  Course course(row);
  give_and_wait(row, course);
  what();
  row.run(milliseconds(5));
  wait_no_more(row);
  course.look();
  return course.end();
}

Seen ended(Row& row) {
  return once(row, [&] { row.end(Giver::first); });
}
Seen dies(Row& row) {
  return once(row, [&] { row.kill(Giver::first); });
}
Seen reloaded(Row& row) {
  return once(row, [&] { row.reload(); });
}

/// A stronger one comes; once it has ended what it gives, the first gives on.
Seen stronger(Row& row) {
  Course course(row);
  give_and_wait(row, course);
  row.give(Giver::second);
  row.run(milliseconds(5));
  wait_no_more(row);
  course.look();
  if (row.is_job()) return course.end();
  row.leave(Giver::second);
  course.look();
  row.give(Giver::first);
  course.look();
  return course.end();
}

Seen read_only(Row& row) {
  Course course(row);
  give_and_wait(row, course);
  row.set_read_only(true);
  row.run(milliseconds(5));
  wait_no_more(row);
  course.look();
  row.give(Giver::first);
  course.look();
  row.set_read_only(false);
  course.look();
  row.give(Giver::first);
  course.look();
  return course.end();
}

Seen restarted(Row& row) {
  Course course(row);
  give_and_wait(row, course);
  row.restart();
  course.look();
  row.give(Giver::first);
  course.look();
  return course.end();
}

Seen stopped(Row& row) {
  Course course(row);
  give_and_wait(row, course);
  row.set_running(false);
  row.run(milliseconds(5));
  wait_no_more(row);
  course.look();
  row.set_running(true);
  row.run(kComesBack);
  course.look();
  return course.end();
}

Seen bus_off(Row& row) {
  Course course(row);
  give_and_wait(row, course);
  row.take_bus_off();
  row.run(milliseconds(5));
  wait_no_more(row);
  course.look();
  row.bring_bus_back();
  row.run(kComesBack);
  course.look();
  return course.end();
}

Seen listens_only(Row& row) {
  Course course(row);
  course.begin();
  row.set_listens_only();
  row.run(kSpan);
  row.give(Giver::first);
  if (row.is_job()) row.run(kTooLong);
  course.look();
  return course.end();
}

Seen in_controller(Row& row) {
  Course course(row);
  course.begin();
  row.keep_in_controller(true);
  row.give(Giver::first);
  row.run(kInController);
  row.end(Giver::first);
  row.run(kInController);
  row.keep_in_controller(false);
  course.look();
  return course.end();
}

Seen full(Row& row) {
  Course course(row);
  row.set_full(true);
  course.begin();
  constexpr int kOneTooMany = 65;
  for (int i = 0; i < kOneTooMany; ++i) {
    row.give(Giver::first);
    row.let_it_be_seen();
  }
  row.run(milliseconds(5));
  row.set_full(false);
  course.look();
  return course.end();
}

Seen burst(Row& row) {
  Course course(row);
  course.begin();
  for (unsigned i = 0; i < row.burst(); ++i) {
    row.give(Giver::first);
    if (row.is_job()) row.let_it_be_seen();
  }
  course.look();
  Seen seen = course.end();
  if (row.is_job()) return seen;
  // How many of the samples are taken is a matter of the computer.
  const std::regex number("[0-9]+ times ");
  seen.bus = std::regex_replace(seen.bus, number, "");
  seen.giver = std::regex_replace(seen.giver, number, "");
  return seen;
}

}  // namespace

Seen let_happen(std::string_view column, Row& row) {
  static const std::map<std::string_view, Seen (*)(Row&)> columns = {
      {"ended", ended},
      {"dies", dies},
      {"stronger", stronger},
      {"read_only", read_only},
      {"reload", reloaded},
      {"restart", restarted},
      {"stop_run", stopped},
      {"bus_off", bus_off},
      {"listens_only", listens_only},
      {"in_controller", in_controller},
      {"full", full},
      {"burst", burst},
  };
  return columns.at(column)(row);
}

}  // namespace given
