#pragma once

#include <string>
#include <string_view>

namespace profile {

/// SHA-256 of `data` as 64 hexadecimal digits. Throws std::runtime_error when the cryptographic library
/// refuses. Any thread; allocates.
std::string sha256(std::string_view data);

}  // namespace profile
