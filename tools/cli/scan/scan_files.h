#pragma once

#include <map>
#include <string>
#include <vector>

#include "cli/learn/learn_files.h"
#include "cli/scan/heard_line.h"
#include "cli/scan/inquiry.h"

namespace cansync::cli {

/// What a scan has found, as it is written down.
struct ScannedLine {
  HeardLine heard;
  std::string new_name;            ///< that the interface is to get; empty: it keeps its own
  std::vector<FoundSlave> slaves;  ///< that answered; empty: nobody was asked
  /// Text of profiles that the daemon would not find by itself, by name.
  std::map<std::string, std::string> profiles;
};

/// Name of the interface that the files are for.
const std::string& interface_of(const ScannedLine& line) noexcept;

/// A configuration of cansyncd for the line, named BUS.toml like its interface; drafts of profiles for drives
/// without one whose parameters were read; in `network` the files for systemd-networkd. Pure. Throws
/// std::runtime_error when the bit rate is not known, there is no slave, or the interface is to get another name and
/// nothing distinguishes its adapter from others.
std::vector<LearnedFile> scan_files(const ScannedLine& line);

/// The configuration alone.
std::string scan_configuration(const ScannedLine& line);

/// A draft of a profile: the parameters of this slave that were read.
std::string scanned_profile(const FoundSlave& slave);

/// Name of that draft: "scanned-3".
std::string scanned_profile_name(const FoundSlave& slave);

}  // namespace cansync::cli
