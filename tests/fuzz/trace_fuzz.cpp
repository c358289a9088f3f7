// `cansync trace FILE` over logs of candump, traces of the simulated line and flight recordings, in all three
// outputs. The first byte chooses the options, the rest is the file.
#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "bytes.h"
#include "can/candump.h"
#include "cli/app/application.h"
#include "memory_file.h"
#include "require.h"

namespace {

using cansync::cli::ExitCode;
using fuzz::require;

struct Output {
  ExitCode code = ExitCode::done;
  std::string data;
  std::string remarks;
};

Output trace(const std::vector<const char*>& options, const std::uint8_t* data, std::size_t size) {
  const fuzz::MemoryFile file(data, size);
  std::vector<const char*> arguments = {"cansync", "trace", file.path()};
  arguments.insert(arguments.end(), options.begin(), options.end());
  fuzz::MemoryOutput out;
  fuzz::MemoryOutput remarks;
  Output output;
  output.code =
      cansync::cli::run(static_cast<int>(arguments.size()), arguments.data(), out.file(), remarks.file());
  output.data = out.text();
  output.remarks = remarks.text();
  return output;
}

std::vector<std::string_view> lines(std::string_view text) {
  std::vector<std::string_view> out;
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    require(end != std::string_view::npos, "every line is ended");
    out.push_back(text.substr(0, end));
    text.remove_prefix(end + 1);
  }
  return out;
}

void require_printable(std::string_view text) {
  for (const char c : text)
    require(c == '\n' || (c >= ' ' && c < '\x7f'), "nothing that confuses a terminal is written");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::uint8_t bits = data[0];
  ++data;
  --size;
  const bool json = (bits & 3) == 1;
  const bool candump = (bits & 3) == 2;
  std::vector<const char*> options;
  if (json) options.push_back("--json");
  if (candump) options.push_back("--candump");
  if ((bits & 4) != 0) options.insert(options.end(), {"--slave", "3"});
  if ((bits & 8) != 0) options.insert(options.end(), {"--sync", "0x100"});
  const bool two = (bits & 16) != 0;
  if (two) options.insert(options.end(), {"--count", "2"});
  const Output output = trace(options, data, size);
  require(
      output.code == ExitCode::done || output.code == ExitCode::in_part || output.code == ExitCode::failed,
      "a log is read, or lines of it are not");
  // Not in a comment of the log, which is shown as it is.
  const auto says = [&output](const char* words) {
    const auto remarks = lines(output.remarks);
    return std::any_of(remarks.begin(), remarks.end(), [words](std::string_view line) {
      return line.find(": #") == line.npos && line.find(words) != line.npos;
    });
  };
  require((output.code != ExitCode::done) ==
              (says("not understood") || says("; allowed: a candump text log (candump -L)")),
          "what was not understood is counted, and another format is named");
  require_printable(output.data);
  require_printable(output.remarks);
  require(json || lines(output.remarks).size() <= 10 + 10 + 2, "few of many problems are named to people");
  const std::vector<std::string_view> shown = lines(output.data);
  if (two) require(shown.size() <= (json || candump ? 2u : 3u), "no more frames than asked for");
  for (const std::string_view line : shown)
    if (json) require(line.starts_with('{') && line.ends_with('}'), "one object a line");
  if (!candump) return 0;
  const Output again =
      trace(options, reinterpret_cast<const std::uint8_t*>(output.data.data()), output.data.size());
  require(again.code == ExitCode::done && again.data == output.data, "what was written is read as the same");
  return 0;
}
