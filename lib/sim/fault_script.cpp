#include "sim/fault_script.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>
#include <variant>

#include "can/candump.h"
#include "config/document.h"

namespace sim {
namespace {

using config::Content;
using config::Node;
using config::Position;
using config::Problem;

constexpr config::Wording kWording{
    .unreadable = "cannot be read: ",
    .no_toml = "not valid TOML: ",
    .allowed = "tables [[fault]]",
};

constexpr unsigned bit(FaultKind kind) {
  return 1u << static_cast<unsigned>(kind);
}

constexpr unsigned kEveryKind = (1u << kFaultKinds) - 1;
constexpr unsigned kFiltered =
    bit(FaultKind::lost) | bit(FaultKind::late) | bit(FaultKind::corrupted) | bit(FaultKind::duplicated);
constexpr unsigned kAnswers = bit(FaultKind::wrong_answer) | bit(FaultKind::busy);

constexpr int kLastNode = kMostNodes - 1;
// The longest delay that makes sense on a line whose slowest interval is 8 ms.
constexpr double kMostMicroseconds = 1'000'000;

// What a value looks like in the file, for error messages.
std::string shown(const Node& node) {
  if (node.kind == Node::Kind::section) return "a table";
  if (node.kind == Node::Kind::sections || node.value.kind == config::Value::Kind::list) return "an array";
  return node.value.text;
}

template <class T>
const T* scalar(const Node& node) {
  return node.kind == Node::Kind::value ? config::scalar<T>(node.value) : nullptr;
}

// Reads one table [[fault]].
class FaultReader {
 public:
  FaultReader(const Content& table, const FaultProtocol& protocol, std::vector<Problem>& errors)
      : table_(table), protocol_(protocol), node_(protocol.node_word()), errors_(errors) {}

  Fault read() {
    if (!read_kind()) return fault_;
    refuse_unknown_keys();
    read_when();
    read_filter();
    read_receivers();
    if (fault_.kind == FaultKind::silent) require(node_, node_range());
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
  static constexpr std::size_t kKeyCount = 14;
  /// All keys; that of a node is a word of the protocol.
  std::array<Key, kKeyCount> keys() const {
    return {{
        {"kind", kEveryKind},
        {"from", kEveryKind},
        {"to", kEveryKind},
        {"count", kEveryKind},
        {"probability", kEveryKind},
        {node_, kFiltered | kAnswers | bit(FaultKind::silent) | bit(FaultKind::missing_sync)},
        {"channel", kFiltered},
        {"identifier", kFiltered},
        {"mask", kFiltered},
        {"extended", kFiltered},
        {"receivers", bit(FaultKind::lost)},
        {"delay_us", bit(FaultKind::late)},
        {"frame", bit(FaultKind::inject)},
        {"at_us", bit(FaultKind::inject)},
    }};
  }

  void wrong(const Position& place, std::string message) {
    errors_.push_back({place, "", std::move(message)});
  }

  void wrong_value(const Node& node, std::string_view allowed) {
    wrong(node.where, fmt::format("{} is {}; allowed: {}", node.name(), shown(node), allowed));
  }

  void require(std::string_view key, std::string_view what) {
    if (table_.find(key) != nullptr) return;
    wrong(table_.where(),
          fmt::format("a fault of kind \"{}\" needs the key {}: {}", name(fault_.kind), key, what));
  }

  bool read_kind() {
    std::string kinds;
    for (unsigned k = 0; k < kFaultKinds; ++k) {
      kinds += fmt::format("{}\"{}\"", k == 0 ? "" : ", ", name(static_cast<FaultKind>(k)));
    }
    const Node* node = table_.find("kind");
    if (node == nullptr) {
      wrong(table_.where(), "a fault needs the key kind; allowed: " + kinds);
      return false;
    }
    const auto* text = scalar<std::string>(*node);
    for (unsigned k = 0; text != nullptr && k < kFaultKinds; ++k) {
      fault_.kind = static_cast<FaultKind>(k);
      if (*text == name(fault_.kind)) return true;
    }
    wrong_value(*node, kinds);
    return false;
  }

  void refuse_unknown_keys() {
    std::string allowed;
    const std::array<Key, kKeyCount> known_keys = keys();
    for (const Key& key : known_keys) {
      if ((key.kinds & bit(fault_.kind)) == 0) continue;
      allowed += fmt::format("{}{}", allowed.empty() ? "" : ", ", key.name);
    }
    for (const Node* node : table_.nodes()) {
      const auto* known = std::find_if(known_keys.begin(), known_keys.end(),
                                       [&](const Key& k) { return k.name == node->name(); });
      if (known != known_keys.end() && (known->kinds & bit(fault_.kind)) != 0) continue;
      wrong(node->key, fmt::format("{} is no key of a fault of kind \"{}\"; allowed: {}", node->name(),
                                   name(fault_.kind), allowed));
    }
  }

  std::optional<std::uint64_t> integer(std::string_view key, std::uint64_t least, std::uint64_t most) {
    const Node* node = table_.find(key);
    if (node == nullptr) return std::nullopt;
    const auto* value = scalar<std::int64_t>(*node);
    if (value != nullptr && *value >= 0 && static_cast<std::uint64_t>(*value) >= least &&
        static_cast<std::uint64_t>(*value) <= most) {
      return static_cast<std::uint64_t>(*value);
    }
    wrong_value(*node, fmt::format("a whole number {} to {}", least, most));
    return std::nullopt;
  }

  std::optional<double> number(std::string_view key, double least, double most) {
    const Node* node = table_.find(key);
    if (node == nullptr) return std::nullopt;
    std::optional<double> value;
    if (const auto* real = scalar<double>(*node)) value = *real;
    if (const auto* whole = scalar<std::int64_t>(*node)) value = static_cast<double>(*whole);
    if (value && *value >= least && *value <= most) return value;
    wrong_value(*node, fmt::format("a number {} to {}", least, most));
    return std::nullopt;
  }

  can::Time microseconds(std::string_view key, double least) {
    const double value = number(key, least, kMostMicroseconds).value_or(0);
    return can::Time(std::llround(value * 1000));
  }

  void read_when() {
    constexpr auto kMost = static_cast<std::uint64_t>(INT64_MAX);
    fault_.from = integer("from", 0, kMost).value_or(0);
    fault_.to = integer("to", 0, kMost).value_or(Fault::kNoLimit);
    fault_.count = integer("count", 1, kMost).value_or(Fault::kNoLimit);
    fault_.probability = number("probability", 0, 1).value_or(1);
    if (fault_.to < fault_.from) {
      wrong_value(*table_.find("to"), fmt::format("from ({}) or later", fault_.from));
    }
  }

  void read_filter() {
    if (const auto node = integer(node_, 0, kLastNode)) fault_.node = static_cast<NodeNumber>(*node);
    const Node* channel = table_.find("channel");
    const Node* identifier = table_.find("identifier");
    if (channel != nullptr && identifier != nullptr) {
      wrong(identifier->where, "channel and identifier exclude each other; leave one out");
    }
    if (channel != nullptr) read_channel(*channel);
    if (identifier != nullptr) {
      constexpr std::uint32_t kMost = can::kExtendedIdentifierMask;
      fault_.identifier = static_cast<std::uint32_t>(integer("identifier", 0, kMost).value_or(0));
      fault_.mask = static_cast<std::uint32_t>(integer("mask", 0, kMost).value_or(kMost));
    } else if (const Node* mask = table_.find("mask")) {
      wrong(mask->where, "mask needs the key identifier");
    }
    if (const Node* extended = table_.find("extended")) {
      const bool* value = scalar<bool>(*extended);
      if (value == nullptr)
        return wrong_value(*extended, "true (29-bit identifiers) or false (those of 11 bits)");
      fault_.extended = *value;
    }
  }

  void read_channel(const Node& node) {
    std::string names;
    const auto* text = scalar<std::string>(node);
    for (const ChannelName& channel : protocol_.channels()) {
      if (text != nullptr && *text == channel.name) {
        fault_.identifier = channel.identifier;
        fault_.mask = channel.mask;
        return;
      }
      names += fmt::format("{}\"{}\"", names.empty() ? "" : ", ", channel.name);
    }
    wrong_value(node, names);
  }

  void read_receivers() {
    const Node* node = table_.find("receivers");
    if (node == nullptr || fault_.kind != FaultKind::lost) return;
    const std::string allowed =
        fmt::format("an array of {} numbers 0..{} and \"master\", at least one", node_, kLastNode);
    const config::Value& list = node->value;
    if (list.kind != config::Value::Kind::list || list.items.empty()) return wrong_value(*node, allowed);
    fault_.receivers = {};
    fault_.lost_to_master = false;
    for (std::size_t i = 0; i < list.items.size(); ++i) {
      const auto* number = std::get_if<std::int64_t>(&list.items[i]);
      const auto* text = std::get_if<std::string>(&list.items[i]);
      if (text != nullptr && *text == "master") {
        fault_.lost_to_master = true;
      } else if (number != nullptr && *number >= 0 && *number <= kLastNode) {
        fault_.receivers.add(static_cast<NodeNumber>(*number));
      } else {
        wrong(node->items[i],
              fmt::format("receivers is {}; allowed: {}", config::to_toml(list.items[i]), allowed));
      }
    }
  }

  void read_frame() {
    require("frame", "what is sent, as \"identifier#data\" in hexadecimal digits, for example \"105#0011\"");
    const Node* node = table_.find("frame");
    if (node == nullptr) return;
    const auto* text = scalar<std::string>(*node);
    if (text == nullptr) return wrong_value(*node, "a text \"identifier#data\" in hexadecimal digits");
    const auto parsed = can::parse_candump_frame(*text);
    if (const auto* error = std::get_if<can::CandumpError>(&parsed)) {
      return wrong_value(
          *node, fmt::format("\"identifier#data\" (at character {}: {})", error->column, error->message));
    }
    fault_.frame = std::get<can::Frame>(parsed);
    if (fault_.frame.error) {
      wrong_value(*node, "a data or remote frame; error frames come with kind = \"corrupted\"");
    }
  }

  std::string node_range() const { return fmt::format("the {} number 0..{}", node_, kLastNode); }

  const Content& table_;
  const FaultProtocol& protocol_;
  std::string_view node_;  // the protocol's word for a node
  std::vector<Problem>& errors_;
  Fault fault_;
};

// What stands under the key `fault` instead of tables.
void refuse(const Node& fault, FaultScript& script) {
  if (fault.kind != Node::Kind::value || fault.value.kind != config::Value::Kind::list) {
    script.errors.push_back(
        {fault.where, "",
         fmt::format("fault is {}; allowed: tables [[fault]] with double brackets", shown(fault))});
    return;
  }
  for (std::size_t i = 0; i < fault.value.items.size(); ++i) {
    script.errors.push_back(
        {fault.items[i], "",
         fmt::format("fault is {}; allowed: tables [[fault]]", config::to_toml(fault.value.items[i]))});
  }
}

FaultScript read_faults(config::Document document, const FaultProtocol& protocol) {
  FaultScript script;
  script.errors = std::move(document.problems);
  const Content root(document, nullptr);
  for (const Node* node : root.nodes()) {
    if (node->name() != "fault") {
      script.errors.push_back(
          {node->key, "", fmt::format("{} is unknown here; allowed: tables [[fault]]", node->name())});
    } else if (node->kind != Node::Kind::sections) {
      refuse(*node, script);
    }
  }
  for (const Node* section : root.each("fault")) {
    const Content table(document, section);
    const std::size_t errors = script.errors.size();
    const Fault fault = FaultReader(table, protocol, script.errors).read();
    if (script.errors.size() > errors) continue;
    script.faults.push_back(fault);
    const Node* kind = table.find("kind");
    script.places.push_back(kind != nullptr ? kind->where : section->where);
  }
  config::sort_by_place(script.errors);
  return script;
}

}  // namespace

FaultScript parse_fault_script(std::string_view toml, const std::string& file,
                               const FaultProtocol& protocol) {
  return read_faults(config::parse_document_in_part(toml, file, kWording), protocol);
}

FaultScript load_fault_script(const std::string& path, const FaultProtocol& protocol) {
  return read_faults(config::read_document_in_part(path, kWording), protocol);
}

}  // namespace sim
