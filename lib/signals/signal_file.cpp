#include "signals/signal_file.h"

#include <fmt/format.h>

#include <utility>
#include <vector>

#include "config/problem.h"
#include "dbc/reader.h"
#include "signals/signal_table.h"

namespace signals {
namespace {

/// Remarks on a table that are kept.
constexpr std::size_t kMostRemarks = 10'000;

}  // namespace

std::variant<SignalFile, std::string> read_signal_file(std::string_view content, const std::string& file) {
  SignalFile out;
  if (file.ends_with(".toml")) {
    SignalTable table = read_signal_table(content, file);
    if (table.database.messages().empty())
      return table.problems.empty()
                 ? fmt::format("{}: found no message; allowed: a table with at least one [[message]]", file)
                 : config::problems_message(table.problems);
    out.database = std::move(table.database);
    for (const config::Problem& problem : table.problems) {
      if (out.remarks.size() == kMostRemarks) {
        ++out.more_remarks;
        continue;
      }
      const bool signal = problem.key.starts_with("signal.");
      const bool message = problem.key.starts_with("message.");
      out.remarks.push_back(config::to_string(problem) + "; " +
                            (signal    ? "the signal"
                             : message ? "the message"
                                       : "this section") +
                            " is left out");
    }
    return out;
  }
  dbc::File read = dbc::read_database(content);
  if (!read.refused.empty()) return fmt::format("{}: {}", file, read.refused);
  out.database = std::move(read.database);
  for (const dbc::Remark& remark : read.remarks)
    out.remarks.push_back(fmt::format("{}:{}:{}: {}", file, remark.line, remark.column, remark.text));
  out.more_remarks = read.more_remarks;
  return out;
}

}  // namespace signals
