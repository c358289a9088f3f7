#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace text {

/// `text` without what a terminal or the journal would obey: each control character, those of C1 too, is
/// written as "\x1b". `kept`: control characters that stay, e.g. "\n". Text that is no UTF-8 stays as it is.
/// Allocates; any thread.
std::string visible(std::string_view text, std::string_view kept = {});

/// `text` as printable ASCII of at most `longest` bytes: every other byte is written as "\x1b", and none of
/// these is cut. For what a peer says of itself. Allocates; any thread.
std::string visible_ascii(std::string_view text, std::size_t longest);

}  // namespace text
