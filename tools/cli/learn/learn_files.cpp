#include "cli/learn/learn_files.h"

#include <fcntl.h>
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <filesystem>
#include <system_error>

#include "cli/base/files.h"
#include "cli/learn/learn_points.h"
#include "cli/learn/learn_report.h"
#include "cli/text/values.h"
#include "profile/hash.h"
#include "profile/passport.h"
#include "profile/reader.h"
#include "system/descriptor.h"
#include "text/counts.h"
#include "text/visible.h"

namespace cansync::cli {
namespace {

using observe::Observation;
using observe::ParameterUse;
using observe::Step;
using observe::StepEnd;
using observe::TransferStep;

/// Later writes are the operation's, not the start-up's.
constexpr Duration kStartUp = std::chrono::seconds(10);

/// Does this belong into the slave's profile?
bool is_own(const ParameterUse& use, unsigned slave) {
  return use.slave.value() == slave && use.sub_slave == SubSlave{} && use.element == kValueElement &&
         use.reads + use.writes > 0;
}

std::string transfer_path(std::size_t number, const TransferStep& step) {
  const bool upload = step.direction == TransferInitialise::Direction::upload;
  return fmt::format("transfers/{:03}-slave{}-{}-0x{:X}.bin", number, step.slave.value(),
                     upload ? "upload" : "download", step.address);
}

std::string sub_option(SubSlave sub) {
  return sub.value == 0 ? "" : fmt::format(" --sub-slave {}", sub.value);
}

/// The step as a line of a batch; empty: there is no verb for it.
std::string batch_line(const Step& step, std::size_t transfer) {
  if (const auto* write = std::get_if<observe::WriteStep>(&step.what)) {
    const ParameterCommand& command = write->command;
    return fmt::format("write {} {} {} --format {}{}", command.slave.value(), command.number.value(),
                       command.value,
                       command.kind == ParameterCommand::Kind::write_word ? "word" : "doubleword",
                       sub_option(command.sub_slave));
  }
  if (const auto* moved = std::get_if<TransferStep>(&step.what)) {
    const bool upload = moved->direction == TransferInitialise::Direction::upload;
    if (upload || !moved->whole) return {};
    return fmt::format("download {} 0x{:X} {}{}", moved->slave.value(), moved->address,
                       transfer_path(transfer, *moved), sub_option(moved->sub_slave));
  }
  return {};
}

/// The value that a passport holds: what was read or written last.
std::uint32_t newest_value(const ParameterUse& use) {
  return use.written_last ? use.written : use.value;
}

LearnedFile passport_file(const Observation& observation, const LearnedPlace& place, unsigned slave,
                          const std::string& profile_text) {
  const std::string name = learned_profile_name(slave);
  const auto reading = profile::parse(profile_text, name + ".toml");
  profile::Passport passport;
  passport.bus = place.bus;
  passport.slave = slave;
  passport.slave_name = fmt::format("slave{}", slave);
  passport.profile = name;
  passport.profile_hash = profile::sha256(profile_text);
  for (const ParameterUse& use : observation.parameters) {
    if (!is_own(use, slave) || !reading.profile) continue;
    for (const profile::Parameter& parameter : reading.profile->parameters)
      if (parameter.number == use.number.value())
        passport.entries.push_back(passport_entry(
            parameter, parameter.is_volatile ? std::nullopt : std::optional(newest_value(use))));
  }
  return {fmt::format("passports/slave{}.txt", slave), passport_text(passport)};
}

std::string report_of_steps(const Observation& observation) {
  std::string out;
  for (const Step& step : observation.steps) {
    const std::int64_t time = microseconds_of(step.at);
    out += fmt::format("{}.{:06} {}\n", time / 1'000'000, time % 1'000'000, step_text(step));
  }
  return out;
}

}  // namespace

std::string learned_profile(const Observation& observation, unsigned slave) {
  std::string out = fmt::format(
      "# A draft: the parameters of slave {0} that were on a recording. Names, units, limits and meanings are in the\n"
      "# drive's manual; docs/profiles.md explains the keys.\n\n[profile]\nname = \"{1}\"\n"
      "text = \"Draft from a recording of slave {0}\"\n",
      slave, learned_profile_name(slave));
  for (const ParameterUse& use : observation.parameters) {
    if (!is_own(use, slave)) continue;
    const bool moves = use.reads > 1 && use.least != use.most && use.writes == 0;
    out += fmt::format(
        "\n# read {}, written {}, refused {}; read: {}..{}\n[[parameter]]\nnumber = {}\nname = "
        "\"parameter-{}\"\nformat = \"{}\"\naccess = \"{}\"{}\n",
        text::counted(use.reads, "time"), text::counted(use.writes, "time"),
        text::counted(use.refused, "time"), use.least, use.most, use.number.value(), use.number.value(),
        use.doubleword ? "doubleword" : "word", use.writes > 0 ? "read-write" : "read-only",
        moves ? "\nvolatile = true" : "");
  }
  return out;
}

std::string learned_batch(const Observation& observation, const LearnedPlace& place) {
  std::string out = fmt::format(
      "# What the master of {} wrote, in its order; run it from this folder: cansync --bus {} batch start-up.batch\n"
      "# Lines behind a # are for you to judge: control words move drives, and some steps were refused.\n",
      text::visible(place.source), place.bus);
  const Duration begin = observation.first_reference.value_or(Duration{0});
  std::size_t transfer = 0;
  for (const Step& step : observation.steps) {
    const auto* moved = std::get_if<TransferStep>(&step.what);
    if (moved != nullptr) ++transfer;
    const std::string line = batch_line(step, transfer);
    const auto* write = std::get_if<observe::WriteStep>(&step.what);
    const bool done =
        write != nullptr ? write->end == StepEnd::done : moved != nullptr && moved->end == StepEnd::done;
    if (!line.empty() && done && step.at <= begin + kStartUp)
      out += line + "\n";
    else
      out += fmt::format("# {}{}\n", line.empty() ? "" : line + "  : ", step_text(step));
  }
  if (observation.steps_over > 0)
    out += fmt::format("# {} found no room.\n", text::counted(observation.steps_over, "further step"));
  return out;
}

std::vector<LearnedFile> learned_files(const Observation& observation, const observe::Learned& learned,
                                       LearnedPlace place) {
  std::vector<LearnedFile> files;
  for (const ParameterUse& use : observation.parameters)
    if (is_own(use, use.slave.value())) place.profiles |= SlaveMask::of(use.slave).bits;
  files.push_back({place.bus + ".toml", learned_configuration(observation, learned, place)});
  files.push_back({"start-up.batch", learned_batch(observation, place)});
  files.push_back({"steps.txt", report_of_steps(observation)});
  for (const SlaveNumber slave : SlaveMask{place.profiles}) {
    const std::string text = learned_profile(observation, slave.value());
    files.push_back({fmt::format("profiles/{}.toml", learned_profile_name(slave.value())), text});
    files.push_back(passport_file(observation, place, slave.value(), text));
  }
  std::size_t transfer = 0;
  for (const Step& step : observation.steps) {
    const auto* moved = std::get_if<TransferStep>(&step.what);
    if (moved == nullptr) continue;
    ++transfer;
    if (moved->whole && !moved->data.empty())
      files.push_back({transfer_path(transfer, *moved), std::string(moved->data.begin(), moved->data.end())});
  }
  return files;
}

std::string usable_interface(const std::string& name) {
  const bool usable = !name.empty() && std::isalpha(static_cast<unsigned char>(name.front())) != 0 &&
                      std::all_of(name.begin(), name.end(), [](char one) {
                        return std::isalnum(static_cast<unsigned char>(one)) != 0 || one == '-' || one == '_';
                      });
  return usable ? name : "can0";
}

void write_learned_files(const std::string& folder, const std::vector<LearnedFile>& files) {
  const std::filesystem::path base(folder);
  for (const LearnedFile& file : files) {
    std::error_code ignored;
    if (std::filesystem::exists(base / file.path, ignored))
      throw UsageError(
          fmt::format("--write: {} is there already, and nothing is written over; name another folder",
                      (base / file.path).string()));
  }
  for (const LearnedFile& file : files) {
    const std::filesystem::path path = base / file.path;
    std::filesystem::create_directories(path.parent_path());
    const sys::Descriptor out(::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
    if (!out.is_open()) throw std::system_error(errno, std::generic_category(), path.string());
    write_all(out.number(), file.text, path.string());
  }
}

}  // namespace cansync::cli
