#include "cli/scan/ask_line.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <stdexcept>

#include "cli/base/files.h"
#include "cli/base/interrupt.h"
#include "cli/base/left_out.h"
#include "cli/base/person.h"
#include "cli/text/values.h"
#include "profile/folders.h"
#include "profile/named.h"
#include "profile/reader.h"

namespace cansync::cli {
namespace {

/// A folder of profiles is looked at up to so many files.
constexpr std::size_t kMostProfiles = 1000;
constexpr unsigned kEveryNumbers = 64;  ///< parameter numbers between two lines of progress

/// Says on a terminal how far an inquiry is, in one line that is written over.
class InquiryScreen {
 public:
  explicit InquiryScreen(Duration interval) : interval_(interval), terminal_(::isatty(STDERR_FILENO) == 1) {}
  ~InquiryScreen() {
    if (drawn_) std::fputs("\r\033[K", stderr);
  }
  InquiryScreen(const InquiryScreen&) = delete;
  InquiryScreen& operator=(const InquiryScreen&) = delete;

  void show(const std::string& what, unsigned done, unsigned total) {
    if (!terminal_ || (total > kSlaves && done % kEveryNumbers != 0)) return;
    const auto left = std::chrono::duration_cast<std::chrono::seconds>(interval_ * (total - done));
    std::fputs(fmt::format("\r\033[K{}: {} of {}{}", what, done, total,
                           total > kSlaves ? fmt::format(", at least {} s left", left.count()) : "")
                   .c_str(),
               stderr);
    std::fflush(stderr);
    drawn_ = true;
  }

 private:
  Duration interval_;
  bool terminal_;
  bool drawn_ = false;
};

void expect_askable(const HeardLine& line) {
  if (!line.live) throw UsageError("--ask: found a recording; allowed: with a CAN interface alone");
  if (line.census.master())
    throw std::runtime_error(fmt::format(
        "{}: a master is heard, so nothing is asked: its telegrams and ours would meet. What it does tells "
        "more than asking: `cansync learn {}`; else switch it off and ask again",
        line.interface, line.interface));
  if (!line.bit_rate)
    throw UsageError(fmt::format(
        "--bit-rate: found nothing, and {} has no bit rate of its own; allowed: 125000, 250000, 500000 or 1000000",
        line.interface));
}

std::vector<std::string> profile_files(const std::string& folder) {
  std::vector<std::string> paths;
  std::error_code none;
  for (const auto& entry : std::filesystem::directory_iterator(folder, none))
    if (entry.path().extension() == ".toml" && paths.size() < kMostProfiles) paths.push_back(entry.path());
  std::sort(paths.begin(), paths.end());
  return paths;
}

/// Null: it is wrong, which is said.
ProfilePointer profile_or_remark(Output& output, const std::string& path) {
  try {
    profile::NamedProfile read = profile::load(path);
    tell_left_out(output, path, read.left_out);
    return std::move(read.profile);
  } catch (const std::runtime_error& error) {
    output.remark(error.what());
    return nullptr;
  }
}

bool may_ask(const HeardLine& line, const AskTexts& texts) {
  if (texts.yes) return true;
  return person_agrees(fmt::format(
      "This sends questions to slaves 0 to 31 of {} at {} bit/s: reads of parameters, and uploads that "
      "are begun and closed. No SYNC, no write, no control word.",
      line.interface, slot_times(*line.bit_rate).bits_per_second));
}

}  // namespace

InstalledProfiles installed_profiles(Session& session) {
  InstalledProfiles out;
  std::vector<std::string> folders = profile::standard_folders();
  if (!session.profiles().empty()) folders.insert(folders.begin(), session.profiles());
  for (const std::string& folder : folders) {
    for (const std::string& path : profile_files(folder)) {
      const auto loaded = profile_or_remark(session.output(), path);
      const bool known = loaded && std::any_of(out.profiles.begin(), out.profiles.end(),
                                               [&](const auto& one) { return one->name == loaded->name; });
      if (!loaded || known) continue;
      out.profiles.push_back(loaded);
      if (folder == session.profiles()) {
        const auto bytes = read_file(path, profile::kFileLimit);
        out.elsewhere.emplace(loaded->name, std::string(bytes.begin(), bytes.end()));
      }
    }
  }
  return out;
}

std::optional<InquiryResult> ask_line(const HeardLine& line, const AskTexts& texts,
                                      const InstalledProfiles& installed) {
  expect_askable(line);
  if (!may_ask(line, texts)) return std::nullopt;
  InquirySettings settings;
  settings.profiles = installed.profiles;
  settings.parameters = texts.parameters;
  const auto port = open_line_port(line.interface);
  QuestionLine questions(*port, *line.bit_rate, interrupt_flag());
  InquiryScreen screen(questions.interval());
  return inquire(questions, settings, [&screen](const std::string& what, unsigned done, unsigned total) {
    screen.show(what, done, total);
  });
}

}  // namespace cansync::cli
