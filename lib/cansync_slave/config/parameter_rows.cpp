#include "cansync_slave/config/parameter_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "config/fields.h"
#include "profile/reader.h"
#include "profile/scaling.h"

namespace cansync_slave {
namespace {

using namespace config::rows;
using config::Value;

using Draft = ParameterSections;
using ParameterRow = config::Row<Draft>;
using Access = cansync::ParameterDefinition::Access;

constexpr std::int64_t kLongestName = 64;
constexpr std::int64_t kLeast = std::numeric_limits<std::int32_t>::min();
constexpr std::int64_t kMost = std::numeric_limits<std::uint32_t>::max();

constexpr auto kAccesses = std::to_array<Word<Access>>({{"read_write", Access::read_write},
                                                        {"read_only", Access::read_only},
                                                        {"not_available", Access::not_available}});

constexpr auto kParameterRows = std::to_array<ParameterRow>({
    {label("parameter.number", cansync::ParameterNumber::max, "Number of the parameter."),
     [](Draft& d, const Value&) { (void)d.current(); }},
    {string("parameter.name", config::OptionType::text, "(of the profile, or none)", 0, kLongestName,
            "What it is called: lower-case letters, digits and '-', beginning with a letter. One that the "
            "profile has keeps its name."),
     [](Draft& d, const Value& v) { d.current().name = words(v); }},
    {whole_number("parameter.value", "(0, or the nearest limit)", kLeast, kMost, "",
                  "Raw value at the start; below 0 the parameter is signed."),
     [](Draft& d, const Value& v) { d.current().value = whole<std::int64_t>(v); }},
    {choice("parameter.format", "(of the profile, or word)", "word|doubleword",
            "16 or 32 bits; that of the profile where it has the number."),
     [](Draft& d, const Value& v) { d.current().doubleword = words(v) == "doubleword"; }},
    {whole_number("parameter.minimum", "(of the profile, or none)", kLeast, kMost, "",
                  "Smallest raw value that the master may write, within the profile's limits; below 0 the "
                  "parameter is signed."),
     [](Draft& d, const Value& v) { d.current().minimum = whole<std::int64_t>(v); }},
    {whole_number("parameter.maximum", "(of the profile, or none)", kLeast, kMost, "",
                  "Greatest raw value that the master may write, within the profile's limits."),
     [](Draft& d, const Value& v) { d.current().maximum = whole<std::int64_t>(v); }},
    {choice("parameter.access", "(of the profile, or read_write)", "read_write|read_only|not_available",
            "What the master may do; not_available: every access is answered with 0xFFFA."),
     [](Draft& d, const Value& v) {
       for (const auto& word : kAccesses) {
         if (word.text == words(v)) d.current().access = word.value;
       }
     }},
    field(
        [](auto& d) -> auto& { return d.current().error_without_application; },
        whole_number("parameter.error_without_application", 0, 0xFFFF, "",
                     "Error number that every access is answered with while no application has taken the "
                     "parameter over; 0: the table answers.")),
});

/// The numbers that a format holds.
struct FormatRange {
  std::int64_t least;
  std::int64_t most;
};

FormatRange range_of(bool doubleword, bool is_signed) noexcept {
  const std::int64_t span = doubleword ? std::int64_t{1} << 32 : std::int64_t{1} << 16;
  return is_signed ? FormatRange{-span / 2, span / 2 - 1} : FormatRange{0, span - 1};
}

/// Looks at one value; false: it is outside.
bool inside(unsigned number, const char* name, std::int64_t value, const FormatRange& range,
            const ParameterProblem& problem) {
  if (value >= range.least && value <= range.most) return true;
  problem(fmt::format("parameter.{}.{}", number, name),
          fmt::format("found {}; allowed: {}..{}", value, range.least, range.most));
  return false;
}

Access access_of(profile::Access access) noexcept {
  switch (access) {
    case profile::Access::read_write:
      return Access::read_write;
    case profile::Access::read_only:
      return Access::read_only;
    case profile::Access::none:
      break;
  }
  return Access::not_available;
}

/// As the profile has it.
NamedParameter of_profile(const profile::Parameter& known) {
  cansync::ParameterDefinition definition;
  definition.number = known.number;
  definition.doubleword = known.format == profile::Format::doubleword;
  definition.access = access_of(known.access);
  const FormatRange whole = range_of(definition.doubleword, known.is_signed);
  definition.minimum = known.limited ? known.minimum : whole.least;
  definition.maximum = known.limited ? known.maximum : whole.most;
  definition.limited = known.limited;
  definition.initial =
      static_cast<std::uint32_t>(std::clamp<std::int64_t>(0, definition.minimum, definition.maximum));
  return {definition, known};
}

/// One that no profile has.
NamedParameter of_section(unsigned number, const ParameterSections::One& one) {
  NamedParameter made;
  made.definition.number = static_cast<std::uint16_t>(number);
  made.definition.doubleword = one.doubleword.value_or(false);
  made.description.is_signed =
      one.value.value_or(0) < 0 || one.minimum.value_or(0) < 0 || one.maximum.value_or(0) < 0;
  const FormatRange whole = range_of(made.definition.doubleword, made.description.is_signed);
  made.definition.minimum = whole.least;
  made.definition.maximum = whole.most;
  made.description.number = made.definition.number;
  made.description.name = one.name;
  made.description.format = made.definition.doubleword ? profile::Format::doubleword : profile::Format::word;
  return made;
}

/// What the section says against the profile; true: nothing.
bool agrees(unsigned number, const ParameterSections::One& one, const NamedParameter& known,
            const ParameterProblem& problem) {
  const std::string& name = known.description.name;
  if (!one.name.empty() && one.name != name) {
    problem(fmt::format("parameter.{}.name", number),
            fmt::format("found \"{}\"; allowed: \"{}\", as the profile calls it, or none", one.name, name));
    return false;
  }
  if (one.doubleword && *one.doubleword != known.definition.doubleword) {
    problem(fmt::format("parameter.{}.format", number),
            fmt::format("found another format than that of {} in the profile; allowed: \"{}\"", name,
                        profile::name(known.description.format)));
    return false;
  }
  return true;
}

/// Puts values, limits and access of the section into the definition; false: they do not fit.
bool narrow(const ParameterSections::One& one, NamedParameter& to, const ParameterProblem& problem) {
  cansync::ParameterDefinition& definition = to.definition;
  const unsigned number = definition.number;
  const FormatRange before{definition.minimum, definition.maximum};
  const FormatRange limits{one.minimum.value_or(before.least), one.maximum.value_or(before.most)};
  if (!inside(number, "minimum", limits.least, before, problem) ||
      !inside(number, "maximum", limits.most, {limits.least, before.most}, problem))
    return false;
  const std::int64_t value = one.value.value_or(std::clamp<std::int64_t>(0, limits.least, limits.most));
  if (!inside(number, "value", value, limits, problem)) return false;
  definition.initial = static_cast<std::uint32_t>(value);
  definition.minimum = limits.least;
  definition.maximum = limits.most;
  definition.limited = definition.limited || one.minimum || one.maximum;
  definition.access = one.access.value_or(definition.access);
  definition.without_application = static_cast<cansync::ParameterError>(one.error_without_application);
  return true;
}

/// Names are names, and each stands once.
void check_names(const std::map<unsigned, NamedParameter>& parameters, const ParameterProblem& problem) {
  std::map<std::string, unsigned> numbers;
  for (const auto& [number, one] : parameters) {
    const std::string& name = one.description.name;
    if (name.empty()) continue;
    const std::string key = fmt::format("parameter.{}.name", number);
    if (!profile::is_name(name))
      problem(key, fmt::format("found \"{}\"; allowed: 1..64 lower-case letters, digits and '-', beginning "
                               "with a letter",
                               name));
    const auto [place, fresh] = numbers.emplace(name, number);
    if (!fresh)
      problem(key, fmt::format("found \"{}\", which is parameter {}; allowed: a name of its own", name,
                               place->second));
  }
}

}  // namespace

std::span<const config::Row<ParameterSections>> parameter_rows() {
  return kParameterRows;
}

std::vector<NamedParameter> named_parameters(const ParameterSections& sections,
                                             const profile::Profile* profile,
                                             const ParameterProblem& problem) {
  std::map<unsigned, NamedParameter> made;
  if (profile != nullptr) {
    for (const profile::Parameter& known : profile->parameters) made.emplace(known.number, of_profile(known));
  }
  for (const auto& [number, one] : sections.parameters) {
    const auto [place, fresh] = made.try_emplace(number);
    if (fresh) place->second = of_section(number, one);
    if (!fresh && !agrees(number, one, place->second, problem)) continue;
    (void)narrow(one, place->second, problem);
  }
  check_names(made, problem);
  std::vector<NamedParameter> parameters;
  parameters.reserve(made.size());
  for (auto& [number, one] : made) parameters.push_back(std::move(one));
  return parameters;
}

std::vector<cansync::ParameterDefinition> definitions_of(const std::vector<NamedParameter>& parameters) {
  std::vector<cansync::ParameterDefinition> definitions;
  definitions.reserve(parameters.size());
  for (const NamedParameter& one : parameters) definitions.push_back(one.definition);
  return definitions;
}

}  // namespace cansync_slave
