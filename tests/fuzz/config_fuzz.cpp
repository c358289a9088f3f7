// The daemon's configuration: TOML, options, checks. A line that begins with "#set " is one --set.
#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "bounded.h"
#include "bytes.h"
#include "cansync/config/file.h"
#include "cansync/config/options.h"
#include "cansync/settings/settings_check.h"
#include "config/document.h"
#include "require.h"

namespace {

using fuzz::require;

std::vector<std::string> overrides_of(std::string_view text) {
  constexpr std::string_view kMark = "#set ";
  std::vector<std::string> out;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    if (text.starts_with(kMark))
      out.emplace_back(text.substr(kMark.size(), end - std::min(end, kMark.size())));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return out;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text = fuzz::text_of(data, size);
  config::Settings settings = fuzz::bounded(size, fuzz::kOfText, [&] {
    return config::resolve(config::parse_document(text, "fuzz.toml"), cansyncd::options());
  });
  for (const std::string& assignment : overrides_of(text))
    config::override_setting(settings, assignment, cansyncd::options());
  const cansyncd::ConfigFile file = cansyncd::build_config(std::move(settings), "fuzz.toml");
  for (const config::Problem& problem : file.problems) {
    require(!problem.text.empty(), "a problem says what it is");
    require(!config::to_string(problem).empty(), "a problem can be told");
  }
  require(file.problems.empty() == config::problems_text(file.problems).empty(), "problems are told");
  if (!file.problems.empty()) return 0;
  require(cansync::check(file.config.master).empty(), "the master can be built from what was accepted");
  require(!file.config.dds.partition.empty(), "the partition is never empty");
  require(!file.config.master.configured().empty(), "there is a slave");
  return 0;
}
