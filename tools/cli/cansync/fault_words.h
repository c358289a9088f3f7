#pragma once

#include <cansync/topics.h>
#include <cansync/types.h>

#include <array>
#include <string>

#include "cli/cansync/profiles.h"
#include "cli/text/slave_list.h"

namespace cansync::cli {

/// What the profiles of slaves call the faults in their status words. Main thread only.
class FaultWords {
 public:
  /// `session`: whose daemon passes on profiles that are not on this computer; must outlive the object.
  explicit FaultWords(Session& session) : session_(session) {}

  /// Such as "fault, reference value missing"; empty: no fault, or no profile tells. A
  /// profile is read when it is first needed and when the daemon names another one.
  std::string of(const client::SlaveStatus& slave);

 private:
  struct Known {
    std::string hash;  ///< of the profile that was looked for; empty: none yet
    ProfilePointer profile;
  };
  Session& session_;
  std::array<Known, kSlaves> known_ = {};
};

}  // namespace cansync::cli
