// The command lines of `cansync`, `cansyncd` and `cansync-sim`, one argument a line; the first byte of the
// input chooses the program. Nothing is started: `cansync` looks for its daemon on a network interface that
// does not exist, of the other two the command line is read alone, with what is checked without a file.
#include <algorithm>
#include <array>
#include <cstdio>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "bytes.h"
#include "cli/app/application.h"
#include "daemon/arguments.h"
#include "require.h"
#include "simulator/arguments.h"
#include "simulator/setup.h"

namespace {

using cansync::cli::ExitCode;
using fuzz::require;

constexpr std::size_t kMostArguments = 30;

/// `text` line by line behind `out`.
std::vector<const char*> arguments(std::vector<std::string>& out, const std::string& text) {
  for (std::size_t from = 0; from < text.size() && out.size() < kMostArguments;) {
    const std::size_t end = std::min(text.find('\n', from), text.size());
    out.push_back(text.substr(from, end - from));
    from = end + 1;
  }
  std::vector<const char*> pointers;
  pointers.reserve(out.size());
  for (const std::string& word : out) pointers.push_back(word.c_str());
  return pointers;
}

/// Words that would make `cansync` read what is no file of ours, wait for standard input or a daemon, look at
/// the kernel, or write a file.
bool reaches_outside(const std::string& word) {
  constexpr std::array<std::string_view, 13> kWords = {"-",       "doctor", "upload", "trace", "download",
                                                       "backup",  "batch",  "diff",   "plot",  "record",
                                                       "restore", "verify", "wait"};
  return std::find(kWords.begin(), kWords.end(), word) != kWords.end() || word.starts_with("--retry") ||
         word.find('/') != std::string::npos;
}

void run_cansync(const std::string& text) {
  static std::FILE* const nowhere = std::fopen("/dev/null", "w");
  std::vector<std::string> words = {"cansync", "--interface", "nowhere0"};
  const std::vector<const char*> pointers = arguments(words, text);
  for (const std::string& word : words)
    if (reaches_outside(word)) return;
  const ExitCode code =
      cansync::cli::run(static_cast<int>(pointers.size()), pointers.data(), nowhere, nowhere);
  require(code == ExitCode::done || code == ExitCode::usage || code == ExitCode::not_reachable,
          "without a daemon it is help, a wrong command line, or no daemon");
}

template <class End>
void check_end(const End& end) {
  require(!end.text.empty(), "an end of the command line says why");
  require(!end.wrong || end.text.find("--help") != std::string::npos, "an error says where help is");
}

void run_cansyncd(const std::string& text) {
  std::vector<std::string> words = {"cansyncd"};
  const std::vector<const char*> pointers = arguments(words, text);
  const auto parsed = cansyncd::parse_arguments(static_cast<int>(pointers.size()), pointers.data());
  if (const auto* end = std::get_if<cansyncd::CommandLineEnd>(&parsed)) return check_end(*end);
  const auto& given = std::get<cansyncd::Arguments>(parsed);
  require(!given.config.empty() || !given.check.empty() || given.print_default_config ||
              given.print_options_markdown,
          "there is something to do");
  require(given.config.empty() || given.check.empty(), "a file is run or checked");
  const std::size_t more = (given.trace.empty() ? 0u : 1u) + (given.domain.empty() ? 0u : 1u);
  require(cansyncd::overrides(given).size() == given.set.size() + more, "every setting is handed on");
}

void run_simulator(const std::string& text) {
  std::vector<std::string> words = {"cansync-sim"};
  const std::vector<const char*> pointers = arguments(words, text);
  const auto parsed = cansync_sim::parse_arguments(static_cast<int>(pointers.size()), pointers.data());
  if (const auto* end = std::get_if<cansync_sim::CommandLineEnd>(&parsed)) return check_end(*end);
  cansync_sim::Arguments given = std::get<cansync_sim::Arguments>(parsed);
  given.config.clear();
  given.faults.clear();
  std::erase_if(given.set, [](const std::string& set) { return set.starts_with("sim.fault_script"); });
  const cansync_sim::Setup setup = cansync_sim::make_setup(given);
  for (const std::string& problem : setup.problems) require(!problem.empty(), "a problem is told");
  if (!setup.problems.empty()) return;
  require(!setup.drives.empty() && setup.drives.size() <= 32, "there is a drive for each slave");
  require(setup.interface == given.interface || !given.set.empty(),
          "the interface is the one that was named");
  require(setup.bench.sync_identifier <= 0x7FF &&
              !cansync_sim::is_cansync_identifier(setup.bench.sync_identifier),
          "SYNC has an identifier of its own");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string text = fuzz::text_of(data + 1, size - 1);
  switch (data[0] % 3) {
    case 0:
      run_cansync(text);
      break;
    case 1:
      run_cansyncd(text);
      break;
    default:
      run_simulator(text);
      break;
  }
  return 0;
}
