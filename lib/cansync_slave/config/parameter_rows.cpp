#include "cansync_slave/config/parameter_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>

#include "config/fields.h"

namespace cansync_slave {
namespace {

using namespace config::rows;
using config::Value;

using Draft = ParameterSections;
using ParameterRow = config::Row<Draft>;
using Access = cansync::ParameterDefinition::Access;

constexpr std::int64_t kLeast = std::numeric_limits<std::int32_t>::min();
constexpr std::int64_t kMost = std::numeric_limits<std::uint32_t>::max();

constexpr auto kFormats = std::to_array<Word<bool>>({{"word", false}, {"doubleword", true}});
constexpr auto kAccesses = std::to_array<Word<Access>>({{"read_write", Access::read_write},
                                                        {"read_only", Access::read_only},
                                                        {"not_available", Access::not_available}});

constexpr auto kParameterRows = std::to_array<ParameterRow>({
    {label("parameter.number", cansync::ParameterNumber::max, "Number of the parameter."),
     [](Draft& d, const Value&) { (void)d.current(); }},
    field(
        [](auto& d) -> auto& { return d.current().value; },
        whole_number("parameter.value", kLeast, kMost, "",
                     "Raw value at the start; below 0 the parameter is signed.")),
    chosen<kFormats>(
        [](auto& d) -> auto& { return d.current().doubleword; }, word("parameter.format", "16 or 32 bits.")),
    {whole_number("parameter.minimum", "(none)", kLeast, kMost, "",
                  "Smallest raw value that the master may write; below 0 the parameter is signed."),
     [](Draft& d, const Value& v) { d.current().minimum = whole<std::int64_t>(v); }},
    {whole_number("parameter.maximum", "(none)", kLeast, kMost, "",
                  "Greatest raw value that the master may write."),
     [](Draft& d, const Value& v) { d.current().maximum = whole<std::int64_t>(v); }},
    chosen<kAccesses>(
        [](auto& d) -> auto& { return d.current().access; },
        word("parameter.access",
             "What the master may do; not_available: every access is answered with 0xFFFA.")),
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

}  // namespace

std::span<const config::Row<ParameterSections>> parameter_rows() {
  return kParameterRows;
}

std::vector<cansync::ParameterDefinition> parameter_definitions(const ParameterSections& sections,
                                                                const ParameterProblem& problem) {
  std::vector<cansync::ParameterDefinition> definitions;
  for (const auto& [number, one] : sections.parameters) {
    const bool is_signed = one.value < 0 || one.minimum.value_or(0) < 0 || one.maximum.value_or(0) < 0;
    const FormatRange whole = range_of(one.doubleword, is_signed);
    FormatRange limits{one.minimum.value_or(whole.least), one.maximum.value_or(whole.most)};
    if (!inside(number, "minimum", limits.least, whole, problem) ||
        !inside(number, "maximum", limits.most, {limits.least, whole.most}, problem) ||
        !inside(number, "value", one.value, limits, problem))
      continue;
    cansync::ParameterDefinition definition;
    definition.number = static_cast<std::uint16_t>(number);
    definition.doubleword = one.doubleword;
    definition.access = one.access;
    definition.initial = static_cast<std::uint32_t>(one.value);
    definition.minimum = limits.least;
    definition.maximum = limits.most;
    definition.limited = one.minimum || one.maximum;
    definition.without_application = static_cast<cansync::ParameterError>(one.error_without_application);
    definitions.push_back(definition);
  }
  return definitions;
}

}  // namespace cansync_slave
