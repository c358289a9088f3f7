// Tables of signals in TOML (lib/signals), and frames read by those that are accepted.
#include "bounded.h"
#include "bytes.h"
#include "database_check.h"
#include "require.h"
#include "signals/signal_table.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using fuzz::require;
  const signals::SignalTable read = fuzz::bounded(size, fuzz::kOfTextInPart, [&] {
    return signals::read_signal_table(fuzz::text_of(data, size), "fuzz.toml");
  });
  for (const config::Problem& problem : read.problems) require(!problem.text.empty(), "a problem is told");
  fuzz::check_database(read.database);
  return 0;
}
