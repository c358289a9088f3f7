#include "signals/signal_file.h"

#include <fmt/format.h>

#include <utility>
#include <vector>

#include "config/problem.h"
#include "dbc/reader.h"
#include "signals/signal_table.h"

namespace signals {

std::variant<dbc::Database, std::string> read_signal_file(std::string_view content, const std::string& file) {
  if (file.ends_with(".toml")) {
    auto table = read_signal_table(content, file);
    if (auto* database = std::get_if<dbc::Database>(&table)) return std::move(*database);
    return config::problems_text(std::get<std::vector<config::Problem>>(table));
  }
  auto read = dbc::read_database(content);
  if (auto* database = std::get_if<dbc::Database>(&read)) return std::move(*database);
  std::string text;
  for (const dbc::Problem& problem : std::get<std::vector<dbc::Problem>>(read))
    text += fmt::format("{}{}:{}:{}: {}", text.empty() ? "" : "\n", file, problem.line, problem.column,
                        problem.text);
  return text;
}

}  // namespace signals
