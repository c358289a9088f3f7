#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "cansync/slave/parameter_table.h"
#include "config/option.h"
#include "config/rows.h"
#include "profile/profile.h"

/// The parameter table of a slave as a file says it: one [[parameter]] for each number. The daemon's
/// configuration and the file of an application have the same rows. Main thread.
namespace cansync_slave {

/// The sections while a file is read.
struct ParameterSections {
  /// One [[parameter]]; what is not there is that of the profile, and without one the row's default.
  struct One {
    std::string name;  ///< empty: none
    std::optional<std::int64_t> value;
    std::optional<bool> doubleword;
    std::optional<std::int64_t> minimum;
    std::optional<std::int64_t> maximum;
    std::optional<cansync::ParameterDefinition::Access> access;
    std::uint16_t error_without_application = 0;
  };

  std::map<unsigned, One> parameters;
  unsigned number = 0;  ///< of the section that the next option belongs to

  One& current() { return parameters[number]; }
};

/// The section, and its rows.
inline constexpr config::Section kParameterSection = {
    "parameter", "parameter numbers", "Once for each parameter of the slave that the master may ask for."};
std::span<const config::Row<ParameterSections>> parameter_rows();

/// Is told of each value that does not fit the others: the option's key with its number, and what was found
/// and is allowed.
using ParameterProblem = std::function<void(const std::string& key, const std::string& text)>;

/// A parameter as a slave has it: what the table needs, and what it is called.
struct NamedParameter {
  cansync::ParameterDefinition definition;
  /// Name, sign, unit and scaling; without a name it has none.
  profile::Parameter description;
};

/// The parameters of a profile (null: none) with what the sections say: they say other values at the start,
/// narrower limits and less access than the profile, and add parameters of their own. By rising number.
std::vector<NamedParameter> named_parameters(const ParameterSections& sections,
                                             const profile::Profile* profile,
                                             const ParameterProblem& problem);

/// The definitions alone.
std::vector<cansync::ParameterDefinition> definitions_of(const std::vector<NamedParameter>& parameters);

}  // namespace cansync_slave
