#include "daemon/kept_configurations.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <ctime>
#include <filesystem>
#include <string_view>
#include <system_error>
#include <variant>

#include "daemon/service/replace_file.h"
#include "text/text_file.h"

namespace cansyncd {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kEnding = ".toml";

/// One kept file.
struct KeptFile {
  std::uint64_t number = 0;
  std::string path;
};

std::string name_of(const std::string& path) {
  return fs::path(path).stem().string();
}

/// NUMBER of NAME.NUMBER.toml; nothing for other files.
std::optional<std::uint64_t> number_of(std::string_view file, std::string_view name) {
  if (!file.starts_with(name) || !file.ends_with(kEnding)) return std::nullopt;
  file.remove_prefix(name.size());
  file.remove_suffix(std::min(file.size(), kEnding.size()));
  if (!file.starts_with('.')) return std::nullopt;
  file.remove_prefix(1);
  std::uint64_t number = 0;
  const auto [end, error] = std::from_chars(file.data(), file.data() + file.size(), number);
  if (error != std::errc() || end != file.data() + file.size()) return std::nullopt;
  return number;
}

/// Newest first.
std::vector<KeptFile> places(const std::string& folder, const std::string& name) {
  std::vector<KeptFile> found;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    if (const auto number = number_of(entry->path().filename().string(), name))
      found.push_back({*number, entry->path().string()});
  }
  std::sort(found.begin(), found.end(),
            [](const KeptFile& a, const KeptFile& b) { return a.number > b.number; });
  return found;
}

}  // namespace

std::string utc_text(std::int64_t seconds_since_1970) {
  const auto seconds = static_cast<std::time_t>(seconds_since_1970);
  std::tm parts = {};
  std::array<char, 64> text = {};
  if (::gmtime_r(&seconds, &parts) == nullptr) return "an unknown time";
  return {text.data(), std::strftime(text.data(), text.size(), "%Y-%m-%d %H:%M:%S UTC", &parts)};
}

std::vector<KeptConfiguration> KeptConfigurations::of(const std::string& path) const {
  std::vector<KeptConfiguration> kept;
  if (folder_.empty()) return kept;
  for (const KeptFile& place : places(folder_, name_of(path))) {
    struct stat facts = {};
    auto content = text::read_file(place.path);
    auto* text = std::get_if<std::string>(&content);
    if (text == nullptr || ::stat(place.path.c_str(), &facts) != 0) continue;
    kept.push_back({std::move(*text), utc_text(facts.st_mtim.tv_sec)});
  }
  return kept;
}

std::optional<std::string> KeptConfigurations::keep(const std::string& path, const std::string& text) const {
  if (folder_.empty()) return std::nullopt;
  const std::string name = name_of(path);
  const std::vector<KeptFile> before = places(folder_, name);
  if (!before.empty()) {
    const auto newest = text::read_file(before.front().path);
    const auto* same = std::get_if<std::string>(&newest);
    if (same != nullptr && *same == text) return std::nullopt;
  }
  const std::uint64_t number = before.empty() ? 1 : before.front().number + 1;
  const std::string file = (fs::path(folder_) / fmt::format("{}.{}{}", name, number, kEnding)).string();
  if (const auto failed = replace_file(file, text, {.durable = true}))
    return fmt::format("{}: {}", file, *failed);
  std::error_code ignored;  // one too many harms nothing
  for (std::size_t i = kMost - 1; i < before.size(); ++i) fs::remove(before[i].path, ignored);
  return std::nullopt;
}

}  // namespace cansyncd
