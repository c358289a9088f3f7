#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>

namespace cansyncd {

/// What was replaced on disk since the process started and takes effect with a restart.
struct PendingRestart {
  std::string installed_version;  ///< of the package on disk; empty: the running one, or not from a package
  std::string reason;             ///< one sentence; empty: nothing was replaced

  friend bool operator==(const PendingRestart&, const PendingRestart&) = default;
};

/// Compares the program and the libraries that the process has loaded with the files on disk. A package
/// manager replaces a file while the process keeps the old one: nothing breaks, and nobody sees that the new
/// one waits. Files outside /usr come from no package and are left out. Not for the realtime thread.
class ReplacedFiles {
 public:
  /// Where the package puts its version, one line; below `root`.
  static constexpr const char* kVersionFile = "usr/share/cansync/version";

  /// Remembers which files are on disk now. `root`: before every path, "/" but for tests; `package`: version
  /// of the package that the program was built for, empty: none.
  ReplacedFiles(std::filesystem::path root, std::string package);

  /// Looks at the disk. What cannot be read is taken as unchanged; nothing throws for it.
  PendingRestart look() const;

 private:
  using Inode = std::uint64_t;

  std::filesystem::path root_;
  std::string package_;
  std::map<std::string, Inode> loaded_;  ///< of each file at the start; 0: it was not there
};

}  // namespace cansyncd
