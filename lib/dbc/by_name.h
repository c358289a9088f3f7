#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <variant>

#include "dbc/database.h"

/// Resolves what a user names to send it: messages, signals, values. A name with two meanings is refused. The text in place
/// of a result says what was found and what is allowed; the caller puts the place before it. Allocates; any thread.
namespace dbc {

std::variant<const Message*, std::string> message_by_name(const Database& database, std::string_view name);

std::variant<const Signal*, std::string> signal_by_name(const Message& message, std::string_view name);

/// The bits of a value: digits in the signal's unit, within the limits of the file if it has any, or the name of a
/// value.
std::variant<std::uint64_t, std::string> bits_of(const Signal& signal, std::string_view value);
/// Likewise of a number in the signal's unit.
std::variant<std::uint64_t, std::string> bits_of(const Signal& signal, double value);

}  // namespace dbc
