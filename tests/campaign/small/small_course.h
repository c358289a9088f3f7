#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "course.h"
#include "tamper.h"

namespace cansyncd::campaign {

/// Told what happens, in words; empty: nobody wants to know.
using Tell = std::function<void(const std::string&)>;

/// What became of one schedule of a small course.
struct SmallVerdict {
  std::uint64_t digest = 0;  ///< of every telegram and edge of ours
  std::uint64_t intervals = 0;
  std::optional<Violation> violation;
  std::map<std::string, std::uint64_t> met;  ///< situations, and how often; each that the course knows
};

/// A course beside the great one of `Course`: a trap that needs a line, and a course of events, of its own. The
/// daemon's realtime loop plays on the simulated line in virtual time, as there.
struct SmallCourse {
  const char* name;  ///< as after `--course`
  std::span<const char* const> invariants;
  /// Plays the schedule of a seed. `tamper` breaks the product on purpose; null: it is as it is. Everything
  /// happens on the caller's thread.
  SmallVerdict (*play)(std::uint64_t seed, Tamper* tamper, const Tell& tell);
};

/// Another master comes and goes, and so does the bus.
extern const SmallCourse kOtherMasterCourse;
/// Drives are exchanged, replaced, twice on the bus, late.
extern const SmallCourse kWhichDriveCourse;

/// All of them.
std::span<const SmallCourse* const> small_courses() noexcept;

/// A product that is broken in one way on purpose, to show that an invariant of a small course can fail.
struct SmallMutant {
  const char* name;
  const SmallCourse* course;
  const char* caught_by;  ///< the invariant that must see it
  std::unique_ptr<Tamper> (*make)();
};

/// All of them; every invariant is named at least once.
std::span<const SmallMutant> small_mutants() noexcept;

}  // namespace cansyncd::campaign
