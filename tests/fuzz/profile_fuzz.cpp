// Drive profiles (lib/profile/reader.h): what is taken keeps the promises of lib/profile/profile.h.
#include <cmath>
#include <set>

#include "bounded.h"
#include "bytes.h"
#include "profile/reader.h"
#include "profile/scaling.h"
#include "require.h"

namespace {

using fuzz::require;

void check(const profile::Parameter& parameter) {
  require(profile::is_name(parameter.name), "a parameter has a name");
  require(parameter.number <= 4095, "its number fits a telegram");
  require(parameter.minimum <= parameter.maximum, "its limits leave a value");
  const std::int64_t bits = parameter.format == profile::Format::word ? 16 : 32;
  const std::int64_t least = parameter.is_signed ? -(std::int64_t{1} << (bits - 1)) : 0;
  const std::int64_t most = (std::int64_t{1} << (parameter.is_signed ? bits - 1 : bits)) - 1;
  require(parameter.minimum >= least && parameter.maximum <= most, "its limits fit its format");
  require(std::isfinite(parameter.factor) && parameter.factor != 0.0, "its factor can be divided by");
  require(std::isfinite(parameter.offset), "its offset can be added");
  require(parameter.unit.size() <= 16 && parameter.text.size() <= 200, "its texts are short");
  require(parameter.group.empty() || profile::is_name(parameter.group), "its group has a name");
  for (const std::int64_t raw : {parameter.minimum, parameter.maximum})
    require(!profile::scaled_text(parameter, raw).empty(), "its limits can be shown");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const profile::Reading reading = fuzz::bounded(
      size, fuzz::kOfTextInPart, [&] { return profile::parse(fuzz::text_of(data, size), "fuzz.toml"); });
  require(reading.profile || !reading.problems.empty(), "a profile, or what is wrong with it");
  for (const config::Problem& problem : reading.problems) require(!problem.text.empty(), "a problem is told");
  require(reading.problems.empty() == config::problems_text(reading.problems).empty(), "problems are told");
  if (!reading.profile) return 0;
  require(profile::is_name(reading.profile->name), "a profile has a name");
  std::set<std::string> names;
  int before = -1;
  for (const profile::Parameter& parameter : reading.profile->parameters) {
    check(parameter);
    require(parameter.number > before, "numbers rise");
    require(names.insert(parameter.name).second, "every name is there once");
    require(reading.profile->find(std::string_view(parameter.name)) == &parameter, "it is found by its name");
    before = parameter.number;
  }
  return 0;
}
