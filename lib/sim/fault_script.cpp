#include "sim/fault_script.h"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>
#include <variant>

#include "can/candump.h"
#include "cansync/telegram.h"
#include "text/text_file.h"
#include "text/toml_guard.h"

namespace sim {
namespace {

constexpr unsigned bit(FaultKind kind) {
  return 1u << static_cast<unsigned>(kind);
}

constexpr unsigned kEveryKind = (1u << kFaultKinds) - 1;
constexpr unsigned kFiltered =
    bit(FaultKind::lost) | bit(FaultKind::late) | bit(FaultKind::corrupted) | bit(FaultKind::duplicated);
constexpr unsigned kAnswers = bit(FaultKind::wrong_answer) | bit(FaultKind::busy);

// The longest delay that makes sense on a line whose slowest interval is 8 ms.
constexpr double kMostMicroseconds = 1'000'000;

// A channel by the name that people use for it, as identifier and mask.
struct ChannelName {
  std::string_view name;
  std::uint32_t identifier;
  std::uint32_t mask;
};
constexpr std::array<ChannelName, 7> kChannelNames = {{
    {"action", cansync::identifier::action, 0x7FF},
    {"wrc1", cansync::identifier::reference_one, 0x780},
    {"wrc2", cansync::identifier::reference_two, 0x780},
    {"rdc1", cansync::identifier::actual_one, 0x780},
    {"rdc2", cansync::identifier::actual_two, 0x780},
    {"command", cansync::identifier::command, 0x780},
    {"response", cansync::identifier::response, 0x780},
}};

// What a value looks like in the file, for error messages.
std::string shown(const toml::node& node) {
  if (const auto text = node.value_exact<std::string>()) return fmt::format("\"{}\"", *text);
  if (const auto integer = node.value_exact<std::int64_t>()) return fmt::format("{}", *integer);
  if (const auto number = node.value_exact<double>()) return fmt::format("{}", *number);
  if (const auto truth = node.value_exact<bool>()) return *truth ? "true" : "false";
  if (node.is_array()) return "an array";
  return node.is_table() ? "a table" : "a date or time";
}

// Reads one table [[fault]].
class FaultReader {
 public:
  FaultReader(const toml::table& table, std::string_view file, std::vector<FaultScriptError>& errors)
      : table_(table), file_(file), errors_(errors) {}

  Fault read() {
    if (!read_kind()) return fault_;
    refuse_unknown_keys();
    read_when();
    read_filter();
    read_receivers();
    if (fault_.kind == FaultKind::silent) require("slave", "the slave number 0..31");
    if (fault_.kind == FaultKind::late) {
      require("delay_us", "how many microseconds the frame is late");
      fault_.delay = microseconds("delay_us", 0.001);
    }
    if (fault_.kind == FaultKind::inject) {
      fault_.delay = microseconds("at_us", 0);
      read_frame();
    }
    return fault_;
  }

 private:
  // A key, the kinds of fault that know it, and what reads it.
  struct Key {
    std::string_view name;
    unsigned kinds;
  };
  static constexpr std::array<Key, 13> kKeys = {{
      {"kind", kEveryKind},
      {"from", kEveryKind},
      {"to", kEveryKind},
      {"count", kEveryKind},
      {"probability", kEveryKind},
      {"slave", kFiltered | kAnswers | bit(FaultKind::silent) | bit(FaultKind::missing_sync)},
      {"channel", kFiltered},
      {"identifier", kFiltered},
      {"mask", kFiltered},
      {"receivers", bit(FaultKind::lost)},
      {"delay_us", bit(FaultKind::late)},
      {"frame", bit(FaultKind::inject)},
      {"at_us", bit(FaultKind::inject)},
  }};

  void wrong(const toml::source_region& place, std::string message) {
    errors_.push_back({std::string(file_), place.begin.line, place.begin.column, std::move(message)});
  }

  void wrong_value(std::string_view key, const toml::node& node, std::string_view allowed) {
    wrong(node.source(), fmt::format("{} is {}; allowed: {}", key, shown(node), allowed));
  }

  void require(std::string_view key, std::string_view what) {
    if (table_.contains(key)) return;
    wrong(table_.source(),
          fmt::format("a fault of kind \"{}\" needs the key {}: {}", name(fault_.kind), key, what));
  }

  bool read_kind() {
    std::string kinds;
    for (unsigned k = 0; k < kFaultKinds; ++k) {
      kinds += fmt::format("{}\"{}\"", k == 0 ? "" : ", ", name(static_cast<FaultKind>(k)));
    }
    const toml::node* node = table_.get("kind");
    if (node == nullptr) {
      wrong(table_.source(), "a fault needs the key kind; allowed: " + kinds);
      return false;
    }
    const auto text = node->value_exact<std::string>();
    for (unsigned k = 0; text && k < kFaultKinds; ++k) {
      fault_.kind = static_cast<FaultKind>(k);
      if (*text == name(fault_.kind)) return true;
    }
    wrong_value("kind", *node, kinds);
    return false;
  }

  void refuse_unknown_keys() {
    std::string allowed;
    for (const Key& key : kKeys) {
      if ((key.kinds & bit(fault_.kind)) == 0) continue;
      allowed += fmt::format("{}{}", allowed.empty() ? "" : ", ", key.name);
    }
    for (const auto& entry : table_) {
      const toml::key& key = entry.first;
      const auto* known =
          std::find_if(kKeys.begin(), kKeys.end(), [&](const Key& k) { return k.name == key.str(); });
      if (known != kKeys.end() && (known->kinds & bit(fault_.kind)) != 0) continue;
      wrong(key.source(), fmt::format("{} is no key of a fault of kind \"{}\"; allowed: {}", key.str(),
                                      name(fault_.kind), allowed));
    }
  }

  std::optional<std::uint64_t> integer(std::string_view key, std::uint64_t least, std::uint64_t most) {
    const toml::node* node = table_.get(key);
    if (node == nullptr) return std::nullopt;
    const auto value = node->value_exact<std::int64_t>();
    if (value && *value >= 0 && static_cast<std::uint64_t>(*value) >= least &&
        static_cast<std::uint64_t>(*value) <= most) {
      return static_cast<std::uint64_t>(*value);
    }
    wrong_value(key, *node, fmt::format("a whole number {} to {}", least, most));
    return std::nullopt;
  }

  std::optional<double> number(std::string_view key, double least, double most) {
    const toml::node* node = table_.get(key);
    if (node == nullptr) return std::nullopt;
    const auto value = node->is_number() ? node->value<double>() : std::nullopt;
    if (value && *value >= least && *value <= most) return value;
    wrong_value(key, *node, fmt::format("a number {} to {}", least, most));
    return std::nullopt;
  }

  cansync::Duration microseconds(std::string_view key, double least) {
    const double value = number(key, least, kMostMicroseconds).value_or(0);
    return cansync::Duration(std::llround(value * 1000));
  }

  void read_when() {
    constexpr auto kMost = static_cast<std::uint64_t>(INT64_MAX);
    fault_.from = integer("from", 0, kMost).value_or(0);
    fault_.to = integer("to", 0, kMost).value_or(Fault::kNoLimit);
    fault_.count = integer("count", 1, kMost).value_or(Fault::kNoLimit);
    fault_.probability = number("probability", 0, 1).value_or(1);
    if (fault_.to < fault_.from) {
      wrong_value("to", *table_.get("to"), fmt::format("from ({}) or later", fault_.from));
    }
  }

  void read_filter() {
    if (const auto slave = integer("slave", 0, cansync::SlaveNumber::max)) {
      fault_.slave = cansync::SlaveNumber::from(*slave);
    }
    const toml::node* channel = table_.get("channel");
    const toml::node* identifier = table_.get("identifier");
    if (channel != nullptr && identifier != nullptr) {
      wrong(identifier->source(), "channel and identifier exclude each other; leave one out");
    }
    if (channel != nullptr) read_channel(*channel);
    if (identifier != nullptr) {
      fault_.identifier = static_cast<std::uint32_t>(integer("identifier", 0, 0x7FF).value_or(0));
      fault_.mask = static_cast<std::uint32_t>(integer("mask", 0, 0x7FF).value_or(0x7FF));
    } else if (const toml::node* mask = table_.get("mask")) {
      wrong(mask->source(), "mask needs the key identifier");
    }
  }

  void read_channel(const toml::node& node) {
    std::string names;
    const auto text = node.value_exact<std::string>();
    for (const ChannelName& channel : kChannelNames) {
      if (text && *text == channel.name) {
        fault_.identifier = channel.identifier;
        fault_.mask = channel.mask;
        return;
      }
      names += fmt::format("{}\"{}\"", names.empty() ? "" : ", ", channel.name);
    }
    wrong_value("channel", node, names);
  }

  void read_receivers() {
    const toml::node* node = table_.get("receivers");
    if (node == nullptr || fault_.kind != FaultKind::lost) return;
    constexpr std::string_view kAllowed = "an array of slave numbers 0..31 and \"master\", at least one";
    const toml::array* list = node->as_array();
    if (list == nullptr || list->empty()) return wrong_value("receivers", *node, kAllowed);
    fault_.receivers = {};
    fault_.lost_to_master = false;
    for (const toml::node& entry : *list) {
      const auto slave = entry.value_exact<std::int64_t>();
      const auto text = entry.value_exact<std::string>();
      if (text && *text == "master") {
        fault_.lost_to_master = true;
      } else if (slave && *slave >= 0 && *slave <= cansync::SlaveNumber::max) {
        fault_.receivers.set(*cansync::SlaveNumber::from(static_cast<std::uint64_t>(*slave)));
      } else {
        wrong_value("receivers", entry, kAllowed);
      }
    }
  }

  void read_frame() {
    require("frame", "what is sent, as \"identifier#data\" in hexadecimal digits, for example \"105#0011\"");
    const toml::node* node = table_.get("frame");
    if (node == nullptr) return;
    const auto text = node->value_exact<std::string>();
    if (!text) return wrong_value("frame", *node, "a text \"identifier#data\" in hexadecimal digits");
    const auto parsed = can::parse_candump_frame(*text);
    if (const auto* error = std::get_if<can::CandumpError>(&parsed)) {
      return wrong_value(
          "frame", *node,
          fmt::format("\"identifier#data\" (at character {}: {})", error->column, error->message));
    }
    fault_.frame = std::get<can::Frame>(parsed);
    if (fault_.frame.error) {
      wrong_value("frame", *node, "a data or remote frame; error frames come with kind = \"corrupted\"");
    }
  }

  const toml::table& table_;
  std::string_view file_;
  std::vector<FaultScriptError>& errors_;
  Fault fault_;
};

void read_faults(const toml::table& document, std::string_view file, FaultScript& script) {
  const auto wrong = [&](const toml::source_region& place, std::string message) {
    script.errors.push_back({std::string(file), place.begin.line, place.begin.column, std::move(message)});
  };
  for (const auto& [key, node] : document) {
    if (key.str() != "fault") {
      wrong(key.source(), fmt::format("{} is unknown here; allowed: tables [[fault]]", key.str()));
      continue;
    }
    const toml::array* list = node.as_array();
    if (list == nullptr) {
      wrong(node.source(),
            fmt::format("fault is {}; allowed: tables [[fault]] with double brackets", shown(node)));
      continue;
    }
    for (const toml::node& entry : *list) {
      if (const toml::table* table = entry.as_table()) {
        script.faults.push_back(FaultReader(*table, file, script.errors).read());
        const toml::node* kind = table->get("kind");
        const toml::source_position place = (kind != nullptr ? *kind : entry).source().begin;
        script.places.push_back({place.line, place.column});
      } else {
        wrong(entry.source(), fmt::format("fault is {}; allowed: tables [[fault]]", shown(entry)));
      }
    }
  }
}

}  // namespace

std::string FaultScriptError::text() const {
  return line == 0 ? fmt::format("{}: {}", file, message)
                   : fmt::format("{}:{}:{}: {}", file, line, column, message);
}

FaultScript parse_fault_script(std::string_view toml, std::string_view file) {
  FaultScript script;
  if (const auto place = text::too_deep_key(toml)) {
    script.errors.push_back({std::string(file), place->line, place->column,
                             "found a key of more than 16 parts; allowed: tables [[fault]]"});
    return script;
  }
  try {
    read_faults(toml::parse(toml, file), file, script);
  } catch (const toml::parse_error& error) {
    const toml::source_position place = error.source().begin;
    script.errors.push_back({std::string(file), place.line, place.column,
                             fmt::format("not valid TOML: {}", error.description())});
  }
  if (!script.errors.empty()) {
    script.faults.clear();
    script.places.clear();
  }
  const auto place = [](const FaultScriptError& error) { return std::pair(error.line, error.column); };
  std::sort(script.errors.begin(), script.errors.end(),
            [&](const FaultScriptError& a, const FaultScriptError& b) { return place(a) < place(b); });
  return script;
}

FaultScript load_fault_script(const std::string& path) {
  const auto content = text::read_file(path);
  if (const auto* problem = std::get_if<text::FileProblem>(&content))
    return {{}, {}, {{path, 0, 0, "cannot be read: " + problem->text}}};
  return parse_fault_script(std::get<std::string>(content), path);
}

}  // namespace sim
