// DBC files (lib/dbc), and frames read by those that are accepted.
#include <variant>

#include "bytes.h"
#include "database_check.h"
#include "dbc/reader.h"
#include "require.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using fuzz::require;
  const auto read = dbc::read_database(fuzz::text_of(data, size));
  if (const auto* problems = std::get_if<std::vector<dbc::Problem>>(&read)) {
    require(!problems->empty() && problems->size() <= dbc::kMostProblems, "a refused file has some problems");
    for (const dbc::Problem& problem : *problems)
      require(problem.line > 0 && problem.column > 0 && !problem.text.empty(),
              "a problem has a place and words");
    return 0;
  }
  fuzz::check_database(std::get<dbc::Database>(read));
  return 0;
}
