#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "cli/base/output.h"

namespace cansync::cli {

/// A file of the system that `setup` has to do with.
struct PlannedFile {
  enum class Kind : std::uint8_t {
    write,    ///< it is not there yet
    same,     ///< it is there with these contents
    replace,  ///< it is there with other contents
    remove,   ///< it is there with these contents, and is to go
  };
  Kind kind = Kind::write;
  std::filesystem::path path;
  std::string text;
};

/// Everything that is to be done, in order.
struct SetupPlan {
  std::vector<PlannedFile> files;
  std::vector<std::vector<std::string>> commands;  ///< each a program and its arguments

  /// Files that are there with other contents.
  std::vector<std::string> replaced() const;
};

/// What one file leads to: looks whether it is there.
PlannedFile planned_file(const std::filesystem::path& path, std::string text);

/// "write /etc/cansync/can0.toml", "run systemctl enable ...".
void write_plan(Output& output, const SetupPlan& plan, bool done);

/// "This will", and a line for each file and command.
std::string plan_words(const SetupPlan& plan);

/// Whether commands for systemd can be run for what was written below `root`.
bool systemd_runs(const std::filesystem::path& root);

/// Runs the commands. The first that fails ends it, is told, and makes the result false.
bool run_commands(Output& output, const SetupPlan& plan);

/// Writes the files, each in one step, the first one last: who finds it finds all. Files get the mode 0644 and
/// new folders 0755, whatever the umask. One that is replaced is kept beside itself, as PATH.before-setup. Files to remove
/// are removed. Throws std::system_error with the file's name.
void write_planned_files(const SetupPlan& plan);

/// The command as it is typed.
std::string command_text(const std::vector<std::string>& command);

}  // namespace cansync::cli
