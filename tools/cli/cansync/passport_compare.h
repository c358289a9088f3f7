#pragma once

#include <string>
#include <vector>

#include "profile/passport.h"

/// What two passports have different, and what a restore would write. Pure functions.
namespace cansync::cli {

using profile::Passport;
using profile::PassportEntry;

/// A parameter that two passports do not have alike. The entries belong to the passports.
struct Difference {
  const PassportEntry* a = nullptr;  ///< null: the first one does not have it
  const PassportEntry* b = nullptr;  ///< null: the second one does not have it
  const PassportEntry& any() const noexcept { return a != nullptr ? *a : *b; }
};

/// Is this entry compared? Not so: volatile ones, and what tells one drive from another.
bool is_compared(const PassportEntry& entry) noexcept;

/// The parameters whose raw value or format differ, or that only one has; by rising number.
std::vector<Difference> differences(const Passport& a, const Passport& b);

/// Why `file` is of another drive than `drive`, one sentence each: bus, slave number, profile, and the
/// parameters with identity "type". Empty: the same.
std::vector<std::string> identity_problems(const Passport& file, const Passport& drive);

/// What a restore does with one parameter.
struct PlanStep {
  enum class Action : unsigned char {
    write,  ///< the drive holds something else
    right,  ///< the drive holds the value
    skip,   ///< `why` says why it is not restored
  };
  Action action = Action::skip;
  const profile::Parameter* parameter = nullptr;  ///< null: the profile does not have it
  const PassportEntry* file = nullptr;            ///< null: the file does not have it
  const PassportEntry* drive = nullptr;           ///< null: not read
  std::string why;                                ///< of a skip
};

/// The write plan of a restore, by rising number.
struct RestorePlan {
  std::vector<PlanStep> steps;
  std::vector<std::string> problems;  ///< with one of them nothing may be written
  std::size_t count(PlanStep::Action action) const noexcept;
};

/// Plans to give a drive the values of `file`. `drive`: what it holds now. Problems: values outside the
/// profile's limits, parameters that have another name or format in the profile, values in engineering units
/// that do not belong to their raw value, and parameters that could not be read from the drive.
RestorePlan plan_restore(const Passport& file, const Passport& drive, const profile::Profile& profile);

}  // namespace cansync::cli
