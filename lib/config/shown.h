#pragma once

#include <string>
#include <string_view>

namespace config {

/// `text` as it stands in messages: of a long one the beginning, and how long it is. UTF-8 stays whole. Pure.
std::string shown(std::string_view text);

}  // namespace config
