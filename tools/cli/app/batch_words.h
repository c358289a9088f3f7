#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "cli/base/verbs.h"
#include "cli/text/words.h"

/// What lines of a batch may have that the shell's command line has not. Main thread only.
namespace cansync::cli {

/// The variables of a batch.
class BatchVariables {
 public:
  /// "NAME=VALUE" sets one. False: `word` is none. A name has letters, digits and '_', and begins with no
  /// digit.
  bool take(std::string_view word);

  /// `word` with the values in place of "$NAME" and "${NAME}", and '$' for "$$". Throws UsageError for a name
  /// that was not set.
  std::string expand(std::string_view word) const;

 private:
  std::map<std::string, std::string, std::less<>> values_;
};

/// `sleep SECONDS`, 0..86400. Throws UsageError.
Verb sleep_verb(const std::vector<std::string>& words);

/// `expect STATUS COMMAND...`: done when `command` ends with this exit status, else failed. Throws
/// UsageError.
Verb expect_verb(std::string_view status, Verb command);

}  // namespace cansync::cli
