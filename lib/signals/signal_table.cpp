#include "signals/signal_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <optional>
#include <set>
#include <utility>

#include "config/document.h"
#include "dbc/reader.h"
#include "profile/reader_fields.h"
#include "text/counts.h"
#include "text/given_name.h"

namespace signals {
namespace {

using config::Content;
using config::Node;
using config::Problem;
using profile::detail::Fields;

constexpr config::Wording kWording{
    .unreadable = "cannot read this table of signals: ",
    .allowed = "[[message]], [[signal]], key = value, # comment",
};
constexpr std::size_t kLongestName = 64;
constexpr std::size_t kLongestUnit = 16;
constexpr std::int64_t kHighestGroup = 0x3FFFF;
constexpr std::int64_t kHighestWord = 0xFFFFFFFF;
/// Of a group the message stands for any source, with the priority that is the default.
constexpr std::uint32_t kAnySource = 0xFE;
constexpr std::uint32_t kAnyDestination = 0xFF00;  // of a group that has one
constexpr std::uint32_t kDefaultPriority = 6U << 26;

class Reader {
 public:
  explicit Reader(std::string_view toml, const std::string& file)
      : document_(config::parse_document_in_part(toml, file, kWording)) {}

  SignalTable read() {
    problems_ = document_.problems;
    const Content root(document_, nullptr);
    for (const Node* node : root.nodes()) {
      if (node->kind != Node::Kind::sections || (node->name() != "message" && node->name() != "signal"))
        problems_.push_back(
            {node->key, node->name(), "no section of a table of signals; allowed: [[message]], [[signal]]"});
    }
    for (const Node* section : root.each("message")) read_message(Content(document_, section));
    for (const Node* section : root.each("signal")) read_signal(Content(document_, section));
    while (leave_out_unchosen()) {
    }
    for (Entry& entry : messages_) set_multiplexor(entry.message);
    config::sort_by_place(problems_);
    std::vector<dbc::Message> messages;
    for (Entry& entry : messages_) messages.push_back(std::move(entry.message));
    return {dbc::Database(std::move(messages)), std::move(problems_)};
  }

 private:
  /// A message, and where `chosen_by` of each of its signals stands.
  struct Entry {
    dbc::Message message;
    std::vector<config::Position> choices;
  };

  void read_message(const Content& content) {
    const std::size_t before = problems_.size();
    Fields fields(content, "message", problems_);
    fields.only({"name", "identifier", "pgn", "extended", "length"});
    fields.require("name", "a name without blanks, of 1..64 bytes");
    dbc::Message message;
    message.name = given_name(fields);
    message.length = static_cast<unsigned>(fields.integer("length", 0, dbc::kLongestMessage).value_or(8));
    read_identifier(fields, message);
    const bool fresh = identifiers_.emplace(message.identifier, message.extended).second;
    if (!fresh)
      fields.problem(fields.has("pgn") ? "pgn" : "identifier",
                     "an earlier message has the same; allowed: each once");
    const auto same = std::find_if(messages_.begin(), messages_.end(),
                                   [&](const Entry& one) { return one.message.name == message.name; });
    if (same != messages_.end())
      fields.problem("name", fmt::format("found \"{}\" a second time; allowed: each once", message.name));
    if (problems_.size() == before) messages_.push_back({std::move(message), {}});
  }

  /// A name that the command line cannot take for a number, a list or `NAME=VALUE`.
  static std::string given_name(Fields& fields) {
    std::string name = fields.word("name", kLongestName).value_or("");
    if (!name.empty() && !text::is_given_name(name))
      fields.problem(
          "name", fmt::format("found \"{}\"; allowed: a name without blanks, of 1..{} bytes, with {}", name,
                              kLongestName, text::kGivenNameWords));
    return name;
  }

  static void read_identifier(Fields& fields, dbc::Message& message) {
    message.extended = fields.flag("extended").value_or(false);
    if (fields.has("pgn")) {
      if (fields.has("identifier") || fields.has("extended"))
        fields.problem("pgn",
                       "found beside identifier or extended; allowed: a group (pgn), or an identifier");
      const std::int64_t group = fields.integer("pgn", 0, kHighestGroup).value_or(0);
      // Below 0xF000 the last byte is the destination, and no part of the group.
      const bool has_destination = (group & 0xFF00) < 0xF000;
      if (has_destination && (group & 0xFF) != 0)
        fields.problem("pgn", fmt::format("found 0x{:X}; allowed below 0xF000: one that ends in 00", group));
      message.extended = true;
      message.identifier = kDefaultPriority | static_cast<std::uint32_t>(group) << 8 |
                           (has_destination ? kAnyDestination : 0) | kAnySource;
      return;
    }
    fields.require("identifier",
                   "0..0x7FF, with extended = true 0..0x1FFFFFFF, or pgn = 0..0x3FFFF in its place");
    const std::int64_t most = message.extended ? can::kExtendedIdentifierMask : can::kStandardIdentifierMask;
    message.identifier = static_cast<std::uint32_t>(fields.integer("identifier", 0, most).value_or(0));
  }

  void read_signal(const Content& content) {
    const std::size_t before = problems_.size();
    Fields fields(content, "signal", problems_);
    fields.only({"message", "name", "start", "length", "big_endian", "kind", "unit", "factor", "offset",
                 "values", "chooses", "chosen_by"});
    fields.require("message", "the name of a [[message]]");
    fields.require("name", "a name without blanks, of 1..64 bytes");
    fields.require("start", "a bit, 0..14279: 0 is the lowest of byte 0, 8 the lowest of byte 1");
    fields.require("length", "1..64 bits");
    dbc::Signal signal;
    signal.name = given_name(fields);
    signal.start =
        static_cast<unsigned>(fields.integer("start", 0, 8 * dbc::kLongestMessage - 1).value_or(0));
    signal.length = static_cast<unsigned>(fields.integer("length", 1, 64).value_or(1));
    signal.little_endian = !fields.flag("big_endian").value_or(false);
    signal.unit = fields.text("unit", kLongestUnit).value_or("");
    read_number(fields, signal);
    signal.chooses = fields.flag("chooses").value_or(false);
    if (const auto chosen = fields.integer("chosen_by", 0, kHighestWord)) {
      const auto value = static_cast<std::uint64_t>(*chosen);
      signal.chosen_by = dbc::Choice{0, {{value, value}}};
    }
    for (profile::Meaning& meaning : fields.meanings("values", kHighestWord))
      signal.words.emplace_back(meaning.number, std::move(meaning.words));
    Entry* entry = find_message(fields);
    if (entry == nullptr) return;
    check_place(fields, entry->message, signal);
    if (problems_.size() != before) return;
    const Node* choice = content.find("chosen_by");
    entry->choices.push_back(choice == nullptr ? content.where() : choice->where);
    entry->message.signals.push_back(std::move(signal));
  }

  static void read_number(Fields& fields, dbc::Signal& signal) {
    using dbc::NumberKind;
    constexpr NumberKind kKinds[] = {NumberKind::unsigned_integer, NumberKind::signed_integer,
                                     NumberKind::float32, NumberKind::float64};
    if (const auto kind = fields.choice("kind", {"unsigned", "signed", "float32", "float64"}))
      signal.kind = kKinds[*kind];
    const unsigned bits = signal.kind == NumberKind::float32 ? 32 : 64;
    if (signal.kind >= NumberKind::float32 && signal.length != bits)
      fields.problem("length", fmt::format("found {}; allowed with this kind: {}", signal.length, bits));
    signal.factor = fields.number("factor").value_or(1.0);
    if (signal.factor == 0.0) fields.problem("factor", "found 0; allowed: a finite number other than 0");
    signal.offset = fields.number("offset").value_or(0.0);
  }

  /// The message that the signal is of; null: there is none, which is a problem.
  Entry* find_message(Fields& fields) {
    const std::string owner = fields.text("message", kLongestName).value_or("");
    const auto found = std::find_if(messages_.begin(), messages_.end(),
                                    [&](const Entry& one) { return one.message.name == owner; });
    if (found != messages_.end()) return &*found;
    if (fields.has("message"))
      fields.problem("message",
                     fmt::format("found \"{}\"; allowed: the name of a [[message]] that can be used", owner));
    return nullptr;
  }

  static void check_place(Fields& fields, const dbc::Message& message, const dbc::Signal& signal) {
    for (const dbc::Signal& one : message.signals) {
      if (one.name == signal.name)
        fields.problem(
            "name", fmt::format("found \"{}\" a second time in this message; allowed: each once", one.name));
      if (one.chooses && signal.chooses)
        fields.problem("chooses",
                       fmt::format("\"{}\" chooses already; allowed: one signal of a message", one.name));
    }
    if (!dbc::lies_in(signal, message.length))
      fields.problem("start", fmt::format("{} from bit {} on do not fit into the {} of the message",
                                          text::counted(signal.length, "bit"), signal.start,
                                          text::counted(message.length, "byte")));
  }

  /// Leaves out signals that no other signal of their message chooses. True: there was one, which may have
  /// chosen others.
  bool leave_out_unchosen() {
    for (Entry& entry : messages_) {
      std::vector<dbc::Signal>& signals = entry.message.signals;
      for (std::size_t i = 0; i < signals.size(); ++i) {
        if (!signals[i].chosen_by) continue;
        const std::string& name = signals[i].name;
        const bool found = std::any_of(signals.begin(), signals.end(), [&name](const dbc::Signal& one) {
          return one.chooses && one.name != name;
        });
        if (found) continue;
        problems_.push_back(
            {entry.choices[i], "signal.chosen_by",
             "no other signal of this message has chooses = true; allowed: below one that has"});
        signals.erase(signals.begin() + static_cast<std::ptrdiff_t>(i));
        entry.choices.erase(entry.choices.begin() + static_cast<std::ptrdiff_t>(i));
        return true;
      }
    }
    return false;
  }

  /// Where the signal that chooses is, which may come last.
  static void set_multiplexor(dbc::Message& message) {
    const auto chooses = [](const dbc::Signal& one) { return one.chooses; };
    const auto found = std::find_if(message.signals.begin(), message.signals.end(), chooses);
    if (found == message.signals.end()) return;
    for (dbc::Signal& signal : message.signals)
      if (signal.chosen_by)
        signal.chosen_by->multiplexor = static_cast<std::size_t>(found - message.signals.begin());
  }

  config::Document document_;
  std::vector<Entry> messages_;
  std::set<std::pair<std::uint32_t, bool>> identifiers_;
  std::vector<Problem> problems_;
};

}  // namespace

SignalTable read_signal_table(std::string_view toml, const std::string& file) {
  return Reader(toml, file).read();
}

}  // namespace signals
