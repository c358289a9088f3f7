#include "cli/dbc/dbc_file.h"

#include <fmt/format.h>

#include <span>
#include <variant>
#include <vector>

#include "cli/base/files.h"
#include "cli/text/values.h"
#include "dbc/reader.h"

namespace cansync::cli {
namespace {

constexpr std::size_t kLargestFile = std::size_t{16} * 1024 * 1024;  // those of whole vehicles have some 5 MB

}  // namespace

dbc::Database load_dbc(const std::string& path) {
  const auto bytes = read_file(path, kLargestFile);
  auto read = dbc::read_database({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  if (auto* database = std::get_if<dbc::Database>(&read)) return std::move(*database);
  std::string text;
  for (const dbc::Problem& problem : std::get<std::vector<dbc::Problem>>(read))
    text += fmt::format("{}{}:{}:{}: {}", text.empty() ? "" : "\n", path, problem.line, problem.column,
                        problem.text);
  throw UsageError(text);
}

std::string meaning_of(const dbc::Message& message, std::span<const dbc::Reading> readings) {
  std::string text;
  for (const dbc::Reading& reading : readings) {
    text += fmt::format("{} {} {:.10g}", text.empty() ? ":" : ",", reading.signal->name, reading.value);
    if (!reading.signal->unit.empty()) text += " " + reading.signal->unit;
    if (!reading.word.empty()) text += fmt::format(" ({})", reading.word);
  }
  return message.name + text;
}

void add_meaning(const dbc::Message* message, std::span<const dbc::Reading> readings,
                 text::JsonObject& object) {
  text::JsonArray signals;
  for (const dbc::Reading& reading : readings) {
    text::JsonObject signal;
    signal.add("name", reading.signal->name)
        .add("raw", reading.raw)
        .add("value", reading.value)
        .add("unit", reading.signal->unit)
        .add("word", reading.word);
    signals.add_json(signal.text());
  }
  if (message == nullptr) {
    object.add_null("message");
  } else {
    object.add("message", message->name);
  }
  object.add("signals", signals);
}

}  // namespace cansync::cli
