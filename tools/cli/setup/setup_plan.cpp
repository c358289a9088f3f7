#include "cli/setup/setup_plan.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <fstream>
#include <iterator>
#include <memory>
#include <span>
#include <stdexcept>

#include "cli/base/child_process.h"
#include "cli/base/files.h"
#include "text/unit_name.h"

namespace cansync::cli {
namespace {

namespace fs = std::filesystem;

std::string contents_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::string_view kind_word(PlannedFile::Kind kind) {
  switch (kind) {
    case PlannedFile::Kind::write:
      return "write";
    case PlannedFile::Kind::same:
      return "keep";
    case PlannedFile::Kind::remove:
      return "remove";
    case PlannedFile::Kind::replace:
      break;
  }
  return "replace";
}

constexpr mode_t kFileMode = 0644;

/// Folders that are made while this lives get 0755: the users of the daemon and of systemd-networkd read them,
/// whatever the umask of root's shell is.
class ReadableForAll {
 public:
  ReadableForAll() noexcept : before_(::umask(0022)) {}
  ~ReadableForAll() { ::umask(before_); }
  ReadableForAll(const ReadableForAll&) = delete;
  ReadableForAll& operator=(const ReadableForAll&) = delete;

 private:
  mode_t before_;
};

/// What was there, beside itself, below a name that is free.
void keep_replaced(const fs::path& path) {
  fs::path kept = path;
  kept += ".before-setup";
  for (int number = 2; fs::exists(kept); ++number) {
    kept = path;
    kept += fmt::format(".before-setup-{}", number);
  }
  fs::copy_file(path, kept);
}

}  // namespace

std::vector<std::string> SetupPlan::replaced() const {
  std::vector<std::string> out;
  for (const PlannedFile& file : files)
    if (file.kind == PlannedFile::Kind::replace) out.push_back(file.path.string());
  return out;
}

PlannedFile planned_file(const fs::path& path, std::string text) {
  PlannedFile file{PlannedFile::Kind::write, path, std::move(text)};
  if (!fs::exists(path)) return file;
  file.kind = contents_of(path) == file.text ? PlannedFile::Kind::same : PlannedFile::Kind::replace;
  return file;
}

std::string command_text(const std::vector<std::string>& command) {
  std::string out;
  for (const std::string& word : command) out += (out.empty() ? "" : " ") + text::shell_word(word);
  return out;
}

void write_plan(Output& output, const SetupPlan& plan, bool done) {
  const auto tell = [&](std::string_view action, const std::string& what) {
    if (output.json())
      output.object(JsonObject().add("action", action).add("what", what).add("done", done));
    else
      output.line(fmt::format("{} {}", action, what));
  };
  for (const PlannedFile& file : plan.files) tell(kind_word(file.kind), file.path.string());
  for (const auto& command : plan.commands) tell("run", command_text(command));
}

std::string plan_words(const SetupPlan& plan) {
  std::string out = "This will";
  for (const PlannedFile& file : plan.files)
    if (file.kind != PlannedFile::Kind::same)
      out += fmt::format("\n  {} {}", kind_word(file.kind), file.path.string());
  for (const auto& command : plan.commands) out += "\n  run " + command_text(command);
  return out;
}

bool systemd_runs(const fs::path& root) {
  return root == "/" && fs::exists("/run/systemd/system");
}

bool run_commands(Output& output, const SetupPlan& plan) {
  for (const auto& command : plan.commands) {
    try {
      const ChildResult result = run_child(command, "");
      if (result.status == 0) continue;
      output.remark(fmt::format("`{}` failed: {}", command_text(command), result.errors));
    } catch (const NoProgram& error) {
      output.remark(fmt::format("`{}`: {}", command_text(command), error.what()));
    }
    return false;
  }
  return true;
}

void write_planned_files(const SetupPlan& plan) {
  std::vector<std::pair<const PlannedFile*, std::unique_ptr<ReplacementFile>>> opened;
  const ReadableForAll readable;
  // A folder that cannot be written is noticed before the first file is there.
  for (const PlannedFile& file : plan.files) {
    if (file.kind == PlannedFile::Kind::same || file.kind == PlannedFile::Kind::remove) continue;
    fs::create_directories(file.path.parent_path());
    opened.emplace_back(&file, std::make_unique<ReplacementFile>(file.path.string(), kFileMode));
  }
  for (auto one = opened.rbegin(); one != opened.rend(); ++one) {
    const PlannedFile& file = *one->first;
    if (file.kind == PlannedFile::Kind::replace) keep_replaced(file.path);
    one->second->commit({reinterpret_cast<const std::uint8_t*>(file.text.data()), file.text.size()});
  }
  for (const PlannedFile& file : plan.files)
    if (file.kind == PlannedFile::Kind::remove) fs::remove(file.path);
}

}  // namespace cansync::cli
