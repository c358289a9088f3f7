#include <fmt/format.h>

#include <memory>

#include "cli/base/verb_groups.h"
#include "cli/cansync/parameter_reader.h"
#include "cli/cansync/profiles.h"
#include "cli/cansync/verbs.h"
#include "cli/text/column_help.h"
#include "cli/text/values.h"
#include "profile/meaning.h"
#include "profile/scaling.h"

namespace cansync::cli {
namespace {

/// The arguments as they were typed.
struct ParamsOptions {
  std::string slave;
  std::string profile;
  std::string group;
  bool raw = false;
};

std::vector<Table::Column> parameter_columns() {
  constexpr auto left = Table::Align::left;
  constexpr auto right = Table::Align::right;
  return {
      {"NUMBER", right, "parameter number"},
      {"NAME", left, "its name in the profile, usable instead of the number"},
      {"VALUE", right, "in the unit, or raw with --raw; - = access none; else why it could not be read"},
      {"UNIT", left, "of VALUE, unless it is raw, and of LIMITS"},
      {"LIMITS", left, "smallest and greatest value that may be written; empty = all that the format holds"},
      {"ACCESS", left, "read-write, read-only, or none = neither; volatile = changes by itself"},
      {"GROUP", left, "the group for --group"},
      {"TEXT", left, "what it means"}};
}

/// The parameters of a group, of every one when it is empty.
Parameters of_group(const profile::Profile& profile, const std::string& group) {
  Parameters chosen;
  std::string groups;
  for (const profile::Parameter& parameter : profile.parameters) {
    if (group.empty() || parameter.group == group) chosen.push_back(&parameter);
    if (!parameter.group.empty() && groups.find("'" + parameter.group + "'") == std::string::npos) {
      groups += (groups.empty() ? "'" : ", '") + parameter.group + "'";
    }
  }
  if (!chosen.empty()) return chosen;
  throw UsageError(fmt::format("--group: profile '{}' has no group '{}'; allowed: {}", profile.name, group,
                               groups.empty() ? "none, it has no groups" : groups));
}

std::string access_text(const profile::Parameter& parameter) {
  return std::string(profile::name(parameter.access)) + (parameter.is_volatile ? ", volatile" : "");
}

/// The parts of an object that come from the profile, after `number` and `name`.
void add_profile_keys(JsonObject& object, const profile::Parameter& parameter) {
  object.add("unit", parameter.unit);
  if (parameter.limited) {
    const double first = profile::scaled(parameter, parameter.minimum);
    const double last = profile::scaled(parameter, parameter.maximum);
    object.add("minimum", std::min(first, last)).add("maximum", std::max(first, last));
  } else {
    object.add_null("minimum").add_null("maximum");
  }
  object.add("access", profile::name(parameter.access))
      .add("volatile", parameter.is_volatile)
      .add("group", parameter.group)
      .add("text", parameter.text);
}

/// Writes each parameter as it comes.
class Listing {
 public:
  Listing(Session& session, unsigned slave, bool raw) : session_(session), slave_(slave), raw_(raw) {}

  /// `reply` null: it was not asked for.
  void add(const profile::Parameter& parameter, const client::ParameterReply* reply) {
    if (session_.json()) {
      object(parameter, reply);
    } else {
      row(parameter, reply);
    }
    if (reply != nullptr && !reply->ok() && failed_.ok()) failed_ = *reply;
  }

  /// Ends the listing: the table, and the exit code of the first parameter that could not be read.
  ExitCode end() {
    if (!session_.json()) session_.output().table(table_);
    if (failed_.ok()) return ExitCode::done;
    session_.output().remark(
        fmt::format("slave {}: not every parameter could be read: {}", slave_,
                    failed_.reason.empty() ? client::name(failed_.code) : std::string_view(failed_.reason)));
    return exit_code(failed_.code);
  }

 private:
  void object(const profile::Parameter& parameter, const client::ParameterReply* reply) {
    JsonObject object;
    object.add("slave", slave_).add("number", parameter.number).add("name", parameter.name);
    if (reply != nullptr && reply->ok()) {
      const bool fits = profile::fits_format(parameter, reply->doubleword);
      const std::int64_t number =
          fits ? profile::raw_number(parameter, reply->value)
               : as_signed(reply->value, reply->doubleword ? Width::doubleword : Width::word);
      object.add("value", reply->value)
          .add("signed", number)
          .add("format", reply->doubleword ? "doubleword" : "word");
      if (fits)
        object.add("scaled", profile::scaled(parameter, number));
      else
        object.add_null("scaled");
    } else {
      object.add_null("value").add_null("signed").add_null("format").add_null("scaled");
    }
    add_profile_keys(object, parameter);
    object.add("error_code", reply != nullptr ? reply->error_code : 0);
    if (reply != nullptr) {
      add_end(object, *reply);
    } else {
      object.add("result", "not_asked").add("reason", "").add_null("cause");
    }
    session_.output().object(object);
  }

  void row(const profile::Parameter& parameter, const client::ParameterReply* reply) {
    std::string value = "-";
    std::string meaning;
    const bool fits = reply != nullptr && profile::fits_format(parameter, reply->doubleword);
    if (reply != nullptr && reply->ok() && fits) {
      const std::int64_t number = profile::raw_number(parameter, reply->value);
      value = raw_ ? std::to_string(reply->value) : profile::scaled_text(parameter, number);
      meaning = profile::words(parameter, reply->value);
    } else if (reply != nullptr && reply->ok()) {
      value = std::to_string(reply->value);
      meaning = fmt::format("raw, for the slave has it as {}, the profile as {}",
                            reply->doubleword ? "doubleword" : "word", profile::name(parameter.format));
    } else if (reply != nullptr) {
      value = reply->error_code != 0 ? fmt::format("error 0x{:04X}", reply->error_code)
                                     : std::string(client::name(reply->code));
    }
    table_.add({std::to_string(parameter.number), parameter.name, value, parameter.unit,
                profile::limits_text(parameter), access_text(parameter), parameter.group,
                meaning.empty() ? parameter.text : fmt::format("{}: {}", parameter.text, meaning)});
  }

  Session& session_;
  unsigned slave_;
  bool raw_;
  client::Reply failed_ = {client::ReplyCode::done, ""};
  Table table_{parameter_columns()};
};

ExitCode list(Session& session, unsigned slave, const Parameters& chosen, bool raw) {
  Parameters readable;
  for (const profile::Parameter* parameter : chosen) {
    if (!profile::read_problem(*parameter)) readable.push_back(parameter);
  }
  Listing listing(session, slave, raw);
  auto next = chosen.begin();
  const auto list_unread = [&](const profile::Parameter* until) {
    for (; next != chosen.end() && *next != until; ++next) listing.add(**next, nullptr);
  };
  bool all = true;
  const client::Reply ended =
      read_parameters(session, slave, readable,
                      [&](const profile::Parameter& parameter, const client::ParameterReply& reply) {
                        list_unread(&parameter);
                        listing.add(parameter, &reply);
                        ++next;
                        all = all && reply.ok();
                      });
  if (ended.ok()) list_unread(nullptr);
  const ExitCode code = listing.end();
  return ended.ok() || !all ? code : exit_code(ended.code);
}

ExitCode params_verb(Session& session, const ParamsOptions& options) {
  const std::vector<unsigned> slaves = session.slaves(options.slave);
  return session.for_each(
      slaves,
      [&](std::size_t index) {
        const ProfilePointer profile = need_profile(session, slaves[index], options.profile);
        return list(session, slaves[index], of_group(*profile, options.group), options.raw);
      },
      Session::Lines::grouped);
}

}  // namespace

void add_params_verb(CLI::App& app, Verb& chosen) {
  auto* params = app.add_subcommand("params", "every parameter of a slave's drive profile, with its value");
  params->group(kSetVerbs);
  auto options = std::make_shared<ParamsOptions>();
  params->add_option("SLAVE", options->slave, kSlavesHelp)->required();
  params->add_option("--group", options->group, "only the parameters of this group")->type_name("GROUP");
  params->add_flag("--raw", options->raw, "values as on the bus, unsigned");
  add_profile_option(*params, options->profile);
  params->footer("Reads all of them from the slave.\n" + columns_help(parameter_columns()));
  params->callback([options, &chosen] {
    chosen = [options](Session& session) { return params_verb(session, *options); };
  });
}

}  // namespace cansync::cli
