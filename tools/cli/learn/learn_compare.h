#pragma once

#include <string>
#include <vector>

#include "cansync/observe/learned.h"
#include "cli/base/output.h"

namespace cansync::cli {

/// A setting in which a configuration differs from the recorded master.
struct LearnedDifference {
  std::string option;
  std::string configured;
  std::string recorded;
  observe::Certainty certainty = observe::Certainty::not_seen;
  std::uint64_t count = 0;
};

/// Where these settings make other telegrams, or make them at other times, than the recording has. What the
/// recording tells nothing of is not compared. Pure.
std::vector<LearnedDifference> learned_differences(const MasterSettings& configured,
                                                   const observe::Learned& learned);

/// The settings of a configuration of a CANsync master. Throws std::runtime_error with its first problem.
MasterSettings settings_of_file(const std::string& path);

/// Writes the differences, and says when there is none.
void write_differences(Output& output, const std::vector<LearnedDifference>& differences,
                       const std::string& path);

/// The columns of that table, as a part of the help.
std::string compare_table_help();

}  // namespace cansync::cli
