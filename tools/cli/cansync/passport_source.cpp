#include "cli/cansync/passport_source.h"

#include <fmt/format.h>

#include <filesystem>

#include "cli/base/left_out.h"
#include "cli/cansync/parameter_reader.h"
#include "cli/cansync/profiles.h"
#include "cli/text/slave_list.h"
#include "profile/scaling.h"

namespace cansync::cli {

TakenPassport take_passport(Session& session, unsigned slave, const profile::Profile& profile,
                            bool with_volatile) {
  TakenPassport taken;
  taken.passport.bus = session.client().gateway_status().bus;
  taken.passport.slave = slave;
  taken.passport.slave_name = session.slave_name(slave);
  taken.passport.profile = profile.name;
  taken.passport.profile_hash = profile.hash;
  Parameters wanted;
  for (const profile::Parameter& parameter : profile.parameters) {
    if (!profile::read_problem(parameter) && (with_volatile || !parameter.is_volatile))
      wanted.push_back(&parameter);
  }
  std::vector<std::optional<std::uint32_t>> values;
  taken.ended = read_parameters(
      session, slave, wanted, [&](const profile::Parameter& parameter, const client::ParameterReply& reply) {
        const bool good = reply.ok() && profile::fits_format(parameter, reply.doubleword);
        values.push_back(good ? std::optional(reply.value) : std::nullopt);
        if (good) return;
        taken.unread.push_back(fmt::format(
            "{}: {}", profile::label(parameter),
            !reply.ok()
                ? reply.reason
                : fmt::format("the drive has it as {}, the profile as {}",
                              reply.doubleword ? "doubleword" : "word", profile::name(parameter.format))));
      });
  if (!taken.ended.ok()) return taken;
  auto value = values.begin();
  for (const profile::Parameter& parameter : profile.parameters) {
    if (profile::read_problem(parameter)) continue;
    const bool read = with_volatile || !parameter.is_volatile;
    taken.passport.entries.push_back(passport_entry(parameter, read ? *value++ : std::nullopt));
  }
  return taken;
}

Passport passport_of_file(Output& output, const std::string& path, bool force) {
  profile::PassportReading reading = profile::read_passport(path);
  tell_left_out(output, path, reading.left_out, reading.more_left_out);
  if (reading.changed && !force) {
    throw Ended(ExitCode::refused,
                fmt::format("{}: its checksum does not fit: it was changed after it was written; make a new "
                            "backup, or give --force to use {}",
                            path, reading.left_out.empty() ? "it as it is" : "what of it can be read"));
  }
  return std::move(*reading.passport);
}

Passport passport_of_slave(Session& session, unsigned slave, const std::string& profile) {
  TakenPassport taken = take_passport(session, slave, *need_profile(session, slave, profile));
  if (!taken.ended.ok()) {
    const std::string_view reason =
        taken.ended.reason.empty() ? client::name(taken.ended.code) : std::string_view(taken.ended.reason);
    throw Ended(exit_code(taken.ended.code),
                fmt::format("slave {}: its parameters could not be read: {}", slave, reason));
  }
  for (const std::string& unread : taken.unread) {
    session.output().remark(fmt::format("slave {}, {}", slave, unread));
  }
  return std::move(taken.passport);
}

SlaveFiles slave_files(Session& session, const std::string& list, const std::string& pattern, bool force) {
  SlaveFiles files;
  if (is_number_list(list)) check_slave_list(list);
  session.expect_input(pattern);
  // A file that is wrong is told without a daemon.
  if (!is_file_pattern(pattern))
    files.passports.push_back(passport_of_file(session.output(), pattern, force));
  files.slaves = session.slaves(list);
  files.paths = session.files(pattern, files.slaves);
  if (files.passports.empty())
    for (const std::string& path : files.paths)
      files.passports.push_back(passport_of_file(session.output(), path, force));
  return files;
}

bool is_file_argument(const std::string& text) {
  if (text.find_first_of("/.") != std::string::npos) return true;
  if (looks_like_number(text)) return false;
  std::error_code error;
  return std::filesystem::is_regular_file(text, error);
}

}  // namespace cansync::cli
