#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "cli/base/session.h"
#include "cli/scan/heard_line.h"
#include "cli/scan/inquiry.h"

namespace cansync::cli {

/// What was typed for asking.
struct AskTexts {
  bool ask = false;
  bool yes = false;
  bool parameters = false;
};

/// The profiles on this computer by which drives are recognised.
struct InstalledProfiles {
  std::vector<ProfilePointer> profiles;
  /// Of those in the folder of --profiles, where the daemon does not look: their text, by name.
  std::map<std::string, std::string> elsewhere;
};

/// Every profile of --profiles and the standard folders, each name once; what is wrong with a file is said in
/// a remark.
InstalledProfiles installed_profiles(Session& session);

/// Asks the slaves of a line that was listened to, after a question at the terminal unless --yes was given.
/// Throws UsageError when it may not be asked: a recording, no bit rate, nobody at the terminal;
/// std::runtime_error when a master is heard. Nothing: the person said no.
std::optional<InquiryResult> ask_line(const HeardLine& line, const AskTexts& texts,
                                      const InstalledProfiles& installed);

}  // namespace cansync::cli
