#include "sim/device_script.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <utility>
#include <variant>

#include "can/candump.h"
#include "config/document.h"

namespace sim {
namespace {

using config::Content;
using config::Node;
using config::Problem;

constexpr config::Wording kWording{
    .unreadable = "cannot be read: ",
    .no_toml = "not valid TOML: ",
    .allowed = "tables [[answer]] and [[periodic]]",
};
constexpr std::array<std::string_view, 7> kAnswerKeys = {"to",        "mask",     "data_mask", "frame",
                                                         "copy_data", "after_ms", "count"};
constexpr std::array<std::string_view, 4> kPeriodicKeys = {"frame", "every_ms", "phase_ms", "counting_byte"};
constexpr double kLongest = 3'600'000.0;  // ms
constexpr double kShortestPeriod = 0.1;   // ms
/// Most tables of a kind.
constexpr std::size_t kMostTables = 256;

std::string shown(const Node& node) {
  return node.kind == Node::Kind::value ? node.value.text : "a table";
}

/// Reads one table.
class TableReader {
 public:
  TableReader(const Content& table, std::vector<Problem>& errors) : table_(table), errors_(errors) {}

  ScriptedAnswer read_answer() {
    refuse_unknown(kAnswerKeys);
    ScriptedAnswer answer;
    if (const auto to =
            frame("to", "what is answered, such as \"601#40\" (data that begin so), or \"601#R\"")) {
      answer.to = *to;
      answer.mask = to->extended ? can::kExtendedIdentifierMask : can::kStandardIdentifierMask;
      for (unsigned i = 0; i < to->dlc && !to->remote; ++i) answer.data_mask[i] = 0xFF;
    }
    answer.mask &=
        static_cast<std::uint32_t>(integer("mask", 0, can::kExtendedIdentifierMask).value_or(answer.mask));
    read_data_mask(answer);
    answer.copy_data = flag("copy_data");
    if (const auto reply = frame("frame", "the answer, such as \"581#4300\"")) answer.frame = *reply;
    answer.after = milliseconds("after_ms", 0.0, 0.0);
    answer.count = static_cast<std::uint64_t>(integer("count", 1, INT64_MAX).value_or(-1));
    return answer;
  }

  ScriptedPeriod read_period() {
    refuse_unknown(kPeriodicKeys);
    ScriptedPeriod period;
    if (const auto sent = frame("frame", "what is sent, such as \"181#0011\"")) period.frame = *sent;
    if (table_.find("every_ms") == nullptr) missing("every_ms", "milliseconds between two");
    period.every = milliseconds("every_ms", kShortestPeriod, 100.0);
    period.phase = milliseconds("phase_ms", 0.0, 0.0);
    if (const auto byte = integer("counting_byte", 0, 7)) {
      period.counting = static_cast<std::uint8_t>(*byte);
      if (period.frame.remote || *byte >= period.frame.dlc)
        wrong_value(*table_.find("counting_byte"), "a byte that the frame has, from 0");
    }
    return period;
  }

 private:
  void missing(std::string_view key, std::string_view what) {
    errors_.push_back({table_.where(), "", fmt::format("the key {} is missing: {}", key, what)});
  }
  void wrong_value(const Node& node, std::string_view allowed) {
    errors_.push_back(
        {node.where, "", fmt::format("{} is {}; allowed: {}", node.name(), shown(node), allowed)});
  }
  template <class T>
  const T* scalar(const Node& node) const {
    return node.kind == Node::Kind::value ? config::scalar<T>(node.value) : nullptr;
  }

  void refuse_unknown(std::span<const std::string_view> keys) {
    for (const Node* node : table_.nodes()) {
      if (std::find(keys.begin(), keys.end(), node->name()) != keys.end()) continue;
      errors_.push_back(
          {node->key, "",
           fmt::format("{} is unknown here; allowed: {}", node->name(), fmt::join(keys, ", "))});
    }
  }

  std::optional<std::int64_t> integer(std::string_view key, std::int64_t least, std::int64_t most) {
    const Node* node = table_.find(key);
    if (node == nullptr) return std::nullopt;
    const auto* value = scalar<std::int64_t>(*node);
    if (value != nullptr && *value >= least && *value <= most) return *value;
    wrong_value(*node, fmt::format("a whole number {} to {}", least, most));
    return std::nullopt;
  }

  can::Time milliseconds(std::string_view key, double least, double otherwise) {
    const Node* node = table_.find(key);
    double value = otherwise;
    if (node != nullptr) {
      const auto* real = scalar<double>(*node);
      const auto* whole = scalar<std::int64_t>(*node);
      value = real != nullptr ? *real : (whole != nullptr ? static_cast<double>(*whole) : -1.0);
      if (!(value >= least && value <= kLongest)) {
        wrong_value(*node, fmt::format("milliseconds, {} to {:.0f}", least, kLongest));
        value = otherwise;
      }
    }
    return can::Time(std::llround(value * 1'000'000.0));
  }

  bool flag(std::string_view key) {
    const Node* node = table_.find(key);
    if (node == nullptr) return false;
    const auto* value = scalar<bool>(*node);
    if (value == nullptr) wrong_value(*node, "true or false");
    return value != nullptr && *value;
  }

  std::optional<can::Frame> frame(std::string_view key, std::string_view what) {
    const Node* node = table_.find(key);
    if (node == nullptr) {
      missing(key, what);
      return std::nullopt;
    }
    const auto* text = scalar<std::string>(*node);
    const auto parsed = can::parse_candump_frame(text != nullptr ? *text : std::string());
    if (const auto* error = std::get_if<can::CandumpError>(&parsed)) {
      wrong_value(*node,
                  fmt::format("\"identifier#data\" (at character {}: {})", error->column, error->message));
      return std::nullopt;
    }
    const auto& found = std::get<can::Frame>(parsed);
    if (!found.error) return found;
    wrong_value(*node, "a data or remote frame");
    return std::nullopt;
  }

  void read_data_mask(ScriptedAnswer& answer) {
    const Node* node = table_.find("data_mask");
    if (node == nullptr) return;
    const auto* text = scalar<std::string>(*node);
    // Its notation is that of data.
    const auto parsed = can::parse_candump_frame("000#" + (text != nullptr ? *text : std::string("?")));
    const auto* mask = std::get_if<can::Frame>(&parsed);
    if (mask == nullptr || mask->remote || mask->dlc > answer.to.dlc)
      return wrong_value(*node, "hexadecimal digits, up to as many bytes as `to` has, such as \"FF0F\"");
    std::copy(mask->data.begin(), mask->data.end(), answer.data_mask.begin());
  }

  const Content& table_;
  std::vector<Problem>& errors_;
};

/// Reads up to `kMostTables` tables of one kind; those with an error are left out.
template <class Table>
void read_tables(const config::Document& document, const std::vector<const Node*>& sections,
                 std::vector<Problem>& errors, std::vector<Table>& tables, Table (TableReader::*read)()) {
  for (std::size_t i = 0; i < sections.size(); ++i) {
    if (i == kMostTables) {
      errors.push_back({sections[i]->where, "",
                        fmt::format("found {} tables [[{}]]; allowed: {}", sections.size(),
                                    sections[i]->name(), kMostTables)});
      return;
    }
    const std::size_t before = errors.size();
    const Content content(document, sections[i]);
    Table table = (TableReader(content, errors).*read)();
    if (errors.size() == before) tables.push_back(std::move(table));
  }
}

DeviceScript read_script(config::Document document) {
  DeviceScript script;
  script.errors = std::move(document.problems);
  const Content root(document, nullptr);
  for (const Node* node : root.nodes()) {
    const bool known = node->name() == "answer" || node->name() == "periodic";
    if (!known || node->kind != Node::Kind::sections)
      script.errors.push_back(
          {node->key, "",
           fmt::format("{} is unknown here; allowed: tables [[answer]] and [[periodic]]",
                       known ? node->name() + " without double brackets" : node->name())});
  }
  read_tables(document, root.each("answer"), script.errors, script.device.answers, &TableReader::read_answer);
  read_tables(document, root.each("periodic"), script.errors, script.device.periods,
              &TableReader::read_period);
  config::sort_by_place(script.errors);
  return script;
}

}  // namespace

DeviceScript parse_device_script(std::string_view toml, const std::string& file) {
  return read_script(config::parse_document_in_part(toml, file, kWording));
}

DeviceScript load_device_script(const std::string& path) {
  return read_script(config::read_document_in_part(path, kWording));
}

}  // namespace sim
