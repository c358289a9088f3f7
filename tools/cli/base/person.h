#pragma once

#include <optional>
#include <string>
#include <string_view>

/// Questions to the person at the terminal.
namespace cansync::cli {

/// Standard input is a terminal, so that somebody can answer.
bool person_is_there() noexcept;

/// Writes `question` to standard error and reads one line from standard input, without its line end and
/// blanks around it. Nothing: the input has ended, or a signal came (noticed within 20 ms).
std::optional<std::string> ask_person(std::string_view question);

/// Says what is to be done, and asks whether to go on; only y and yes mean so. Throws UsageError when nobody
/// can be asked, with the remedy `--yes`.
bool person_agrees(std::string_view what);

}  // namespace cansync::cli
