#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "dbc/database.h"

/// Reading of DBC files. They allocate; not for the realtime thread.
namespace dbc {

/// What was not used of a file, or not as it is written, and where.
struct Remark {
  std::size_t line = 1;    ///< from 1
  std::size_t column = 1;  ///< in bytes, from 1
  std::string text;        ///< what was found, what is allowed, and what was done
};

/// Most remarks that are kept of one file; the others are counted.
inline constexpr std::size_t kMostRemarks = 10000;
/// Longest message, in bytes: longer ones are carried in no packets either.
inline constexpr unsigned kLongestMessage = 1785;
/// Most signals of one message.
inline constexpr std::size_t kMostSignals = 4096;

/// What a file is worth.
struct File {
  Database database;
  std::vector<Remark> remarks;   ///< in the order in which they were found
  std::size_t more_remarks = 0;  ///< those over kMostRemarks
  std::string refused;           ///< why nothing can be used; empty: `database` has a message at least
};

/// Reads a file: what is understood is used, what is not is left out with a remark. Of its statements BO_
/// (messages) with SG_ (signals), VAL_ (names of values), SIG_VALTYPE_ (floating point), SG_MUL_VAL_ (several
/// multiplexors, ranges) and the long names among BA_ are used; the others of the format are passed over.
/// Text that is not UTF-8 is taken for Windows-1252. Refused is only a file without any message. Never throws
/// but for want of memory; time and memory are bounded by the size of the file.
File read_database(std::string_view text);

}  // namespace dbc
