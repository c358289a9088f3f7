#pragma once

#include <string_view>

/// Names that people give to slaves, values, messages and signals. Pure; any thread.
namespace text {

/// True for a text that begins as a number does, with a digit or with a sign and a digit: a number ("12",
/// "0x1F"), a range ("2-4"), or a list that begins with one ("1,winder").
constexpr bool begins_as_number(std::string_view text) noexcept {
  if (text.starts_with('-') || text.starts_with('+')) text.remove_prefix(1);
  return !text.empty() && text.front() >= '0' && text.front() <= '9';
}

/// True for a text that no list, range or number can mean, nor an assignment ("speed=5"), nor an option
/// ("--all"): the only one that may be a name.
constexpr bool is_given_name(std::string_view text) noexcept {
  return !text.empty() && !begins_as_number(text) && !text.starts_with('-') &&
         text.find_first_of(",=") == std::string_view::npos;
}

/// What `is_given_name` asks for, in words for a message.
inline constexpr std::string_view kGivenNameWords = "no digit or '-' first, no ',' or '='";

}  // namespace text
