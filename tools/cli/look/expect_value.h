#pragma once

#include <string>
#include <vector>

#include "cli/base/verbs.h"

/// `expect value` and `expect read` of a batch: a value is as it should be. Main thread only.
namespace cansync::cli {

/// `words`: "value" SLAVE VALUE or "read" SLAVE PARAMETER, then COMPARISON NUMBER, and perhaps "within"
/// SECONDS, 0..86400: then it may become so. Throws UsageError.
Verb expect_value_verb(std::vector<std::string> words);

}  // namespace cansync::cli
