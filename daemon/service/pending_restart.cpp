#include "daemon/service/pending_restart.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/stat.h>

#include <fstream>
#include <optional>
#include <set>
#include <sstream>
#include <string_view>
#include <utility>

namespace cansyncd {
namespace {

namespace fs = std::filesystem;

/// One line of /proc/self/maps: a file with code.
struct MappedFile {
  std::string path;
  bool deleted = false;  ///< the file of the mapping has no name any more
};

/// Nothing for data, anonymous memory, and files that no package installs.
std::optional<MappedFile> mapped_file(const std::string& line) {
  constexpr std::string_view kDeleted = " (deleted)";  // proc(5)
  std::istringstream fields(line);
  std::string addresses;
  std::string permissions;
  std::string skipped;  // offset, device, inode
  fields >> addresses >> permissions >> skipped >> skipped >> skipped >> std::ws;
  MappedFile file;
  std::getline(fields, file.path);
  if (permissions.find('x') == std::string::npos) return std::nullopt;
  file.deleted = file.path.ends_with(kDeleted);
  if (file.deleted) file.path.resize(file.path.size() - kDeleted.size());
  if (!file.path.starts_with("/usr/") && !file.path.starts_with("/lib")) return std::nullopt;
  return file;
}

std::map<std::string, bool> mapped_files(const fs::path& root) {
  std::map<std::string, bool> files;
  std::ifstream maps(root / "proc/self/maps");
  for (std::string line; std::getline(maps, line);) {
    if (const auto file = mapped_file(line)) files[file->path] |= file->deleted;
  }
  return files;
}

/// Of the file behind a path; 0: there is none, or it cannot be seen.
std::uint64_t inode(const fs::path& path) {
  struct stat facts = {};
  return stat(path.c_str(), &facts) == 0 ? facts.st_ino : 0;
}

std::string first_line(const fs::path& path) {
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  return line;
}

}  // namespace

ReplacedFiles::ReplacedFiles(fs::path root, std::string package)
    : root_(std::move(root)), package_(std::move(package)) {
  for (const auto& [path, deleted] : mapped_files(root_))
    loaded_[path] = inode(root_ / fs::path(path).relative_path());
}

PendingRestart ReplacedFiles::look() const {
  // What is compared is the path at the start with the path now, not the mapping with the path: overlay file
  // systems number the two differently.
  std::set<std::string> replaced;
  for (const auto& [path, deleted] : mapped_files(root_)) {
    const auto known = loaded_.find(path);
    const std::uint64_t now = inode(root_ / fs::path(path).relative_path());
    const bool other = known != loaded_.end() && known->second != 0 && now != 0 && now != known->second;
    if (deleted || other) replaced.insert(fs::path(path).filename());
  }
  PendingRestart pending;
  if (!package_.empty()) {
    if (std::string version = first_line(root_ / kVersionFile); !version.empty() && version != package_)
      pending.installed_version = std::move(version);
  }
  if (!pending.installed_version.empty()) {
    pending.reason = fmt::format("cansyncd {} is installed, {} runs", pending.installed_version, package_);
    replaced.erase("cansyncd");
  }
  if (!replaced.empty()) {
    pending.reason += fmt::format("{}replaced on disk since the start: {}",
                                  pending.reason.empty() ? "" : "; ", fmt::join(replaced, ", "));
  }
  return pending;
}

}  // namespace cansyncd
