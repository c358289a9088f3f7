#include "cli/dbc/dbc_file.h"

#include <fmt/format.h>

#include <cmath>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

#include "cli/base/files.h"
#include "cli/base/left_out.h"
#include "cli/text/values.h"
#include "dbc/encode.h"
#include "signals/signal_file.h"
#include "text/counts.h"
#include "text/visible.h"

namespace cansync::cli {
namespace {

constexpr std::size_t kLargestFile = std::size_t{16} * 1024 * 1024;  // those of whole vehicles have some 5 MB

}  // namespace

dbc::Database load_signals(const std::string& path, Output& output) {
  const auto bytes = read_file(path, kLargestFile);
  const std::string_view content(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  auto read = signals::read_signal_file(content, path);
  if (const auto* refused = std::get_if<std::string>(&read)) throw UsageError(*refused);
  auto& file = std::get<signals::SignalFile>(read);
  tell_left_out(output, path, file.remarks, file.more_remarks);
  return std::move(file.database);
}

void add_signal_files(CLI::App& verb, std::string& path, const std::string& what) {
  auto* dbc = verb.add_option("--dbc", path, what + " this DBC file")->type_name("FILE");
  verb.add_option("--signals", path, what + " this file: a DBC file, or a table (.toml)")
      ->type_name("FILE")
      ->excludes(dbc);
}

std::string meaning_of(const dbc::Message& message, std::span<const dbc::Reading> readings,
                       std::size_t others) {
  std::string text;
  if (others > 0) text = fmt::format(" (or {} of this group)", text::counted(others, "other message"));
  text += readings.empty() ? "" : ":";
  for (const dbc::Reading& reading : readings) {
    if (&reading != &readings.front()) text += ",";
    if (std::isnan(reading.value) && !reading.word.empty()) {
      text += fmt::format(" {} {} (0x{:X})", reading.signal->name, reading.word, reading.raw);
      continue;
    }
    const char* mark = reading.signal->kind == dbc::NumberKind::text ? "\"" : "";
    text += fmt::format(" {} {}{}{}", reading.signal->name, mark, dbc::value_text(reading), mark);
    if (!reading.signal->unit.empty()) text += " " + reading.signal->unit;
    if (!reading.word.empty()) text += fmt::format(" ({})", reading.word);
  }
  return text::visible(message.name + text);
}

void add_meaning(const dbc::Message* message, std::span<const dbc::Reading> readings,
                 text::JsonObject& object) {
  text::JsonArray signals;
  for (const dbc::Reading& reading : readings) {
    text::JsonObject signal;
    signal.add("name", reading.signal->name);
    if (reading.signal->kind == dbc::NumberKind::text) {
      signal.add_null("raw").add_null("value").add("unit", reading.signal->unit).add("word", reading.text);
    } else {
      // The digits that people are shown: all of a whole number of 64 bits, and not those of a float's double.
      signal.add("raw", reading.raw)
          .add_json("value", std::isfinite(reading.value) ? dbc::value_text(reading) : "null")
          .add("unit", reading.signal->unit)
          .add("word", reading.word);
    }
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
