// DBC files (lib/dbc), and frames read by those that are accepted.
#include <array>
#include <variant>

#include "bytes.h"
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
  const auto& database = std::get<dbc::Database>(read);
  const std::array<std::uint8_t, 8> bytes = {0, 1, 2, 0x7F, 0x80, 0xFE, 0xFF, 0x55};
  for (const dbc::Message& message : database.messages()) {
    require(database.find(message.identifier, message.extended) == &message, "every message is found");
    require(dbc::read_signals(message, bytes).size() <= message.signals.size(), "no signal comes twice");
    const std::vector<std::uint8_t> whole(message.length);
    for (const dbc::Signal& signal : message.signals)
      require(dbc::raw_bits(signal, whole).has_value(), "every signal lies in its message");
  }
  return 0;
}
