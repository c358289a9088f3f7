#pragma once

#include <string>
#include <string_view>

namespace text {

/// `name` as the instance of a unit, in the way of `systemd-escape`: in the unit `%I` is the name again. Allocates;
/// any thread.
std::string unit_instance(std::string_view name);

/// `word` as one word of a shell command: in quotes when the shell would take it for something else. Allocates; any
/// thread.
std::string shell_word(std::string_view word);

}  // namespace text
