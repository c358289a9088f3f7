#include "cli/base/person.h"

#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <cerrno>

#include "cli/base/interrupt.h"
#include "cli/text/values.h"
#include "text/visible.h"

namespace cansync::cli {
namespace {

constexpr int kAnswerLookMs = 20;
constexpr std::size_t kLongestAnswer = 4096;

std::string trimmed_answer(const std::string& text) {
  const auto begin = text.find_first_not_of(" \t\r");
  if (begin == std::string::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t\r") - begin + 1);
}

}  // namespace

bool person_is_there() noexcept {
  return ::isatty(STDIN_FILENO) == 1;
}

std::optional<std::string> ask_person(std::string_view question) {
  std::fputs(text::visible(question, "\n").c_str(), stderr);
  std::fflush(stderr);
  std::string line;
  while (!interrupt_flag().load()) {
    pollfd ready{STDIN_FILENO, POLLIN, 0};
    if (::poll(&ready, 1, kAnswerLookMs) <= 0) continue;
    char next = '\0';
    const ssize_t got = ::read(STDIN_FILENO, &next, 1);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) break;
    if (next == '\n') return trimmed_answer(line);
    if (line.size() < kLongestAnswer) line += next;
  }
  std::fputc('\n', stderr);
  return std::nullopt;
}

bool person_agrees(std::string_view what) {
  if (!person_is_there())
    throw UsageError(fmt::format("{} Nobody can be asked here; --yes says so beforehand", what));
  const auto answer = ask_person(fmt::format("{}\nGo on? [y/N] ", what));
  return answer && (*answer == "y" || *answer == "Y" || *answer == "yes");
}

}  // namespace cansync::cli
