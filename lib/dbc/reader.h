#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "dbc/database.h"

/// Reading of DBC files. They allocate; not for the realtime thread.
namespace dbc {

/// What is wrong with a file, and where.
struct Problem {
  std::size_t line = 1;    ///< from 1
  std::size_t column = 1;  ///< in bytes, from 1
  std::string text;        ///< what was found and what is allowed
};

/// Most problems that are told of one file.
inline constexpr std::size_t kMostProblems = 10;
/// Longest message, in bytes: longer ones are carried in no packets either.
inline constexpr unsigned kLongestMessage = 1785;

/// Reads a file: of its statements BO_ (messages) with SG_ (signals), VAL_ (names of values) and SIG_VALTYPE_
/// (floating point); all others are passed over. Text that is not UTF-8 is taken for ISO-8859-1. A signal
/// that is chosen over more than one level (SG_MUL_VAL_, `m1M`) is refused. Problems: at most kMostProblems,
/// in the order of the file. Never throws but for want of memory.
std::variant<Database, std::vector<Problem>> read_database(std::string_view text);

}  // namespace dbc
