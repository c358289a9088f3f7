#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <ctime>
#include <functional>
#include <memory>
#include <optional>

#include "cli/base/files.h"
#include "cli/base/verb_groups.h"
#include "cli/cansync/passport_compare.h"
#include "cli/cansync/passport_source.h"
#include "cli/cansync/profiles.h"
#include "cli/cansync/verbs.h"
#include "cli/text/column_help.h"
#include "text/counts.h"

namespace cansync::cli {
namespace {

/// The arguments as they were typed.
struct PassportOptions {
  std::string slave;  ///< diff: the first argument
  std::string file;   ///< diff: the second argument
  std::string profile;
  bool time = false;
  bool with_volatile = false;
  bool force = false;
};

std::string now_text() {
  const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  std::tm utc = {};
  gmtime_r(&now, &utc);
  char text[32] = {};
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text;
}

ExitCode backup_one(Session& session, const PassportOptions& options, unsigned slave,
                    const profile::Profile& profile, const std::string& file) {
  const bool to_output = file == "-";
  std::optional<ReplacementFile> target;
  if (!to_output) target.emplace(file);
  TakenPassport taken = take_passport(session, slave, profile, options.with_volatile);
  client::Reply ended = taken.ended;
  if (ended.ok()) {
    if (options.time) taken.passport.taken = now_text();
    const std::string text = passport_text(taken.passport);
    if (to_output) {
      session.output().bytes(text);
    } else {
      const std::string kept =
          target->commit_and_keep({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
      if (!kept.empty())
        session.output().remark(fmt::format("{} had other contents; they are in {}", file, kept));
    }
    for (const std::string& unread : taken.unread) {
      session.output().remark(fmt::format("slave {}, {}", slave, unread));
    }
    if (!taken.unread.empty()) {
      ended.code = client::ReplyCode::slave_error;
      ended.reason = fmt::format("{} no value in the file",
                                 text::counted(taken.unread.size(), "parameter could not be read and has",
                                               "parameters could not be read and have"));
    }
  }
  JsonObject object;
  object.add("slave", slave)
      .add("profile", profile.name)
      .add("file", file)
      .add("parameters", taken.passport.entries.size())
      .add("unread", taken.unread.size());
  return session.finish(
      ended, object, fmt::format("slave {}", slave),
      fmt::format("slave {}: {} in {}", slave, text::counted(taken.passport.entries.size(), "parameter"),
                  to_output ? "standard output" : file));
}

ExitCode backup_verb(Session& session, const PassportOptions& options) {
  if (options.file == "-" && session.json()) {
    throw UsageError("FILE: found '-' with --json; allowed: a file, both go to standard output");
  }
  const std::vector<unsigned> slaves = session.slaves(options.slave);
  const std::vector<std::string> files = session.files(options.file, slaves);
  // Of a slave without a profile nothing can be read; the others are not to go without a backup for it.
  return session.for_each(
      slaves,
      [&](std::size_t index) {
        const ProfilePointer profile = need_profile(session, slaves[index], options.profile);
        return backup_one(session, options, slaves[index], *profile, files[index]);
      },
      Session::Lines::failures_grouped);
}

/// A number when it is one: a file that was changed by force may hold any word.
void add_value(JsonObject& object, std::string_view key, const PassportEntry* entry) {
  double number = 0.0;
  if (entry == nullptr || !entry->raw) {
    object.add_null(key);
    return;
  }
  const char* end = entry->value.data() + entry->value.size();
  const auto [stop, error] = std::from_chars(entry->value.data(), end, number);
  if (error == std::errc{} && stop == end) {
    object.add(key, number);
  } else {
    object.add(key, entry->value);
  }
}

void add_raw(JsonObject& object, std::string_view key, const PassportEntry* entry) {
  if (entry != nullptr && entry->raw) {
    object.add(key, *entry->raw);
  } else {
    object.add_null(key);
  }
}

std::string_view access_of(const PassportEntry& entry) {
  return entry.read_only ? "read-only" : "read-write";
}

std::vector<Table::Column> difference_columns(const std::string& a, const std::string& b, std::string of_a,
                                              std::string of_b) {
  constexpr auto left = Table::Align::left;
  constexpr auto right = Table::Align::right;
  return {{"NUMBER", right, "parameter number"}, {"NAME", left, "its name in the profile"},
          {a, right, std::move(of_a)},           {b, right, std::move(of_b)},
          {"UNIT", left, "of the values"},       {"ACCESS", left, "read-write or read-only"}};
}

std::vector<Table::Column> diff_columns() {
  return difference_columns("A", "B", "value in A; missing = no such parameter, - = without a value",
                            "value in B, likewise");
}

std::vector<Table::Column> verify_columns() {
  return difference_columns("FILE", "DRIVE",
                            "value in the file; missing = no such parameter, - = without a value",
                            "value that the slave holds, likewise");
}

/// `slave`: told with each object when there are several.
void show_differences(Session& session, const std::vector<Difference>& found, Table table,
                      std::optional<unsigned> slave = std::nullopt) {
  const auto text = [](const PassportEntry* entry) {
    return entry == nullptr ? std::string("missing") : entry->raw ? entry->value : std::string("-");
  };
  for (const Difference& difference : found) {
    const PassportEntry& entry = difference.any();
    if (!session.json()) {
      table.add({std::to_string(entry.number), entry.name, text(difference.a), text(difference.b), entry.unit,
                 std::string(access_of(entry))});
      continue;
    }
    JsonObject object;
    object.add("number", entry.number).add("name", entry.name).add("unit", entry.unit);
    add_value(object, "a", difference.a);
    add_value(object, "b", difference.b);
    add_raw(object, "a_raw", difference.a);
    add_raw(object, "b_raw", difference.b);
    object.add("access", access_of(entry));
    if (slave && session.several()) object.add("slave", *slave);
    session.output().object(object);
  }
  if (!session.json() && !found.empty()) session.output().table(table);
}

ExitCode diff_verb(Session& session, const PassportOptions& options) {
  const auto passport_of = [&](const std::string& argument) {
    if (is_file_argument(argument)) return passport_of_file(session.output(), argument, options.force);
    return passport_of_slave(session, session.slave(argument), options.profile);
  };
  const Passport a = passport_of(options.slave);
  const Passport b = passport_of(options.file);
  if (a.profile != b.profile) {
    session.output().remark(
        fmt::format("profiles differ: {}, {}; parameters are compared by number", a.profile, b.profile));
  }
  const std::vector<Difference> found = differences(a, b);
  show_differences(session, found, Table(diff_columns()));
  return found.empty() ? ExitCode::done : ExitCode::different;
}

ExitCode verify_one(Session& session, const std::string& profile, unsigned slave, const std::string& path,
                    const Passport& file) {
  const Passport drive = passport_of_slave(session, slave, profile);
  const std::vector<std::string> identity = identity_problems(file, drive);
  for (const std::string& problem : identity) session.output().remark(problem);
  const std::vector<Difference> found = differences(file, drive);
  show_differences(session, found, Table(verify_columns()), slave);
  const auto compared =
      static_cast<std::size_t>(std::count_if(file.entries.begin(), file.entries.end(), is_compared));
  JsonObject object;
  JsonArray problems;
  for (const std::string& problem : identity) problems.add(problem);
  object.add("slave", slave)
      .add("file", path)
      .add("compared", compared)
      .add("different", found.size())
      .add("identity", problems);
  const bool same = identity.empty() && found.empty();
  const ExitCode code = session.finish(
      {client::ReplyCode::done, ""}, object, "",
      same ? fmt::format("slave {} holds all {} of {}", slave, text::counted(compared, "value"), path)
           : fmt::format("slave {} differs from {}: {}, {}", slave, path,
                         text::counted_of(found.size(), compared, "value"),
                         text::counted(identity.size(), "mark of identity", "marks of identity")));
  return same ? code : ExitCode::different;
}

ExitCode verify_verb(Session& session, const PassportOptions& options) {
  const SlaveFiles of = slave_files(session, options.slave, options.file, options.force);
  return session.for_each(
      of.slaves,
      [&](std::size_t index) {
        return verify_one(session, options.profile, of.slaves[index], of.paths[index], of.passports[index]);
      },
      Session::Lines::grouped);
}

CLI::App* add_verb(CLI::App& app, Verb& chosen, const char* name, const char* text,
                   ExitCode (*run)(Session&, const PassportOptions&),
                   const std::shared_ptr<PassportOptions>& options) {
  auto* verb = app.add_subcommand(name, text);
  verb->group(kSetVerbs);
  add_profile_option(*verb, options->profile);
  verb->callback([run, options, &chosen] {
    chosen = [run, options](Session& session) { return run(session, *options); };
  });
  return verb;
}

constexpr const char* kForceHelp = "use a file that was changed after it was written";

}  // namespace

void add_passport_verbs(CLI::App& app, Verb& chosen) {
  auto backup_options = std::make_shared<PassportOptions>();
  auto* backup = add_verb(app, chosen, "backup", "write the parameters of a slave into a file", backup_verb,
                          backup_options);
  backup->add_option("SLAVE", backup_options->slave, kSlavesHelp)->required();
  backup
      ->add_option(
          "FILE", backup_options->file,
          "file, replaced when everything is read; - = standard output; for several slaves a name with "
          "{slave} or {name} in it")
      ->required();
  backup->add_flag("--time", backup_options->time, "write down the time too");
  backup->add_flag("--volatile", backup_options->with_volatile, "with the values of volatile parameters");
  backup->footer("Needs a drive profile. docs/passport.md describes the file.");

  auto diff_options = std::make_shared<PassportOptions>();
  auto* diff = add_verb(app, chosen, "diff", "what the parameters of two drives or files have different",
                        diff_verb, diff_options);
  diff->add_option("A", diff_options->slave, "a slave's number or name, or the file of a backup")->required();
  diff->add_option("B", diff_options->file, "likewise; what has a / or . in it, or is there, is a file")
      ->required();
  diff->add_flag("--force", diff_options->force, kForceHelp);
  diff->footer(
      "Equal: nothing, and exit code 0; different: exit code 9. Volatile parameters, and those with "
      "identity\n"
      "\"unit\" (serial numbers), are not compared.\n" +
      columns_help(diff_columns()));

  auto verify_options = std::make_shared<PassportOptions>();
  auto* verify = add_verb(app, chosen, "verify", "whether a slave holds the values of a file", verify_verb,
                          verify_options);
  verify->add_option("SLAVE", verify_options->slave, kSlavesHelp)->required();
  verify->add_option("FILE", verify_options->file, kBackupFileHelp)->required();
  verify->add_flag("--force", verify_options->force, kForceHelp);
  verify->footer(
      "Exit code 0 when it does, else 9. Checks the file's checksum, the identity of the drive and every "
      "value.\n" +
      columns_help(verify_columns()));
}

}  // namespace cansync::cli
