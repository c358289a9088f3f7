#include "cli/app/completion.h"

#include <cansync/client.h>
#include <cansync/topics.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <optional>

#include "cli/cansync/profiles.h"
#include "cli/text/values.h"

namespace cansync::cli {
namespace {

constexpr auto kSearch = std::chrono::milliseconds(400);  // discovery takes some 100 ms
constexpr unsigned kLongestSeconds = 2;                   // the shell waits for us
constexpr unsigned kValues = 8;
constexpr std::int64_t kHighestDomain = 230;

using Words = std::vector<std::string>;

/// The option as typed, else its environment variable, else `otherwise`.
std::string option(const text::TypedLine& line, const char* name, const char* variable,
                   std::string_view otherwise) {
  if (const auto typed = line.options.find(name); typed != line.options.end()) return typed->second;
  const char* set = std::getenv(variable);  // NOLINT(concurrency-mt-unsafe): nobody changes the environment
  return std::string(set != nullptr ? std::string_view(set) : otherwise);
}

/// The daemon the line is meant for, while this object lives. Throws when there is none.
class Daemon {
 public:
  explicit Daemon(const text::TypedLine& line) {
    ::alarm(kLongestSeconds);
    client::Options options;
    options.domain = static_cast<std::uint32_t>(
        parse_integer(option(line, "--domain", "CANSYNC_DOMAIN", "0"), "--domain", 0, kHighestDomain));
    options.bus = option(line, "--bus", "CANSYNC_BUS", "");
    options.interface = option(line, "--interface", "CANSYNC_INTERFACE", "lo");
    options.security = option(line, "--security", "CANSYNC_SECURITY", "");
    options.final_types = option(line, "--types", "CANSYNC_TYPES", "appendable") == "final";
    options.client_name = "cansync";
    options.wait = kSearch;
    client_ = client::Client::connect(options);
  }
  Daemon(const Daemon&) = delete;
  Daemon& operator=(const Daemon&) = delete;
  ~Daemon() {
    client_.reset();
    ::alarm(0);
  }
  client::Client& operator*() { return *client_; }
  client::Client* operator->() { return &*client_; }

 private:
  std::optional<client::Client> client_;
};

/// Numbers and names of the configured slaves.
Words slaves(const text::TypedLine& line) {
  Words out;
  Daemon daemon(line);
  for (const client::SlaveStatus& slave : daemon->slaves(kSearch)) {
    out.push_back(fmt::format("{}", slave.slave));
    if (slave.name[0] != '\0') out.emplace_back(slave.name);
  }
  return out;
}

Words value_names(const cansync_ValueName (&names)[kValues]) {
  Words out;
  for (const auto& value : names)
    if (value.name[0] != '\0') out.emplace_back(value.name);
  return out;
}

/// Names of the reference values, or of the actual values of the slave that `target` tells.
Words configured_values(const text::TypedLine& line, const std::string& target) {
  Daemon daemon(line);
  if (target == "references") return value_names(daemon->master_status().reference_value);
  for (const client::SlaveStatus& slave : daemon->slaves(kSearch)) {
    if (target == slave.name || target == fmt::format("{}", slave.slave))
      return value_names(slave.actual_value);
  }
  return {};
}

/// `words`, and what the daemon tells; `words` alone when there is none.
Words with(Words words, const std::function<Words()>& told) {
  try {
    const Words more = told();
    words.insert(words.end(), more.begin(), more.end());
  } catch (const std::exception&) {
    // No daemon, or a wrong option: that is said when the command runs.
    return words;
  }
  return words;
}

/// Values by number and name; `target`: references, or a slave.
Words value_words(const text::TypedLine& line, const std::string& target) {
  Words numbers;
  for (unsigned i = 0; i < kValues; ++i) numbers.push_back(fmt::format("value{}", i));
  return with(numbers, [&] { return configured_values(line, target); });
}

Words assignments(const text::TypedLine& line) {
  Words out;
  for (const std::string& value : value_words(line, "references")) out.push_back(value + "=");
  return out;
}

Words mapping_words(const text::TypedLine& line) {
  if (line.arguments.empty()) return {};
  Words out{"-"};
  for (const std::string& value : value_words(line, line.arguments.front())) {
    out.push_back(value + ".low");
    out.push_back(value + ".high");
  }
  return out;
}

/// Names of the parameters of the slave that is typed, or with `groups` of their groups.
Words parameter_names(const text::TypedLine& line, bool groups) {
  if (line.arguments.empty()) return {};
  Daemon daemon(line);
  Words out;
  for (const client::SlaveStatus& slave : daemon->slaves(kSearch)) {
    if (line.arguments.front() != slave.name && line.arguments.front() != fmt::format("{}", slave.slave))
      continue;
    if (slave.profile[0] == '\0') continue;
    const ProfilePointer profile =
        load_profile(slave.profile, option(line, "--profiles", "CANSYNC_PROFILES", ""));
    for (const profile::Parameter& parameter : profile->parameters) {
      const std::string& word = groups ? parameter.group : parameter.name;
      if (!word.empty() && std::find(out.begin(), out.end(), word) == out.end()) out.push_back(word);
    }
  }
  return out;
}

/// Names of the actual values of every slave.
Words actual_value_names(const text::TypedLine& line) {
  Words out;
  Daemon daemon(line);
  for (const client::SlaveStatus& slave : daemon->slaves(kSearch)) {
    for (const std::string& name : value_names(slave.actual_value))
      if (std::find(out.begin(), out.end(), name) == out.end()) out.push_back(name);
  }
  return out;
}

Words candidates(std::string_view placeholder, const text::TypedLine& line) {
  const auto told_slaves = [&line] { return slaves(line); };
  // A number is where automatic asking starts again; everywhere else several slaves may be named.
  if (placeholder == "SLAVE") return with(line.verb == "poll" ? Words{} : Words{"all"}, told_slaves);
  if (placeholder == "A" || placeholder == "B") return with({":files"}, told_slaves);
  if (placeholder == "PARAMETER") return with({}, [&line] { return parameter_names(line, false); });
  if (placeholder == "GROUP") return with({}, [&line] { return parameter_names(line, true); });
  if (placeholder == "SET") return with({"all"}, told_slaves);
  if (placeholder == "WHO") return with({"auto", "nobody"}, told_slaves);
  if (placeholder == "TARGET") return with({"references", "all"}, told_slaves);
  if (placeholder == "CHANNEL" || placeholder == "TELEGRAM") return {"1", "2"};
  if (placeholder == "PICTURE") return {":files"};
  if (placeholder == "NAMES" && line.verb == "record")
    return with({}, [&line] { return actual_value_names(line); });
  if (placeholder == "SOURCE") return {":files", ":interfaces"};
  if (placeholder == "VALUE=NUMBER") return assignments(line);
  if (placeholder == "WORD" && line.verb == "map") return mapping_words(line);
  return {};
}

}  // namespace

text::CandidateLookup completion_lookup() {
  return candidates;
}

}  // namespace cansync::cli
