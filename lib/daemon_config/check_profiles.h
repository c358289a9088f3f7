#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "config/problem.h"
#include "profile/profile.h"

namespace cansyncd {

/// A drive profile, or why there is none.
struct LoadedProfile {
  std::shared_ptr<const profile::Profile> profile;
  std::string problem;                    ///< of the option that names it; empty when a file was found
  std::vector<config::Problem> problems;  ///< in the profile's file; told once for each file
};

/// Reads the profiles that a configuration names, each file once. Main thread.
class ProfileFiles {
 public:
  /// `folder`: the configuration's; "" = the current one.
  explicit ProfileFiles(std::string folder) : folder_(std::move(folder)) {}

  /// The profile of a name, looked up in `folder/profiles` and the standard folders, or of a file. A relative
  /// file counts from `folder`, one typed on the command line from the current folder.
  LoadedProfile load(const std::string& name_or_path, bool typed);

 private:
  std::string folder_;
  std::map<std::string, std::shared_ptr<const profile::Profile>> read_;  ///< by path; null: a wrong one
};

}  // namespace cansyncd
