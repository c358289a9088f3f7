#include "cli/base/left_out.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "text/counts.h"

namespace cansync::cli {
namespace {

constexpr std::size_t kMostShown = 10;

/// The files of which something was told since the verb began.
std::set<std::string>& told() {
  static std::set<std::string> files;
  return files;
}

}  // namespace

void tell_left_out(Output& output, const std::string& file, std::span<const std::string> remarks,
                   std::size_t more) {
  const std::size_t all = remarks.size() + more;
  if (all == 0 || !told().insert(file).second) return;
  // With --json everything that reads the remarks is a program.
  const std::size_t shown = output.json() ? remarks.size() : std::min(remarks.size(), kMostShown);
  for (std::size_t i = 0; i < shown; ++i) output.remark(remarks[i]);
  if (all > shown) output.remark(fmt::format("{}: and {}", file, text::counted(all - shown, "more remark")));
}

ExitCode end_of_verb(ExitCode code) {
  const bool in_part = !told().empty();
  told().clear();
  return in_part && code == ExitCode::done ? ExitCode::in_part : code;
}

}  // namespace cansync::cli
