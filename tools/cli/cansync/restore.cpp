#include <fmt/format.h>

#include <memory>

#include "cli/base/consent.h"
#include "cli/base/verb_groups.h"
#include "cli/cansync/passport_compare.h"
#include "cli/cansync/passport_source.h"
#include "cli/cansync/profiles.h"
#include "cli/cansync/verbs.h"
#include "cli/text/column_help.h"
#include "profile/scaling.h"
#include "text/counts.h"

namespace cansync::cli {
namespace {

/// The arguments as they were typed.
struct RestoreOptions {
  std::string slave;
  std::string file;
  std::string profile;
  bool dry_run = false;
  bool force = false;
  bool yes = false;
};

using Action = PlanStep::Action;

std::vector<Table::Column> plan_columns() {
  constexpr auto left = Table::Align::left;
  constexpr auto right = Table::Align::right;
  return {{"NUMBER", right, "parameter number"},
          {"NAME", left, "its name in the profile"},
          {"OLD", right, "the value that the slave holds"},
          {"NEW", right, "the value of the file"},
          {"UNIT", left, "of the values"},
          {"ACTION", left, "write or skip"},
          {"WHY", left, "why it is skipped"}};
}

/// One restore, once its plan is made.
class Restore {
 public:
  Restore(Session& session, unsigned slave, const std::string& file, const RestorePlan& plan, bool dry_run)
      : session_(session), slave_(slave), file_(file), plan_(plan), dry_run_(dry_run) {}

  ExitCode run() {
    client::Reply ended = {client::ReplyCode::done, ""};
    if (dry_run_) {
      for (const PlanStep& step : plan_.steps) {
        if (step.action != Action::right) show(step, step.action == Action::write ? "write" : "skip");
      }
      if (!session_.json()) session_.output().table(table_);
    } else {
      ended = write_all();
    }
    JsonObject object;
    object.add("slave", slave_)
        .add("file", file_)
        .add("dry_run", dry_run_)
        .add("written", written_)
        .add("to_write", plan_.count(Action::write))
        .add("right", plan_.count(Action::right))
        .add("skipped", plan_.count(Action::skip));
    return session_.finish(ended, object,
                           fmt::format("slave {}: stopped after {}", slave_,
                                       text::counted_of(written_, plan_.count(Action::write), "value")),
                           fmt::format("slave {}: {} {}, {} right already, {} skipped", slave_,
                                       plan_.count(Action::write), dry_run_ ? "to write" : "written",
                                       plan_.count(Action::right), plan_.count(Action::skip)));
  }

 private:
  client::Reply write_all() {
    for (const PlanStep& step : plan_.steps) {
      if (step.action == Action::skip && session_.json()) show(step, "skip");
      if (step.action != Action::write) continue;
      client::Reply reply =
          interrupt_flag().load() ? client::Reply{client::ReplyCode::cancelled, "cancelled"} : write(step);
      if (!reply.ok()) {
        const std::string_view reason =
            reply.reason.empty() ? client::name(reply.code) : std::string_view(reply.reason);
        reply.reason = fmt::format("{}: {}; give the same command again to go on",
                                   profile::label(*step.parameter), reason);
        if (session_.json()) show(step, "failed");
        return reply;
      }
      ++written_;
      show(step, "written");
    }
    return {client::ReplyCode::done, ""};
  }

  /// Writes one value and reads it back.
  client::Reply write(const PlanStep& step) {
    client::ParameterRequest request;
    request.write = true;
    request.slave = slave_;
    request.number = step.file->number;
    request.value = *step.file->raw;
    request.format = step.file->format == profile::Format::word ? client::ParameterFormat::word
                                                                : client::ParameterFormat::doubleword;
    request.timeout_ms = session_.monitoring_ms();
    const auto submit = [&] { return session_.client().submit(request); };
    if (auto reply = session_.ask(Effect::changes, submit); !reply.ok()) return reply;
    request.write = false;
    client::ParameterReply read = session_.ask(Effect::reads, submit);
    if (!read.ok() || read.value == request.value) return read;
    return {client::ReplyCode::slave_error,
            fmt::format("raw {} was written and taken, but the drive holds {}", request.value, read.value)};
  }

  static double scaled(const PlanStep& step, std::uint32_t raw) {
    return profile::scaled(*step.parameter, profile::raw_number(*step.parameter, raw));
  }

  void show(const PlanStep& step, std::string_view action) {
    const PassportEntry entry = step.file != nullptr ? *step.file : passport_entry(*step.parameter, {});
    const bool both = step.action == Action::write;
    const std::string old = both ? step.drive->value : "-";
    const std::string fresh = both ? step.file->value : "-";
    if (session_.json()) {
      JsonObject object;
      object.add("number", entry.number).add("name", entry.name).add("unit", entry.unit);
      if (both) {
        object.add("old", scaled(step, *step.drive->raw)).add("new", scaled(step, *step.file->raw));
        object.add("old_raw", *step.drive->raw).add("new_raw", *step.file->raw);
      } else {
        object.add_null("old").add_null("new").add_null("old_raw").add_null("new_raw");
      }
      object.add("action", action).add("why", step.why);
      if (session_.several()) object.add("slave", slave_);
      session_.output().object(object);
    } else if (dry_run_) {
      table_.add(
          {std::to_string(entry.number), entry.name, old, fresh, entry.unit, std::string(action), step.why});
    } else {
      session_.output().line(fmt::format("{} {}: {} -> {}{}{}, {}", entry.number, entry.name, old, fresh,
                                         entry.unit.empty() ? "" : " ", entry.unit, action));
    }
  }

  Session& session_;
  unsigned slave_;
  const std::string& file_;
  const RestorePlan& plan_;
  bool dry_run_;
  std::size_t written_ = 0;
  Table table_{plan_columns()};
};

/// Says every reason and ends with the code for it. Nothing was written.
ExitCode refuse(Session& session, const std::string& file, const std::vector<std::string>& reasons,
                std::string_view remedy) {
  for (const std::string& reason : reasons) session.output().remark(reason);
  session.output().remark(fmt::format("{}: nothing was written; {}", file, remedy));
  return ExitCode::refused;
}

ExitCode restore_one(Session& session, const RestoreOptions& options, unsigned slave, const std::string& path,
                     const Passport& file) {
  const SlaveProfile named = find_profile(session, slave, options.profile);
  if (named.profile == nullptr) throw std::runtime_error(named.problem);
  const ProfilePointer& profile = named.profile;
  if (!named.left_out.empty() && !options.force) {
    return refuse(session, path,
                  {fmt::format("profile '{}' was read in part; values of the parameters that are left "
                               "out would not be restored",
                               profile->name)},
                  "correct the profile, or give --force to restore the others");
  }
  const Passport drive = passport_of_slave(session, slave, options.profile);
  const std::vector<std::string> identity = identity_problems(file, drive);
  if (!identity.empty() && !options.force) {
    return refuse(session, path, identity,
                  "it is the passport of another drive; give --force to restore it to this one");
  }
  if (file.profile_hash != profile->hash) {
    session.output().remark(
        "the profile has changed since the backup; names, formats and limits are checked by the profile of "
        "now");
  }
  const RestorePlan plan = plan_restore(file, drive, *profile);
  if (!plan.problems.empty()) {
    return refuse(session, path, plan.problems, "every value has to be right before the first is written");
  }
  if (options.force && !options.dry_run) {
    ask_consent(
        session, {options.yes},
        fmt::format("restore --force: {} goes into slave {} whatever drive it was made of", path, slave));
  }
  return Restore(session, slave, path, plan, options.dry_run).run();
}

ExitCode restore_verb(Session& session, const RestoreOptions& options) {
  const SlaveFiles of = slave_files(session, options.slave, options.file, options.force);
  return session.for_each(
      of.slaves,
      [&](std::size_t index) {
        return restore_one(session, options, of.slaves[index], of.paths[index], of.passports[index]);
      },
      Session::Lines::failures_grouped);
}

}  // namespace

void add_restore_verb(CLI::App& app, Verb& chosen) {
  auto options = std::make_shared<RestoreOptions>();
  auto* restore = app.add_subcommand("restore", "write the values of a backup into a slave");
  restore->group(kSetVerbs);
  restore->add_option("SLAVE", options->slave, kSlavesHelp)->required();
  restore->add_option("FILE", options->file, kBackupFileHelp)->required();
  restore->add_flag("--dry-run", options->dry_run, "show what would be written, and write nothing");
  restore->add_flag(
      "--force", options->force,
      "also a file that was changed after it was written, or of another drive; is asked for on a "
      "terminal, needs --yes elsewhere");
  add_yes_option(*restore, options->yes);
  add_profile_option(*restore, options->profile);
  restore->footer(
      "Reads the slave first, writes only what differs, one parameter after the other by rising number, and "
      "reads\neach one back. Stops at the first that fails; given again, it goes on with what still "
      "differs.\n"
      "Exit code 3: refused, nothing was written. --dry-run shows a table:\n" +
      columns_help(plan_columns()));
  restore->callback([options, &chosen] {
    chosen = [options](Session& session) { return restore_verb(session, *options); };
  });
}

}  // namespace cansync::cli
