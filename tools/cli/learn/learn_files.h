#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "cansync/observe/learned.h"
#include "cli/learn/learn_configuration.h"

namespace cansync::cli {

/// A file of the folder that `learn --write` makes.
struct LearnedFile {
  std::string path;  ///< below the folder
  std::string text;  ///< may be bytes
};

/// Everything that is written of a recording: configuration, a batch that repeats the start-up, profile
/// drafts, passports, the data of transfers. Pure. Throws std::runtime_error when the cryptographic library
/// refuses.
std::vector<LearnedFile> learned_files(const observe::Observation& observation,
                                       const observe::Learned& learned, LearnedPlace place);

/// A batch for `cansync batch` with what the master wrote, in its order. What moves drives stands in
/// comments.
std::string learned_batch(const observe::Observation& observation, const LearnedPlace& place);

/// A draft of a profile: the parameters of this slave that were read or written.
std::string learned_profile(const observe::Observation& observation, unsigned slave);

/// The name in a log when an interface and a file can have it, else "can0".
std::string usable_interface(const std::string& name);

/// Writes the files below `folder`, which is made. Throws UsageError and writes nothing when one of them is
/// there already; std::system_error with the file's name.
void write_learned_files(const std::string& folder, const std::vector<LearnedFile>& files);

}  // namespace cansync::cli
