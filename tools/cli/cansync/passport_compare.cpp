#include "cli/cansync/passport_compare.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "profile/scaling.h"

namespace cansync::cli {
namespace {

std::set<std::uint16_t> numbers_of(const Passport& a, const Passport& b) {
  std::set<std::uint16_t> numbers;
  for (const PassportEntry& entry : a.entries) numbers.insert(entry.number);
  for (const PassportEntry& entry : b.entries) numbers.insert(entry.number);
  return numbers;
}

std::string named(const PassportEntry& entry) {
  return fmt::format("{} (parameter {})", entry.name, entry.number);
}

std::string shown(const PassportEntry* entry) {
  return entry == nullptr || !entry->raw ? "unknown" : entry->value;
}

/// Why the file's parameter must not be written; empty: it may.
std::string file_problem(const PassportEntry& entry, const profile::Parameter& parameter, bool same_profile) {
  if (entry.name != parameter.name || entry.format != parameter.format) {
    return fmt::format("{} is a {} in the file; the profile says: {}, {}", named(entry),
                       profile::name(entry.format), parameter.name, profile::name(parameter.format));
  }
  const std::int64_t number = profile::raw_number(parameter, *entry.raw);
  if (const std::string value = profile::scaled_text(parameter, number);
      same_profile && value != entry.value) {
    return fmt::format("{}: found value {} beside raw {}, which is {}; allowed: both the same", named(entry),
                       entry.value, *entry.raw, value);
  }
  const auto refused = profile::write_problem(parameter, *entry.raw);
  return refused ? refused->text : "";
}

PlanStep skipped(PlanStep step, std::string why) {
  step.why = std::move(why);
  return step;
}

}  // namespace

bool is_compared(const PassportEntry& entry) noexcept {
  return !entry.is_volatile && entry.identity != profile::Identity::unit;
}

std::vector<Difference> differences(const Passport& a, const Passport& b) {
  std::vector<Difference> found;
  for (const std::uint16_t number : numbers_of(a, b)) {
    const Difference pair{a.find(number), b.find(number)};
    if ((pair.a != nullptr && !is_compared(*pair.a)) || (pair.b != nullptr && !is_compared(*pair.b)))
      continue;
    const bool same = pair.a != nullptr && pair.b != nullptr && pair.a->raw == pair.b->raw &&
                      pair.a->format == pair.b->format;
    if (!same) found.push_back(pair);
  }
  return found;
}

std::vector<std::string> identity_problems(const Passport& file, const Passport& drive) {
  std::vector<std::string> problems;
  const auto compare = [&](std::string_view what, std::string_view of_file, std::string_view of_drive) {
    if (of_file != of_drive) {
      problems.push_back(fmt::format("{}: {} in the file, {} here", what, of_file, of_drive));
    }
  };
  compare("bus", file.bus, drive.bus);
  compare("slave", std::to_string(file.slave), std::to_string(drive.slave));
  compare("profile", file.profile, drive.profile);
  for (const std::uint16_t number : numbers_of(file, drive)) {
    const PassportEntry* of_file = file.find(number);
    const PassportEntry* of_drive = drive.find(number);
    const auto is_type = [](const PassportEntry* entry) {
      return entry != nullptr && entry->identity == profile::Identity::type;
    };
    if (!is_type(of_file) && !is_type(of_drive)) continue;
    compare(named(of_file != nullptr ? *of_file : *of_drive), shown(of_file), shown(of_drive));
  }
  return problems;
}

std::size_t RestorePlan::count(PlanStep::Action action) const noexcept {
  return static_cast<std::size_t>(
      std::count_if(steps.begin(), steps.end(), [&](const PlanStep& step) { return step.action == action; }));
}

RestorePlan plan_restore(const Passport& file, const Passport& drive, const profile::Profile& profile) {
  RestorePlan plan;
  std::set<std::uint16_t> numbers;
  for (const PassportEntry& entry : file.entries) numbers.insert(entry.number);
  for (const profile::Parameter& parameter : profile.parameters) numbers.insert(parameter.number);
  for (const std::uint16_t number : numbers) {
    PlanStep step;
    step.parameter = profile.find(number);
    step.file = file.find(number);
    step.drive = drive.find(number);
    const bool settable = step.parameter != nullptr && !step.parameter->is_volatile &&
                          step.parameter->access == profile::Access::read_write;
    if (step.file == nullptr) {
      if (settable) plan.steps.push_back(skipped(step, "not in the file"));
      continue;
    }
    if (step.file->identity != profile::Identity::none) continue;
    if (step.parameter == nullptr) {
      plan.steps.push_back(skipped(step, "not in the profile"));
    } else if (step.file->is_volatile || step.parameter->is_volatile) {
      plan.steps.push_back(skipped(step, "volatile"));
    } else if (!settable) {
      plan.steps.push_back(skipped(step, "read-only"));
    } else if (!step.file->raw) {
      plan.steps.push_back(skipped(step, "without a value in the file: it could not be read then"));
    } else {
      std::string problem = file_problem(*step.file, *step.parameter, file.profile_hash == profile.hash);
      if (problem.empty() && (step.drive == nullptr || !step.drive->raw)) {
        problem = named(*step.file) + " could not be read from the drive";
      }
      if (!problem.empty()) {
        plan.problems.push_back(std::move(problem));
        continue;
      }
      step.action = step.drive->raw == step.file->raw ? PlanStep::Action::right : PlanStep::Action::write;
      plan.steps.push_back(std::move(step));
    }
  }
  return plan;
}

}  // namespace cansync::cli
