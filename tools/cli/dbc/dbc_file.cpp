#include "cli/dbc/dbc_file.h"

#include <fmt/format.h>

#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

#include "cli/base/files.h"
#include "cli/text/values.h"
#include "signals/signal_file.h"

namespace cansync::cli {
namespace {

constexpr std::size_t kLargestFile = std::size_t{16} * 1024 * 1024;  // those of whole vehicles have some 5 MB

}  // namespace

dbc::Database load_signals(const std::string& path) {
  const auto bytes = read_file(path, kLargestFile);
  const std::string_view content(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  auto read = signals::read_signal_file(content, path);
  if (auto* database = std::get_if<dbc::Database>(&read)) return std::move(*database);
  throw UsageError(std::get<std::string>(read));
}

void add_signal_files(CLI::App& verb, std::string& path, const std::string& what) {
  auto* dbc = verb.add_option("--dbc", path, what + " this DBC file")->type_name("FILE");
  verb.add_option("--signals", path, what + " this file: a DBC file, or a table (.toml)")
      ->type_name("FILE")
      ->excludes(dbc);
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
