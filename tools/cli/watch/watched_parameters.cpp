#include "cli/watch/watched_parameters.h"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <utility>

#include "cli/text/slave_list.h"
#include "profile/meaning.h"
#include "profile/scaling.h"
#include "text/counts.h"

namespace cansync::cli {
namespace {

/// Each name or number of lists with commas.
std::vector<std::string> words_of_lists(const std::vector<std::string>& lists) {
  std::vector<std::string> words;
  for (const std::string& list : lists) {
    std::string_view rest = list;
    for (bool more = true; more;) {
      const std::size_t comma = rest.find(',');
      words.emplace_back(rest.substr(0, comma));
      if (words.back().empty())
        throw UsageError(
            fmt::format("--parameter: found '{}'; allowed: 0..4095 or names, with commas", list));
      more = comma != std::string_view::npos;
      if (more) rest.remove_prefix(comma + 1);
    }
  }
  if (words.size() > kMostParameters)
    throw UsageError(fmt::format("--parameter: found {}; allowed: up to {}",
                                 text::counted(words.size(), "parameter"), kMostParameters));
  for (const std::string& word : words)
    if (looks_like_number(word)) static_cast<void>(find_parameter(word, {}));
  return words;
}

/// Throws as `find_parameter`, and UsageError for one that may not be read.
WatchedParameter find_one(const std::string& typed, const SlaveProfile& profile) {
  const NamedParameter found = find_parameter(typed, profile);
  WatchedParameter parameter;
  parameter.number = found.number;
  parameter.typed = typed;
  parameter.by_name = found.by_name;
  parameter.profile = profile.profile;
  parameter.known = found.known;
  if (found.known != nullptr)
    if (const auto problem = profile::read_problem(*found.known)) throw UsageError(problem->text);
  return parameter;
}

/// Does the profile's scaling hold for the value?
bool scales(const WatchedParameter& parameter) {
  return parameter.value && parameter.known != nullptr &&
         profile::fits_format(*parameter.known, parameter.value->doubleword);
}

}  // namespace

std::string heading_of(const WatchedParameter& parameter) {
  return parameter.by_name || !parameter.asked ? parameter.typed
                                               : fmt::format("parameter {}", parameter.number);
}

std::int64_t raw_number(const WatchedParameter& parameter) {
  if (scales(parameter)) return profile::raw_number(*parameter.known, parameter.value->value);
  return parameter.value->value;
}

std::optional<double> scaled_number(const WatchedParameter& parameter) {
  if (!scales(parameter)) return std::nullopt;
  return profile::scaled(*parameter.known, raw_number(parameter));
}

std::string words_of(const WatchedParameter& parameter) {
  return scales(parameter) ? profile::words(*parameter.known, parameter.value->value) : "";
}

std::string text_of(const WatchedParameter& parameter, bool raw) {
  if (!parameter.value) return "-";
  if (raw || !parameter.by_name || !scales(parameter)) return fmt::format("{}", raw_number(parameter));
  std::string text = profile::scaled_text(*parameter.known, raw_number(parameter));
  if (!parameter.known->unit.empty()) text += " " + parameter.known->unit;
  const std::string words = words_of(parameter);
  return words.empty() ? text : text + ": " + words;
}

std::optional<std::int64_t> oldest_ms(const std::vector<WatchedParameter>& parameters, std::int64_t now) {
  constexpr std::int64_t kMillisecond = 1'000'000;  // ns
  std::optional<std::int64_t> oldest;
  for (const WatchedParameter& parameter : parameters) {
    if (!parameter.value) continue;
    const std::int64_t age = std::max<std::int64_t>(0, (now - parameter.time) / kMillisecond);
    oldest = std::max(oldest.value_or(0), age);
  }
  return oldest;
}

std::vector<WatchedSlave> find_watched(Session& session, const std::vector<std::string>& typed,
                                       std::uint32_t slaves, bool named) {
  const std::vector<std::string> words = words_of_lists(typed);
  std::vector<WatchedSlave> found;
  std::exception_ptr problem;
  std::vector<bool> known(words.size(), false);
  for (unsigned slave = 0; slave < kSlaves && !words.empty(); ++slave) {
    if (((slaves >> slave) & 1u) == 0) continue;
    const SlaveProfile profile = find_profile(session, slave, "");
    found.push_back({slave, {}});
    for (std::size_t i = 0; i < words.size(); ++i) {
      try {
        found.back().parameters.push_back(find_one(words[i], profile));
        known[i] = true;
      } catch (const std::exception&) {
        if (named) throw;
        if (!problem) problem = std::current_exception();
        WatchedParameter missing;
        missing.typed = words[i];
        missing.asked = false;
        found.back().parameters.push_back(std::move(missing));
      }
    }
  }
  if (problem && std::find(known.begin(), known.end(), false) != known.end()) std::rethrow_exception(problem);
  return found;
}

}  // namespace cansync::cli
