#include <fmt/format.h>

#include <bit>
#include <memory>

#include "cli/base/consent.h"
#include "cli/base/verb_groups.h"
#include "cli/cansync/leading_programs.h"
#include "cli/cansync/reference_effect.h"
#include "cli/cansync/verbs.h"

namespace cansync::cli {
namespace {

/// The arguments of `control` as they were typed.
struct ControlTexts {
  std::string slave;
  std::string word;
};

/// The arguments of `broadcast` as they were typed.
struct BroadcastTexts {
  std::string slaves;
  std::string priority = "2";
  std::string command;
  std::string byte = "0";
  std::string word = "0";
  Consent consent;
};

/// The arguments of `mode` as they were typed.
struct ModeTexts {
  std::string mode;
  bool force = false;
  Consent consent;
};

/// The arguments of `release` as they were typed.
struct ReleaseTexts {
  std::string slave;
  bool force = false;
};

ExitCode release_verb(Session& session, const ReleaseTexts& texts) {
  const std::vector<unsigned> slaves = session.slaves(texts.slave);
  return session.for_each(
      slaves,
      [&](std::size_t index) {
        const unsigned slave = slaves[index];
        const client::CommandReply reply =
            session.ask(Effect::changes, [&] { return session.client().release(slave, texts.force); });
        const std::string where = fmt::format("release of slave {}", slave);
        return session.finish(
            reply, JsonObject().add("slave", slave).add("force", texts.force), where,
            texts.force ? where + " is in effect" : where + " has begun; `cansync slaves` shows how it ends");
      },
      Session::Lines::grouped);
}

ExitCode control_verb(Session& session, const ControlTexts& texts) {
  const std::uint32_t word = parse_raw(texts.word, "WORD", Width::word);
  const std::vector<unsigned> slaves = session.slaves(texts.slave);
  return session.for_each(
      slaves,
      [&](std::size_t index) {
        const unsigned slave = slaves[index];
        const client::CommandReply reply = session.ask(Effect::changes, [&] {
          return session.client().control_word(slave, word, session.monitoring_ms());
        });
        const std::string where = fmt::format("control word 0x{:04X} to slave {}", word, slave);
        return session.finish(reply, JsonObject().add("slave", slave).add("control_word", word), where,
                              where + " sent");
      },
      Session::Lines::grouped);
}

/// What `--dry-run` says of `what`, and of the line it would reach.
ExitCode say_only(Session& session, std::string_view what) {
  session.output().remark(fmt::format("{} would be sent; {}; nothing was sent", what, reached_line(session)));
  return ExitCode::done;
}

/// "all" are all that are on the bus, also those nobody has configured: every bit of the mask (M 4.2).
/// Also those that nobody has configured.
constexpr std::uint32_t kEverybody = 0xFFFFFFFF;

std::uint32_t parse_slaves(Session& session, const std::string& text) {
  if (text.starts_with("0x") || text.starts_with("0X")) return parse_slave_mask(text);
  return session.slave_mask(text);
}

ExitCode broadcast_verb(Session& session, const BroadcastTexts& texts) {
  client::Broadcast broadcast;
  broadcast.priority = static_cast<std::uint32_t>(parse_integer(texts.priority, "--priority", 0, 2));
  broadcast.action = static_cast<std::uint32_t>(parse_integer(texts.command, "--command", 0, 255));
  broadcast.data_byte = static_cast<std::uint32_t>(parse_integer(texts.byte, "--byte", 0, 255));
  broadcast.data_word = parse_raw(texts.word, "--word", Width::word);
  broadcast.slave_mask = parse_slaves(session, texts.slaves);
  broadcast.timeout_ms = session.monitoring_ms();
  const bool everybody = broadcast.slave_mask == kEverybody;
  const std::string where = fmt::format("broadcast of command {} to {}", broadcast.action,
                                        everybody ? "every slave on the bus, configured or not"
                                                  : "slaves " + format_slave_set(broadcast.slave_mask));
  if (texts.consent.dry_run) return say_only(session, where);
  if (std::popcount(broadcast.slave_mask) > 1) ask_consent(session, texts.consent, where);
  const client::CommandReply reply =
      session.ask(Effect::changes, [&] { return session.client().broadcast(broadcast); });
  JsonObject object;
  object.add("slave_mask", broadcast.slave_mask)
      .add("priority", broadcast.priority)
      .add("command", broadcast.action)
      .add("byte", broadcast.data_byte)
      .add("word", broadcast.data_word);
  return session.finish(reply, object, where, where + " sent");
}

client::Mode parse_mode(std::string_view text) {
  if (text == "setup") return client::Mode::setup;
  if (text == "run") return client::Mode::run;
  if (text == "stop") return client::Mode::stop;
  if (text == "reset-can") return client::Mode::reset_can;
  if (text == "restart") return client::Mode::restart;
  throw UsageError(fmt::format("MODE: found '{}'; allowed: setup, run, stop, reset-can, restart", text));
}

/// What a mode ends on the bus; empty: nothing.
std::string_view effect_of(client::Mode mode) {
  switch (mode) {
    case client::Mode::setup:
      return "mode setup: reference values are no longer sent";
    case client::Mode::run:
      return "";
    case client::Mode::stop:
      return "mode stop: SYNC and all telegrams end, and open jobs";
    case client::Mode::reset_can:
      return "mode reset-can: the CAN controller is reset, and SYNC and all telegrams pause";
    case client::Mode::restart:
      return "mode restart: the line stops, and is set up anew";
  }
  return "";
}

/// The programs whose drives the mode would leave without SYNC or reference values; empty: none. Throws as `Session::client`.
std::string programs_cut_off(Session& session, client::Mode mode) {
  const client::MasterStatus status = session.client().master_status();
  if (mode == client::Mode::setup && status.option_status != kActiveMaster) return "";
  return leading_programs(status);
}

/// Asks before drives lose SYNC or reference values. Throws as `ask_consent` and `Session::client`.
void ask_before(Session& session, const Consent& consent, client::Mode mode) {
  const std::string_view effect = effect_of(mode);
  if (consent.yes || effect.empty()) return;
  std::string programs;
  try {
    programs = programs_cut_off(session, mode);
  } catch (const ArgumentsAreRight&) {  // a missing --yes is reported before the first line of a batch runs
  }
  if (!programs.empty()) {
    ask_consent(session, consent, fmt::format("{}; {}", effect, programs));
  } else if (mode == client::Mode::restart) {
    ask_consent(session, consent, effect);
  } else if (mode == client::Mode::stop) {
    // A script that stops a line without a leading program must not fail because no person is there to be asked.
    ask_consent(session, consent, effect, Unasked::done);
  }
}

ExitCode mode_verb(Session& session, const ModeTexts& texts) {
  const client::Mode mode = parse_mode(texts.mode);
  if (texts.force && mode != client::Mode::run && mode != client::Mode::setup)
    throw UsageError("--force: only `mode run` and `mode setup` take it");
  const std::string where = "mode " + texts.mode;
  if (texts.consent.dry_run) return say_only(session, where);
  ask_before(session, texts.consent, mode);
  const client::CommandReply reply =
      session.ask(Effect::changes, [&] { return session.client().mode(mode, texts.force); });
  return session.finish(reply, JsonObject().add("mode", texts.mode).add("force", texts.force), where,
                        where + " is in effect");
}

void add_control(CLI::App& app, Verb& chosen) {
  auto* control = app.add_subcommand("control", "send a control word to a slave");
  control->group(kCommandVerbs);
  auto texts = std::make_shared<ControlTexts>();
  control->add_option("SLAVE", texts->slave, kSlavesHelp)->required();
  control->add_option("WORD", texts->word, "control word, 0..65535, also 0x.. or negative")->required();
  control->footer(
      "Done means that it was on the bus: a slave does not answer a control word. One that stops goes first; "
      "a newer\none of the same slave replaces one that waits.");
  control->callback(
      [texts, &chosen] { chosen = [texts](Session& session) { return control_verb(session, *texts); }; });
}

void add_release(CLI::App& app, Verb& chosen) {
  auto* release = app.add_subcommand("release", "let a slave that was away and is held out be used again");
  release->group(kCommandVerbs);
  auto texts = std::make_shared<ReleaseTexts>();
  release->add_option("SLAVE", texts->slave, kSlavesHelp)->required();
  release->add_flag("--force", texts->force,
                    "as it is: without reading who it is, and without its return parameters");
  release->footer(
      "The master reads again who the drive is (option expect) and goes through its return parameters, and "
      "releases it when they are right;\nwith --force it is released immediately. One that is not synchronized is told to synchronize "
      "again.");
  release->callback(
      [texts, &chosen] { chosen = [texts](Session& session) { return release_verb(session, *texts); }; });
}

void add_broadcast(CLI::App& app, Verb& chosen) {
  auto* broadcast = app.add_subcommand("broadcast", "send an action command to a group of slaves");
  broadcast->group(kCommandVerbs);
  auto texts = std::make_shared<BroadcastTexts>();
  broadcast
      ->add_option("--slaves", texts->slaves,
                   "mask (0x0000000F), list (0,4-7,winder), or all = every configured slave")
      ->type_name("SET")
      ->required();
  broadcast->add_option("--command", texts->command, "1 = control word in --word; 128..255 free for the user")
      ->type_name("N")
      ->required();
  broadcast->add_option("--byte", texts->byte, "data byte 0..255 (default 0)")->type_name("N");
  broadcast->add_option("--word", texts->word, "data word 0..65535, also 0x.. or negative (default 0)")
      ->type_name("N");
  broadcast->add_option("--priority", texts->priority, "0 = before everything else, 1, or 2 (default)")
      ->type_name("0|1|2");
  add_consent_options(*broadcast, texts->consent);
  broadcast->footer(
      "Done means that it was on the bus: slaves do not answer an action command.\n"
      "One to several slaves is asked for on a terminal.");
  broadcast->callback(
      [texts, &chosen] { chosen = [texts](Session& session) { return broadcast_verb(session, *texts); }; });
}

void add_mode(CLI::App& app, Verb& chosen) {
  auto* mode = app.add_subcommand("mode", "change the master's operating state");
  mode->group(kCommandVerbs);
  auto texts = std::make_shared<ModeTexts>();
  mode->add_option("MODE", texts->mode, "the operating state, or what is to be done")
      ->type_name("setup|run|stop|reset-can|restart")
      ->required();
  mode->add_flag("--force", texts->force,
                 "run: also when slaves are missing; setup: also while another master sends");
  add_consent_options(*mode, texts->consent);
  mode->footer(
      "On a terminal, `stop` and `restart` ask first; in a script, `restart` needs --yes. While a program gives "
      "reference values,\n`stop`, `restart`, `reset-can` and `setup` name that program, ask on a terminal, and need --yes elsewhere.\n"
      "Modes:\n"
      "  setup      SYNC runs, slaves are activated and their status is read; no reference values\n"
      "  run        reference and actual values are exchanged\n"
      "  stop       no SYNC, no telegrams; open jobs end\n"
      "  reset-can  reset the CAN controller (leaves bus-off)\n"
      "  restart    cold restart of the master");
  mode->callback(
      [texts, &chosen] { chosen = [texts](Session& session) { return mode_verb(session, *texts); }; });
}

}  // namespace

void add_command_verbs(CLI::App& app, Verb& chosen) {
  add_control(app, chosen);
  add_broadcast(app, chosen);
  add_mode(app, chosen);
  add_release(app, chosen);
}

}  // namespace cansync::cli
