#include <fmt/format.h>

#include <memory>

#include "cli/base/verb_groups.h"
#include "cli/cansync/verbs.h"
#include "cli/text/column_help.h"

namespace cansync::cli {
namespace {

/// The arguments as they were typed; empty: not given.
struct PollTexts {
  std::vector<std::string> pairs;  ///< CHANNEL WHO CHANNEL WHO
  std::string maximum;
  std::string control_word;
  std::string parameter;
  std::string transfer;
};

std::int32_t parse_cursor(Session& session, std::string_view text) {
  if (text == "auto" || text == "automatic") return client::kAutomatic;
  if (text == "nobody") return client::kNobody;
  return static_cast<std::int32_t>(session.slave(text));
}

std::int32_t parse_optional_cursor(Session& session, const std::string& text) {
  return text.empty() ? client::kUnchanged : parse_cursor(session, text);
}

client::Polling parse_polling(Session& session, const PollTexts& texts) {
  if (texts.pairs.size() % 2 != 0)
    throw UsageError(
        fmt::format("poll: found '{}' without a slave; allowed: pairs of CHANNEL (1 or 2) and SLAVE, auto or "
                    "nobody, such as 1 auto 2 nobody",
                    texts.pairs.back()));
  client::Polling polling;
  for (std::size_t i = 0; i < texts.pairs.size(); i += 2) {
    const bool one = parse_integer(texts.pairs[i], "CHANNEL", 1, 2) == 1;
    (one ? polling.one : polling.two) = parse_cursor(session, texts.pairs[i + 1]);
  }
  if (!texts.maximum.empty()) polling.maximum_slave = static_cast<std::int32_t>(session.slave(texts.maximum));
  return polling;
}

JsonObject& add_cursor(JsonObject& object, std::string_view key, std::int32_t code) {
  if (code == client::kAutomatic) return object.add(key, "auto");
  if (code == client::kNobody) return object.add(key, "nobody");
  return object.add(key, code);
}

std::vector<Table::Column> poll_columns() {
  constexpr auto left = Table::Align::left;
  return {
      {"WHAT", left,
       "what is asked for or served: the actual values of either channel, the highest number of automatic "
       "asking, control words, parameter jobs, transfers"},
      {"WHO", left,
       "a slave, automatic (the number rises by one each interval) or nobody; in the last line how the "
       "daemon serves jobs"}};
}

ExitCode show(Session& session) {
  const client::MasterStatus status = session.client().master_status();
  if (session.json()) {
    JsonObject object;
    add_cursor(object, "channel_1", status.polling_one);
    add_cursor(object, "channel_2", status.polling_two);
    object.add("maximum_slave", status.maximum_slave);
    add_cursor(object, "control_word", status.cursor_control_word);
    add_cursor(object, "parameter", status.cursor_parameter);
    add_cursor(object, "transfer", status.cursor_transfer);
    session.output().object(object.add("serving", status.serving));
    return ExitCode::done;
  }
  Table table(poll_columns());
  table.add({"channel 1 (WRC1 asks for RDC1)", cursor_text(status.polling_one)});
  table.add({"channel 2 (WRC2 asks for RDC2)", cursor_text(status.polling_two)});
  table.add({"maximum slave", fmt::format("{}", status.maximum_slave)});
  table.add({"control words", cursor_text(status.cursor_control_word)});
  table.add({"parameter jobs", cursor_text(status.cursor_parameter)});
  table.add({"transfers", cursor_text(status.cursor_transfer)});
  table.add({"jobs are served", status.serving});
  session.output().table(table);
  return ExitCode::done;
}

ExitCode poll_verb(Session& session, const PollTexts& texts) {
  const bool polls = !texts.pairs.empty() || !texts.maximum.empty();
  const bool cursors = !(texts.control_word.empty() && texts.parameter.empty() && texts.transfer.empty());
  if (!polls && !cursors) return show(session);
  // Everything is read before the first command is sent, so that a wrong argument changes nothing.
  const client::Polling polling = parse_polling(session, texts);
  const client::Cursors channel{parse_optional_cursor(session, texts.control_word),
                                parse_optional_cursor(session, texts.parameter),
                                parse_optional_cursor(session, texts.transfer)};
  client::CommandReply reply{client::ReplyCode::done, ""};
  if (polls) reply = session.ask(Effect::changes, [&] { return session.client().polling(polling); });
  if (cursors && reply.ok())
    reply = session.ask(Effect::changes, [&] { return session.client().cursors(channel); });
  return session.finish(reply, JsonObject(), "poll", "the change is in effect");
}

}  // namespace

void add_polling_verb(CLI::App& app, Verb& chosen) {
  auto* poll =
      app.add_subcommand("poll", "which slave is asked for actual values, and whose jobs are served");
  poll->group(kValueVerbs);
  auto texts = std::make_shared<PollTexts>();
  poll->add_option(
      "CHANNEL WHO", texts->pairs,
      "pairs of 1 or 2 and a slave, auto (the number rises by one each interval) or nobody; without any "
      "argument the present setting is shown");
  poll->add_option("--maximum", texts->maximum, "slave number up to which automatic ones rise")
      ->type_name("SLAVE");
  poll->add_option("--control-word", texts->control_word,
                   "whose control words are sent: SLAVE, auto or nobody")
      ->type_name("WHO");
  poll->add_option("--parameter", texts->parameter, "whose parameter jobs are served")->type_name("WHO");
  poll->add_option("--transfer", texts->transfer, "whose uploads and downloads are served")->type_name("WHO");
  poll->footer("Example: cansync poll 1 auto 2 nobody --maximum 3\n" + columns_help(poll_columns()));
  poll->callback(
      [texts, &chosen] { chosen = [texts](Session& session) { return poll_verb(session, *texts); }; });
}

}  // namespace cansync::cli
