// Tables of signals in TOML (lib/signals), and frames read by those that are accepted.
#include <variant>

#include "bytes.h"
#include "database_check.h"
#include "require.h"
#include "signals/signal_table.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using fuzz::require;
  const auto read = signals::read_signal_table(fuzz::text_of(data, size), "fuzz.toml");
  if (const auto* problems = std::get_if<std::vector<config::Problem>>(&read)) {
    require(!problems->empty(), "a refused table has some problems");
    for (const config::Problem& problem : *problems) require(!problem.text.empty(), "a problem is told");
    return 0;
  }
  fuzz::check_database(std::get<dbc::Database>(read));
  return 0;
}
