#include "cli/app/batch_words.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <utility>

#include "cli/base/endings.h"
#include "cli/base/interrupt.h"
#include "cli/text/values.h"
#include "text/counts.h"

namespace cansync::cli {
namespace {

bool in_name(char letter) {
  return std::isalnum(static_cast<unsigned char>(letter)) != 0 || letter == '_';
}

bool is_variable_name(std::string_view text) {
  return !text.empty() && std::isdigit(static_cast<unsigned char>(text.front())) == 0 &&
         std::all_of(text.begin(), text.end(), in_name);
}

}  // namespace

bool BatchVariables::take(std::string_view word) {
  const std::size_t equals = word.find('=');
  if (equals == std::string_view::npos || !is_variable_name(word.substr(0, equals))) return false;
  values_[std::string(word.substr(0, equals))] = expand(word.substr(equals + 1));
  return true;
}

std::string BatchVariables::expand(std::string_view word) const {
  std::string out;
  while (!word.empty()) {
    const std::size_t dollar = std::min(word.find('$'), word.size());
    out += word.substr(0, dollar);
    word.remove_prefix(dollar);
    if (word.empty()) break;
    word.remove_prefix(1);
    if (word.starts_with('$')) {
      out += '$';
      word.remove_prefix(1);
      continue;
    }
    const bool braces = word.starts_with('{');
    if (braces) word.remove_prefix(1);
    const auto end = std::find_if_not(word.begin(), word.end(), in_name);
    const std::string_view name = word.substr(0, static_cast<std::size_t>(end - word.begin()));
    word.remove_prefix(name.size());
    const auto found = values_.find(name);
    if (found == values_.end() || (braces && !word.starts_with('}'))) {
      throw UsageError(
          fmt::format("found '${}', which was not set; allowed: variables set before by NAME=VALUE, "
                      "and $$ for '$'",
                      name));
    }
    if (braces) word.remove_prefix(1);
    out += found->second;
  }
  return out;
}

Verb sleep_verb(const std::vector<std::string>& words) {
  constexpr double kLongest = 86400.0;  // seconds
  if (words.size() != 1)
    throw UsageError(fmt::format("sleep: found {}; allowed: SECONDS", text::counted(words.size(), "word")));
  const double seconds = parse_real(words.front(), "SECONDS");
  if (seconds < 0.0 || seconds > kLongest)
    throw UsageError(fmt::format("SECONDS: found '{}'; allowed: 0..{:g}", words.front(), kLongest));
  return [seconds](Session& session) {
    session.expect_input("");
    using Clock = std::chrono::steady_clock;
    const auto time = std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
    return wait_until(Clock::now() + time) ? ExitCode::cancelled : ExitCode::done;
  };
}

Verb expect_verb(std::string_view status, Verb command) {
  constexpr std::int64_t kHighest = 255;
  const auto wanted = static_cast<unsigned>(parse_integer(status, "STATUS", 0, kHighest));
  return [wanted, command = std::move(command)](Session& session) {
    unsigned found = 0;
    try {
      found = static_cast<unsigned>(command(session));
    } catch (const ArgumentsAreRight&) {
      throw;
    } catch (const std::exception& error) {
      session.output().remark(error.what());
      found = static_cast<unsigned>(code_of(error));
    }
    if (found == wanted) return ExitCode::done;
    session.output().remark(fmt::format("expected exit status {}, found {}", wanted, found));
    return interrupt_flag().load() ? ExitCode::cancelled : ExitCode::failed;
  };
}

}  // namespace cansync::cli
