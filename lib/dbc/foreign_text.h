#pragma once

#include <string>
#include <string_view>

namespace dbc {

/// `text` as UTF-8: as it is, or when it is none, taken for Windows-1252, of which ISO-8859-1 is a part.
std::string as_utf8(std::string_view text);

/// A text between quotation marks as people are shown it: UTF-8 in one line, without the backslash before a
/// quotation mark.
std::string plain_text(std::string_view text);

}  // namespace dbc
