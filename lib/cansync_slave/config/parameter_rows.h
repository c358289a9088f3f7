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

/// The parameter table of a slave as a file says it: one [[parameter]] for each number. The daemon's
/// configuration and the file of an application have the same rows. Main thread.
namespace cansync_slave {

/// The sections while a file is read.
struct ParameterSections {
  /// One [[parameter]].
  struct One {
    std::int64_t value = 0;
    bool doubleword = false;
    std::optional<std::int64_t> minimum;
    std::optional<std::int64_t> maximum;
    cansync::ParameterDefinition::Access access = cansync::ParameterDefinition::Access::read_write;
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

/// The definitions that the sections say.
std::vector<cansync::ParameterDefinition> parameter_definitions(const ParameterSections& sections,
                                                                const ParameterProblem& problem);

}  // namespace cansync_slave
