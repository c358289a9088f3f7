#include "cli/cansync/profiles.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <stdexcept>
#include <utility>

#include "cli/base/left_out.h"
#include "cli/connect/bus_connection.h"
#include "dds/overview/desk_client.h"
#include "profile/folders.h"
#include "profile/named.h"
#include "profile/source.h"
#include "text/counts.h"

namespace cansync::cli {
namespace {

constexpr std::int64_t kHighestParameter = 4095;

std::vector<std::string> folders_of(const std::string& first) {
  std::vector<std::string> folders = profile::standard_folders();
  if (!first.empty()) folders.insert(folders.begin(), first);
  return folders;
}

std::string slave_text(const client::SlaveStatus& slave) {
  return std::string_view(slave.name).empty() ? fmt::format("slave {}", slave.slave)
                                              : fmt::format("slave {} '{}'", slave.slave, slave.name);
}

/// What the daemon passes on, each profile asked for once.
profile::NamedProfile profile_of_daemon(Session& session, const client::SlaveStatus& slave) {
  static std::map<std::string, profile::NamedProfile> known;  // by SHA-256
  constexpr std::chrono::milliseconds kPatience{1000};
  const std::string hash(client::text(slave.profile_hash));
  if (const auto found = known.find(hash); found != known.end()) return found->second;
  std::optional<gateway::dds::DeskClient::ProfileFile> file;
  try {
    file = connect_bus<gateway::dds::DeskClient>(session).profile(hash, kPatience);
  } catch (const client::NoDaemon&) {
    return {nullptr, "and no daemon is there that could pass it on"};
  }
  if (!file) return {nullptr, "and the daemon passes none on"};
  profile::NamedProfile passed_on;
  if (file->text.empty()) {
    passed_on.problem = fmt::format("and the daemon passes on no file of more than {}, this one has {}",
                                    text::counted(profile::kLongestSource, "byte"), file->size);
  } else {
    passed_on = profile::from_daemon(client::text(slave.profile), hash, file->text);
  }
  return known[hash] = std::move(passed_on);
}

SlaveProfile slave_profile(profile::NamedProfile named) {
  return {std::move(named.profile), "", std::move(named.left_out)};
}

/// The same profile, when what was left out of it is shown.
SlaveProfile told(Output& output, SlaveProfile profile) {
  if (profile.profile != nullptr) tell_left_out(output, "profile " + profile.profile->name, profile.left_out);
  return profile;
}

}  // namespace

SlaveProfile named_profile(Session& session, const client::SlaveStatus& slave, const std::string& folder) {
  profile::NamedProfile found = profile::find_named(slave.profile, slave.profile_hash, folders_of(folder),
                                                    {"--profiles or CANSYNC_PROFILES", "--profile"});
  if (found.profile != nullptr) return slave_profile(std::move(found));
  profile::NamedProfile passed_on = profile_of_daemon(session, slave);
  if (passed_on.profile != nullptr) return slave_profile(std::move(passed_on));
  return {nullptr, fmt::format("{}: {}; {}", slave_text(slave), found.problem, passed_on.problem)};
}

ProfilePointer load_profile(const std::string& name_or_path, const std::string& folder) {
  return profile::load_typed(name_or_path, folder).profile;
}

SlaveProfile find_profile(Session& session, unsigned slave, const std::string& given) {
  if (!given.empty())
    return told(session.output(), slave_profile(profile::load_typed(given, session.profiles())));
  session.hold_names();
  for (const client::SlaveStatus& status : session.every_slave()) {
    if (status.slave != slave) continue;
    if (!std::string_view(status.profile).empty())
      return told(session.output(), named_profile(session, status, session.profiles()));
    if (const std::string reason = session.client().gateway_status().configuration_reason;
        reason.find("profile") != std::string::npos)
      return {nullptr, fmt::format("{}: its profile cannot be used: {}", slave_text(status), reason)};
    return {nullptr, fmt::format("{} has no profile, so that its parameters have no names; set profile = "
                                 "\"NAME\" in its [[slave]] section of the daemon's configuration, or give "
                                 "--profile",
                                 slave_text(status))};
  }
  return {nullptr,
          fmt::format("slave {} is not configured, so that its profile is not known; give --profile", slave)};
}

ProfilePointer need_profile(Session& session, unsigned slave, const std::string& given) {
  SlaveProfile found = find_profile(session, slave, given);
  if (found.profile == nullptr) throw std::runtime_error(found.problem);
  return found.profile;
}

void add_profile_option(CLI::App& verb, std::string& given) {
  verb.add_option("--profile", given,
                  "drive profile instead of that which the daemon names for the slave: a name or a file")
      ->type_name("PROFILE");
}

NamedParameter find_parameter(std::string_view text, const SlaveProfile& profile) {
  if (looks_like_number(text)) {
    const auto number = static_cast<std::uint32_t>(parse_integer(text, "PARAMETER", 0, kHighestParameter));
    return {number, profile.profile != nullptr ? profile.profile->find(number) : nullptr, false};
  }
  if (profile.profile == nullptr) throw std::runtime_error(profile.problem);
  const profile::Parameter* parameter = profile.profile->find(text);
  if (parameter != nullptr) return {parameter->number, parameter, true};
  throw UsageError(
      fmt::format("PARAMETER: profile '{}' has no parameter '{}'; allowed: 0..4095 or a name, `cansync "
                  "params SLAVE` lists them",
                  profile.profile->name, text));
}

}  // namespace cansync::cli
