#include "daemon/configuration_watch.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <cerrno>
#include <utility>

#include "daemon/kept_configurations.h"

namespace cansyncd {

ConfigurationWatch::ConfigurationWatch(const LoadedConfig& running, LoadConfiguration load, std::int64_t now)
    : path_(running.path),
      load_(std::move(load)),
      text_(running.text.value_or("")),
      since_(running.kept_since.empty() ? utc_text(now) : running.kept_since) {
  if (!running.profile_problems.empty())
    profiles_ =
        "runs without a drive profile, its names and limits: " + to_string(running.profile_problems.front());
}

bool ConfigurationWatch::look() {
  const Facts now = facts_of(path_);
  if (now == facts_) return false;
  facts_ = now;
  std::string reason = compare();
  if (reason == reason_) return false;
  reason_ = std::move(reason);
  return true;
}

void ConfigurationWatch::taken(const std::string& text, std::string left, std::int64_t now) {
  text_ = text;
  left_ = std::move(left);
  since_ = utc_text(now);
  profiles_.clear();
  facts_ = {};
}

ConfigurationWatch::Facts ConfigurationWatch::facts_of(const std::string& path) {
  struct stat found = {};
  if (::stat(path.c_str(), &found) != 0) return {.error = errno};
  return {0, found.st_dev, found.st_ino, found.st_size, found.st_mtim.tv_sec, found.st_mtim.tv_nsec};
}

std::string ConfigurationWatch::compare() {
  const config::Source file = config::read_source(path_);
  wrong_ = false;
  differs_ = file.text != text_ || !left_.empty();
  if (file.text == text_) return left_.empty() ? profiles_ : fmt::format("{}: {}", path_, left_);
  const LoadedConfig wanted = load_(file);
  wrong_ = !wanted.problems.empty();
  const std::string what =
      wrong_ ? to_string(wanted.problems.front()) : path_ + " has changed: reload the daemon, or restart it";
  return fmt::format("runs the configuration of {}; {}", since_, what);
}

}  // namespace cansyncd
