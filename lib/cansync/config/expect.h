#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "cansync/config/draft.h"
#include "cansync/settings/settings.h"
#include "profile/profile.h"

/// The option `expect` of a slave: who the drive is. Main thread; reads passports, allocates.
namespace cansyncd {

/// Is this a list of at most 32 strings of the forms of `kExpectWords`?
bool takes_expect(const Draft& draft, const Value& value);

inline constexpr std::string_view kExpectWords =
    "a list of at most 32 strings, each \"NUMBER=VALUE\", \"NAME=VALUE\", \"profile\" or \"passport FILE\"";
static_assert(cansync::kListedParameters == 32, "the words name it");

/// The parameters and raw values that `items` stand for, each number once, in their order; or what is wrong with
/// one of them. `profile`: the slave's, null when it has none. A relative file of a passport counts from `folder`.
std::variant<std::vector<cansync::ParameterValue>, std::string> expected_values(
    const std::vector<std::string>& items, const profile::Profile* profile, const std::string& folder);

}  // namespace cansyncd
