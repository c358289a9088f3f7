#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "cli/base/session.h"
#include "profile/profile.h"

/// Drive profiles for verbs that know parameters by name. Main thread only.
namespace cansync::cli {

using ProfilePointer = std::shared_ptr<const profile::Profile>;

/// The profile of a slave, or why there is none here.
struct SlaveProfile {
  ProfilePointer profile;                  ///< null: none
  std::string problem;                     ///< with a remedy; empty when there is one
  std::vector<std::string> left_out = {};  ///< as profile::NamedProfile
};

/// Reads a profile by name, from the folder of --profiles and the standard ones, or by file. Throws
/// std::runtime_error that names everything wrong with it.
ProfilePointer load_profile(const std::string& name_or_path, const std::string& folder);

/// The profile that the daemon names for a slave: the same file in `folder`, that of --profiles, or in a
/// standard one; else the daemon passes it on. Throws as `load_profile`.
SlaveProfile named_profile(Session& session, const client::SlaveStatus& slave, const std::string& folder);

/// The profile of --profile when `given` is not empty (throws as `load_profile`), else that which the daemon
/// names for the slave, as `named_profile`. What was left out of it is shown (`tell_left_out`).
SlaveProfile find_profile(Session& session, unsigned slave, const std::string& given);

/// The same for verbs that need one. Throws std::runtime_error with the problem.
ProfilePointer need_profile(Session& session, unsigned slave, const std::string& given);

/// Adds --profile to a verb.
void add_profile_option(CLI::App& verb, std::string& given);

/// A parameter as it was typed: its number, and what the profile says of it (null: not known).
struct NamedParameter {
  std::uint32_t number = 0;
  const profile::Parameter* known = nullptr;  ///< belongs to the profile
  bool by_name = false;
};

/// Finds a parameter by number 0..4095 or name. Throws UsageError for a name the profile does not have,
/// std::runtime_error for a name when there is no profile.
NamedParameter find_parameter(std::string_view text, const SlaveProfile& profile);

}  // namespace cansync::cli
