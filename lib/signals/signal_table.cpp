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
constexpr std::uint32_t kDefaultPriority = 6U << 26;

class Reader {
 public:
  explicit Reader(std::string_view toml, const std::string& file)
      : document_(config::parse_document(toml, file, kWording)) {}

  std::variant<dbc::Database, std::vector<Problem>> read() {
    problems_ = document_.problems;
    const Content root(document_, nullptr);
    for (const Node* node : root.nodes()) {
      if (node->kind != Node::Kind::sections || (node->name() != "message" && node->name() != "signal"))
        problems_.push_back(
            {node->key, node->name(), "no section of a table of signals; allowed: [[message]], [[signal]]"});
    }
    for (const Node* section : root.each("message")) read_message(Content(document_, section));
    for (const Node* section : root.each("signal")) read_signal(Content(document_, section));
    if (!problems_.empty()) {
      config::sort_by_place(problems_);
      return std::move(problems_);
    }
    return dbc::Database(std::move(messages_));
  }

 private:
  void read_message(const Content& content) {
    Fields fields(content, "message", problems_);
    fields.only({"name", "identifier", "pgn", "extended", "length"});
    fields.require("name", "a name without blanks, of 1..64 bytes");
    dbc::Message message;
    message.name = fields.word("name", kLongestName).value_or("");
    message.length = static_cast<unsigned>(fields.integer("length", 0, dbc::kLongestMessage).value_or(8));
    read_identifier(fields, message);
    const bool fresh = identifiers_.emplace(message.identifier, message.extended).second;
    if (!fresh)
      fields.problem(fields.has("pgn") ? "pgn" : "identifier",
                     "an earlier message has the same; allowed: each once");
    const auto same = std::find_if(messages_.begin(), messages_.end(),
                                   [&](const dbc::Message& one) { return one.name == message.name; });
    if (same != messages_.end())
      fields.problem("name", fmt::format("found \"{}\" a second time; allowed: each once", message.name));
    messages_.push_back(std::move(message));
  }

  static void read_identifier(Fields& fields, dbc::Message& message) {
    message.extended = fields.flag("extended").value_or(false);
    if (fields.has("pgn")) {
      if (fields.has("identifier") || fields.has("extended"))
        fields.problem("pgn",
                       "found beside identifier or extended; allowed: a group (pgn), or an identifier");
      const std::int64_t group = fields.integer("pgn", 0, kHighestGroup).value_or(0);
      // Below 0xF000 the last byte is the destination, and no part of the group.
      if ((group & 0xFF00) < 0xF000 && (group & 0xFF) != 0)
        fields.problem("pgn", fmt::format("found 0x{:X}; allowed below 0xF000: one that ends in 00", group));
      message.extended = true;
      message.identifier = kDefaultPriority | static_cast<std::uint32_t>(group) << 8 | kAnySource;
      return;
    }
    fields.require("identifier",
                   "0..0x7FF, with extended = true 0..0x1FFFFFFF, or pgn = 0..0x3FFFF in its place");
    const std::int64_t most = message.extended ? can::kExtendedIdentifierMask : can::kStandardIdentifierMask;
    message.identifier = static_cast<std::uint32_t>(fields.integer("identifier", 0, most).value_or(0));
  }

  void read_signal(const Content& content) {
    Fields fields(content, "signal", problems_);
    fields.only({"message", "name", "start", "length", "big_endian", "kind", "unit", "factor", "offset",
                 "values", "chooses", "chosen_by"});
    fields.require("message", "the name of a [[message]]");
    fields.require("name", "a name without blanks, of 1..64 bytes");
    fields.require("start", "a bit, 0..14279: 0 is the lowest of byte 0, 8 the lowest of byte 1");
    fields.require("length", "1..64 bits");
    dbc::Signal signal;
    signal.name = fields.word("name", kLongestName).value_or("");
    signal.start =
        static_cast<unsigned>(fields.integer("start", 0, 8 * dbc::kLongestMessage - 1).value_or(0));
    signal.length = static_cast<unsigned>(fields.integer("length", 1, 64).value_or(1));
    signal.little_endian = !fields.flag("big_endian").value_or(false);
    signal.unit = fields.text("unit", kLongestUnit).value_or("");
    read_number(fields, signal);
    signal.chooses = fields.flag("chooses").value_or(false);
    if (const auto chosen = fields.integer("chosen_by", 0, kHighestWord))
      signal.chosen_by = static_cast<std::uint64_t>(*chosen);
    for (profile::Meaning& meaning : fields.meanings("values", kHighestWord))
      signal.words.emplace_back(meaning.number, std::move(meaning.words));
    add(fields, std::move(signal));
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

  void add(Fields& fields, dbc::Signal signal) {
    const std::string owner = fields.text("message", kLongestName).value_or("");
    const auto message = std::find_if(messages_.begin(), messages_.end(),
                                      [&](const dbc::Message& one) { return one.name == owner; });
    if (message == messages_.end()) {
      if (fields.has("message"))
        fields.problem("message", fmt::format("found \"{}\"; allowed: the name of a [[message]]", owner));
      return;
    }
    for (const dbc::Signal& one : message->signals) {
      if (one.name == signal.name)
        fields.problem(
            "name", fmt::format("found \"{}\" a second time in this message; allowed: each once", one.name));
      if (one.chooses && signal.chooses)
        fields.problem("chooses",
                       fmt::format("\"{}\" chooses already; allowed: one signal of a message", one.name));
    }
    const std::vector<std::uint8_t> data(message->length);
    if (!dbc::raw_bits(signal, data))
      fields.problem("start", fmt::format("{} from bit {} on do not fit into the {} of the message",
                                          text::counted(signal.length, "bit"), signal.start,
                                          text::counted(message->length, "byte")));
    message->signals.push_back(std::move(signal));
  }

  config::Document document_;
  std::vector<dbc::Message> messages_;
  std::set<std::pair<std::uint32_t, bool>> identifiers_;
  std::vector<Problem> problems_;
};

}  // namespace

std::variant<dbc::Database, std::vector<config::Problem>> read_signal_table(std::string_view toml,
                                                                            const std::string& file) {
  return Reader(toml, file).read();
}

}  // namespace signals
