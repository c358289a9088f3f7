#include "layer2/script.h"

#include <algorithm>
#include <array>
#include <string>

namespace layer2 {
namespace {

constexpr std::string_view kBlanks = " \t\r,";

struct Word {
  std::string_view text;
  std::size_t column = 1;
};

std::vector<Word> words_of(std::string_view line) {
  std::vector<Word> words;
  std::size_t at = line.find_first_not_of(kBlanks);
  while (at != std::string_view::npos) {
    std::size_t end = line.find_first_of(kBlanks, at);
    if (end == std::string_view::npos) end = line.size();
    if (line.substr(at, 2) == "//") break;
    words.push_back({line.substr(at, end - at), at + 1});
    at = line.find_first_not_of(kBlanks, end);
  }
  return words;
}

char lower(char letter) noexcept {
  return letter >= 'A' && letter <= 'Z' ? static_cast<char>(letter - 'A' + 'a') : letter;
}

bool is_word(std::string_view found, std::string_view wanted) {
  return std::equal(found.begin(), found.end(), wanted.begin(), wanted.end(),
                    [](char a, char b) { return lower(a) == b; });
}

/// A whole number of at most 32 bits; nothing: no such number.
std::optional<std::uint32_t> number_of(std::string_view digits, unsigned base) {
  if (digits.empty()) return std::nullopt;
  std::uint64_t value = 0;
  for (const char letter : digits) {
    const char digit = lower(letter);
    unsigned weight = base;
    if (digit >= '0' && digit <= '9') weight = static_cast<unsigned>(digit - '0');
    if (digit >= 'a' && digit <= 'f') weight = static_cast<unsigned>(digit - 'a') + 10;
    if (weight >= base) return std::nullopt;
    value = value * base + weight;
    if (value > UINT32_MAX) return std::nullopt;
  }
  return static_cast<std::uint32_t>(value);
}

std::string hex(std::uint32_t value) {
  std::string text;
  do {
    text.insert(text.begin(), "0123456789ABCDEF"[value % 16]);
    value /= 16;
  } while (value != 0);
  return "0x" + text;
}

/// What is wrong with one line.
struct LineProblem {
  std::size_t column = 1;
  std::string text;
};

/// Reads the arguments of one line; the first problem counts.
class LineReader {
 public:
  LineReader(std::string_view line, const ScriptRules& rules) : rules_(rules), words_(words_of(line)) {
    end_column_ = words_.empty() ? 1 : words_.back().column + words_.back().text.size();
  }

  bool empty() const { return words_.empty(); }
  std::optional<ScriptCommand> command();
  const LineProblem& problem() const { return *problem_; }

 private:
  std::size_t left() const { return words_.size() - at_; }
  void wrong(std::string text) {
    if (problem_) return;
    problem_ = {at_ < words_.size() ? words_[at_].column : end_column_, std::move(text)};
  }
  std::string found() const {
    return at_ < words_.size() ? "found '" + std::string(words_[at_].text.substr(0, 40)) + "'"
                               : std::string("found the end of the line");
  }
  /// A decimal number of 1..largest.
  std::uint16_t decimal(std::string_view what, std::uint32_t largest);
  /// A number 0..largest, as the rules say.
  std::uint32_t number(std::string_view what, std::uint32_t largest);
  can::Frame data_frame();
  can::Frame remote_frame();

  const ScriptRules& rules_;
  std::vector<Word> words_;
  std::size_t at_ = 0;
  std::size_t end_column_ = 1;
  std::optional<LineProblem> problem_;
};

std::uint16_t LineReader::decimal(std::string_view what, std::uint32_t largest) {
  const auto value = left() == 0 ? std::nullopt : number_of(words_[at_].text, 10);
  if (!value || *value < 1 || *value > largest) {
    wrong(std::string(what) + ": " + found() + "; allowed: 1.." + std::to_string(largest));
    return 0;
  }
  ++at_;
  return static_cast<std::uint16_t>(*value);
}

std::uint32_t LineReader::number(std::string_view what, std::uint32_t largest) {
  std::optional<std::uint32_t> value;
  bool ambiguous = false;
  if (left() != 0) {
    const std::string_view text = words_[at_].text;
    if (text.starts_with("0x") || text.starts_with("0X")) {
      value = number_of(text.substr(2), 16);
    } else {
      ambiguous = rules_.numbers == ScriptNumbers::marked && text.size() > 1;
      value = number_of(text, rules_.numbers == ScriptNumbers::hexadecimal ? 16 : 10);
    }
  }
  if (ambiguous) {
    wrong(std::string(what) + ": " + found() +
          ", which may be meant decimal or hexadecimal; allowed: 0x and " +
          "hexadecimal digits, or one digit; or say with script.numbers what is meant");
    return 0;
  }
  if (!value || *value > largest) {
    wrong(std::string(what) + ": " + found() + "; allowed: 0.." + hex(largest));
    return 0;
  }
  ++at_;
  return *value;
}

can::Frame LineReader::data_frame() {
  can::Frame frame;
  frame.extended = rules_.extended;
  frame.id =
      number("identifier", frame.extended ? can::kExtendedIdentifierMask : can::kStandardIdentifierMask);
  if (problem_) return frame;
  const std::size_t place_of_length = at_;
  frame.dlc = static_cast<std::uint8_t>(number("length", 8));
  if (problem_) return frame;
  if (left() != frame.dlc) {
    const std::size_t bytes = left();
    at_ = place_of_length;
    wrong("length: " + found() + ", but " + std::to_string(bytes) + " data bytes follow");
    return frame;
  }
  for (std::size_t i = 0; i < frame.dlc && !problem_; ++i)
    frame.data[i] = static_cast<std::uint8_t>(number("data byte", 0xFF));
  return frame;
}

can::Frame LineReader::remote_frame() {
  can::Frame frame;
  frame.extended = rules_.extended;
  frame.remote = true;
  frame.id =
      number("identifier", frame.extended ? can::kExtendedIdentifierMask : can::kStandardIdentifierMask);
  if (!problem_ && left() != 0) frame.dlc = static_cast<std::uint8_t>(number("length", 8));
  return frame;
}

std::optional<ScriptCommand> LineReader::command() {
  using Kind = ScriptCommand::Kind;
  const std::string_view name = words_[0].text;
  ScriptCommand command;
  at_ = 1;
  if (is_word(name, "send")) {
    command.frame = data_frame();
  } else if (is_word(name, "fetch")) {
    command.frame = remote_frame();
  } else if (is_word(name, "start") || is_word(name, "stop")) {
    command.kind = is_word(name, "start") ? Kind::start : Kind::stop;
    command.number = decimal("timer", Timers::kMost);
  } else if (is_word(name, "wait")) {
    command.kind = Kind::wait;
    command.number = decimal("time in ms", 65535);
  } else {
    at_ = 0;
    wrong("command: " + found() + "; allowed: Send, Fetch, Start, Stop, Wait, //");
  }
  if (!problem_ && left() != 0)
    wrong(found() + " after the command; allowed: one command a line, or a comment after //");
  if (problem_) return std::nullopt;
  return command;
}

}  // namespace

Script parse_script(std::string_view text, const ScriptRules& rules) {
  Script script;
  std::size_t line_number = 0;
  while (!text.empty()) {
    ++line_number;
    const std::size_t end = text.find('\n');
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    LineReader reader(line, rules);
    if (reader.empty()) continue;
    const auto command = reader.command();
    if (!command) {
      script.problems.push_back({line_number, reader.problem().column, reader.problem().text});
      continue;
    }
    if (script.commands.size() == Script::kMostLines) {
      script.problems.push_back({line_number, 1, "one command more than the 100 that a script may have"});
      break;
    }
    script.commands.push_back(*command);
  }
  return script;
}

void ScriptRunner::begin(const Script& script) noexcept {
  script_ = &script;
  at_ = 0;
  until_ = Time::max();
  if (script.commands.empty() || !script.problems.empty()) end();
}

std::optional<ScriptCommand> ScriptRunner::next(Time now) noexcept {
  while (runs()) {
    if (until_ != Time::max()) {
      if (now < until_) return std::nullopt;
      until_ = Time::max();
      ++at_;
    }
    if (at_ >= script_->commands.size()) {
      end();
      break;
    }
    const ScriptCommand& command = script_->commands[at_];
    if (command.kind != ScriptCommand::Kind::wait) return command;
    until_ = now + std::chrono::milliseconds(command.number);
  }
  return std::nullopt;
}

}  // namespace layer2
