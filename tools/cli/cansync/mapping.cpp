#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "cli/base/consent.h"
#include "cli/base/endings.h"
#include "cli/base/verb_groups.h"
#include "cli/cansync/leading_programs.h"
#include "cli/cansync/verbs.h"
#include "cli/text/column_help.h"
#include "text/counts.h"

namespace cansync::cli {
namespace {

constexpr std::size_t kWords = 4;  // of one telegram
constexpr std::string_view kReferences = "references";

/// The arguments as they were typed; empty: not given.
struct MapTexts {
  std::string target;
  std::string telegram;
  std::vector<std::string> words;
  Consent consent;
};

/// The mapping of the reference values, or of one slave's actual values, with their names.
struct Mapped {
  std::optional<unsigned> slave;  ///< nothing: reference values
  client::MappingBytes bytes{};
  ValueLookup lookup;
};

Mapped references_of(const client::MasterStatus& status) {
  return {std::nullopt, mapping_bytes(status.reference_mapping), value_lookup(status.reference_value)};
}

Mapped actuals_of(const client::SlaveStatus& slave) {
  return {slave.slave, mapping_bytes(slave.actual_mapping), value_lookup(slave.actual_value)};
}

/// Every mapping there is, or that of `target` alone.
std::vector<Mapped> find(Session& session, const std::string& target) {
  std::vector<Mapped> found;
  client::Client& client = session.client();
  if (target.empty() || target == kReferences) found.push_back(references_of(client.master_status()));
  if (target == kReferences) return found;
  const std::uint32_t wanted =
      session.configured_slaves(target.empty() ? std::vector<std::string>{} : std::vector{target});
  for (const client::SlaveStatus& slave : session.every_slave())
    if (((wanted >> slave.slave) & 1u) != 0) found.push_back(actuals_of(slave));
  return found;
}

/// The mapping with these words in one telegram, and in the other what is in force now.
client::MappingBytes with_words(Session& session, const Mapped& mapped, std::size_t telegram) {
  const std::vector<Mapped> now =
      find(session, mapped.slave ? fmt::format("{}", *mapped.slave) : std::string(kReferences));
  client::MappingBytes bytes = now.front().bytes;
  const auto first = static_cast<std::ptrdiff_t>(telegram * kWords);
  std::copy_n(mapped.bytes.begin() + first, kWords, bytes.begin() + first);
  return bytes;
}

std::string owner(const Mapped& mapped) {
  return mapped.slave ? fmt::format("slave {}", *mapped.slave) : std::string(kReferences);
}

JsonObject telegram_object(const Mapped& mapped, std::size_t telegram) {
  JsonArray words;
  JsonArray registers;
  for (std::size_t word = 0; word < kWords; ++word) {
    const std::uint8_t byte = mapped.bytes[telegram * kWords + word];
    words.add(format_mapping_word(byte));
    registers.add(byte);
  }
  JsonObject object;
  object.add("of", mapped.slave ? "slave" : kReferences);
  if (mapped.slave)
    object.add("slave", *mapped.slave);
  else
    object.add_null("slave");
  return object.add("telegram", telegram + 1).add("words", words).add("registers", registers);
}

std::vector<Table::Column> map_columns() {
  constexpr auto left = Table::Align::left;
  std::vector<Table::Column> columns{
      {"OF", left, "whose values: references, or a slave's actual values"},
      {"TELEGRAM", left, "WRC1 and WRC2 bring reference values, RDC1 and RDC2 actual values"}};
  for (std::size_t word = 0; word < kWords; ++word) {
    columns.push_back(
        {fmt::format("WORD {}", word), left,
         fmt::format("value and half in data bytes {} and {}; - = unused", 2 * word, 2 * word + 1)});
  }
  return columns;
}

ExitCode show(Session& session, const std::string& target) {
  Table table(map_columns());
  for (const Mapped& mapped : find(session, target)) {
    for (std::size_t telegram = 0; telegram < 2; ++telegram) {
      if (session.json()) {
        session.output().object(telegram_object(mapped, telegram));
        continue;
      }
      std::vector<std::string> cells{owner(mapped),
                                     fmt::format("{}{}", mapped.slave ? "RDC" : "WRC", telegram + 1)};
      for (std::size_t word = 0; word < kWords; ++word)
        cells.push_back(format_mapping_word(mapped.bytes[telegram * kWords + word]));
      table.add(std::move(cells));
    }
  }
  if (!session.json()) session.output().table(table);
  return ExitCode::done;
}

/// Asks before drives that a program leads get other values. Throws as `ask_consent` and `Session::client`.
void ask_before(Session& session, const MapTexts& texts) {
  if (texts.consent.yes || texts.target != kReferences) return;
  std::string writers;
  try {
    writers = leading_writers(session.client().master_status());
  } catch (const ArgumentsAreRight&) {  // a missing --yes is reported before the first line of a batch runs
  }
  if (writers.empty()) return;
  ask_consent(
      session, texts.consent,
      fmt::format("map references: the drives get other values in telegram {} from the next interval on; {}",
                  texts.telegram, writers));
}

ExitCode map_verb(Session& session, const MapTexts& texts) {
  if (texts.telegram.empty()) return show(session, texts.target);
  const auto telegram = static_cast<std::size_t>(parse_integer(texts.telegram, "TELEGRAM", 1, 2)) - 1;
  if (texts.words.empty() || texts.words.size() > kWords)
    throw UsageError(fmt::format("WORD: found {}; allowed: 1..4 (- for an unused one)",
                                 text::counted(texts.words.size(), "word")));
  session.hold_names();  // those of the values
  std::vector<Mapped> all = find(session, texts.target);
  std::vector<unsigned> slaves;
  for (Mapped& mapped : all) {
    slaves.push_back(mapped.slave.value_or(0));
    for (std::size_t word = 0; word < kWords; ++word)
      mapped.bytes[telegram * kWords + word] =
          word < texts.words.size() ? parse_mapping_word(texts.words[word], mapped.lookup) : std::uint8_t{0};
  }
  client::Client& client = session.client();
  ask_before(session, texts);
  return session.for_each(
      slaves,
      [&](std::size_t index) {
        Mapped& mapped = all[index];
        const client::CommandReply reply = session.ask(Effect::changes, [&] {
          mapped.bytes = with_words(session, mapped, telegram);
          return mapped.slave ? client.map_actuals(*mapped.slave, mapped.bytes)
                              : client.map_references(mapped.bytes);
        });
        return session.finish(reply, telegram_object(mapped, telegram), "map " + owner(mapped),
                              session.several() ? "the mapping of " + owner(mapped) + " is in effect"
                                                : "the mapping is in effect");
      },
      Session::Lines::grouped);
}

}  // namespace

void add_mapping_verb(CLI::App& app, Verb& chosen) {
  auto* map = app.add_subcommand("map", "which value stands in which word of a telegram");
  map->group(kValueVerbs);
  auto texts = std::make_shared<MapTexts>();
  map->add_option(
      "TARGET", texts->target,
      "references (telegrams WRC1, WRC2), or slaves, one or a list (RDC1, RDC2); alone: show their mapping");
  map->add_option("TELEGRAM", texts->telegram, "1 (values 0..3) or 2 (values 4..7)");
  map->add_option(
      "WORD", texts->words,
      "up to four: VALUE.low, VALUE.high, a register byte such as 0x0D, or -; VALUE is 0..7, value0..value7 "
      "or a configured name; words left out are unused");
  add_yes_option(*map, texts->consent.yes);
  map->footer(
      "Without arguments every mapping is shown.\n"
      "Master and slave may be mapped differently; nothing compares the two.\n"
      "Example: cansync map references 1 value0.low value0.high value1.low -\n" +
      columns_help(map_columns()));
  map->callback(
      [texts, &chosen] { chosen = [texts](Session& session) { return map_verb(session, *texts); }; });
}

}  // namespace cansync::cli
