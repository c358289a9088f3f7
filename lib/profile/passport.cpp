#include "profile/passport.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <stdexcept>
#include <utility>
#include <variant>

#include "profile/hash.h"
#include "profile/reader.h"
#include "profile/scaling.h"
#include "text/foreign_file.h"
#include "text/text_file.h"

namespace profile {
namespace {

constexpr std::string_view kFirstLine = "# CANsync drive passport, version 1; docs/passport.md";
constexpr std::string_view kNone = "-";
constexpr unsigned kHighestParameter = 4095;
constexpr std::size_t kFields = 7;
constexpr unsigned kHighestSlave = 31;

std::string_view keyword(Identity identity) noexcept {
  switch (identity) {
    case Identity::type:
      return "type";
    case Identity::unit:
      return "unit";
    case Identity::none:
      break;
  }
  return "parameter";
}

std::string_view marks(const PassportEntry& entry) noexcept {
  if (entry.is_volatile) return entry.read_only ? "read-only,volatile" : "read-write,volatile";
  return entry.read_only ? "read-only" : "read-write";
}

/// Widths do not depend on other lines, so that a changed value changes its line alone.
std::string line_of(const PassportEntry& entry) {
  return fmt::format("{:<9} {:>4} {:<28} {:<10} {:>10} {:>14} {:<8} {}\n", keyword(entry.identity),
                     entry.number, entry.name, name(entry.format),
                     entry.raw ? std::to_string(*entry.raw) : std::string(kNone),
                     entry.value.empty() ? kNone : std::string_view(entry.value),
                     entry.unit.empty() ? kNone : std::string_view(entry.unit), marks(entry));
}

template <class T>
bool to_number(std::string_view text, T most, T& number) noexcept {
  const auto* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, number);
  return !text.empty() && error == std::errc{} && stop == end && number <= most;
}

/// The first word of `text`, which loses it and the blanks around it.
std::string_view take_word(std::string_view& text) noexcept {
  text.remove_prefix(std::min(text.find_first_not_of(' '), text.size()));
  const std::string_view word = text.substr(0, text.find(' '));
  text.remove_prefix(word.size());
  text.remove_prefix(std::min(text.find_first_not_of(' '), text.size()));
  return word;
}

/// Reads a passport line by line.
class Parser {
 public:
  /// Takes one line before the checksum; empty, or what is wrong with it.
  std::string take(std::string_view line) {
    std::string_view rest = line;
    const std::string_view word = take_word(rest);
    if (word.empty() || word.starts_with('#')) return "";
    if (std::any_of(line.begin(), line.end(), [](unsigned char c) { return c < ' ' || c == 0x7F; }))
      return "found a control character; allowed: text";
    if (word == "bus") return take_text(rest, passport_.bus, "bus NAME");
    if (word == "taken") return take_text(rest, passport_.taken, "taken TIME");
    if (word == "slave") return take_slave(rest);
    if (word == "profile") return take_profile(rest);
    if (word == "parameter") return take_entry(rest, Identity::none);
    if (word == "type") return take_entry(rest, Identity::type);
    if (word == "unit") return take_entry(rest, Identity::unit);
    return fmt::format("found '{}'; allowed: bus, slave, profile, taken, type, unit, parameter, sha256",
                       word);
  }

  /// Everything read; `problem` says what is missing.
  Passport finish(std::string& problem) {
    if (passport_.bus.empty()) problem = "a line 'bus NAME' is missing";
    if (!slave_known_) problem = "a line 'slave NUMBER NAME' is missing";
    if (passport_.profile.empty()) problem = "a line 'profile NAME HASH' is missing";
    auto& entries = passport_.entries;
    std::sort(entries.begin(), entries.end(),
              [](const PassportEntry& a, const PassportEntry& b) { return a.number < b.number; });
    return std::move(passport_);
  }

 private:
  static std::string take_text(std::string_view rest, std::string& text, std::string_view allowed) {
    if (rest.empty() || !text.empty()) return fmt::format("allowed: '{}' once", allowed);
    text = rest;
    return "";
  }

  std::string take_slave(std::string_view rest) {
    if (slave_known_ || !to_number(take_word(rest), kHighestSlave, passport_.slave)) {
      return "allowed: 'slave NUMBER NAME' once, with a number 0..31";
    }
    passport_.slave_name = rest;
    slave_known_ = true;
    return "";
  }

  std::string take_profile(std::string_view rest) {
    const std::string_view name = take_word(rest);
    const std::string_view hash = take_word(rest);
    if (!passport_.profile.empty() || !is_name(name) || hash.empty() || !rest.empty()) {
      return "allowed: 'profile NAME HASH' once";
    }
    passport_.profile = name;
    passport_.profile_hash = hash;
    return "";
  }

  std::string take_entry(std::string_view rest, Identity identity) {
    std::array<std::string_view, kFields> field;
    for (std::string_view& word : field) word = take_word(rest);
    const auto [number, name, format, raw, value, unit, mark] = field;
    PassportEntry entry;
    entry.identity = identity;
    unsigned found = 0;
    if (mark.empty() || !rest.empty()) {
      return "allowed: seven words: NUMBER NAME FORMAT RAW VALUE UNIT ACCESS";
    }
    if (!to_number(number, kHighestParameter, found)) return not_allowed(number, "a number 0..4095");
    entry.number = static_cast<std::uint16_t>(found);
    if (!is_name(name)) return not_allowed(name, "a name of lower-case letters, digits and '-'");
    entry.name = name;
    if (format != "word" && format != "doubleword") return not_allowed(format, "word, doubleword");
    entry.format = format == "word" ? Format::word : Format::doubleword;
    if (raw != kNone) {
      const std::uint32_t most = format == "word" ? 0xFFFFu : 0xFFFFFFFFu;
      std::uint32_t number_raw = 0;
      if (!to_number(raw, most, number_raw))
        return not_allowed(raw, fmt::format("a raw value 0..{}, or -", most));
      entry.raw = number_raw;
    }
    if (value != kNone) entry.value = value;
    if (unit != kNone) entry.unit = unit;
    entry.read_only = mark.starts_with("read-only");
    entry.is_volatile = mark.ends_with(",volatile");
    if (mark != marks(entry))
      return not_allowed(mark, "read-only or read-write, with ,volatile behind or not");
    passport_.entries.push_back(std::move(entry));
    return "";
  }

  static std::string not_allowed(std::string_view found, std::string_view allowed) {
    return fmt::format("found '{}'; allowed: {}", found, allowed);
  }

  Passport passport_;
  bool slave_known_ = false;
};

PassportReading wrong(std::size_t line, std::string problem) {
  PassportReading reading;
  reading.line = line;
  reading.problem = std::move(problem);
  return reading;
}

void leave_out(PassportReading& reading, std::size_t line, std::string_view why) {
  reading.changed = true;
  if (reading.left_out.size() < kMostLeftOut) {
    reading.left_out.push_back(fmt::format("{}: {}", line, why));
  } else {
    ++reading.more_left_out;
  }
}

/// Of a parameter that is there twice none counts: which of them is right is not known.
void leave_out_doubles(PassportReading& reading, std::size_t last_line) {
  std::vector<PassportEntry>& entries = reading.passport->entries;
  for (std::size_t i = 1; i < entries.size();) {
    const std::uint16_t number = entries[i].number;
    if (entries[i - 1].number != number) {
      ++i;
      continue;
    }
    leave_out(reading, last_line,
              fmt::format("parameter {} is there twice; all its lines are left out", number));
    std::erase_if(entries, [number](const PassportEntry& one) { return one.number == number; });
    i = 1;
  }
}

/// The text without what an editor of another system adds: a mark of UTF-8, ends of lines of two characters.
std::string as_written(std::string_view content) {
  content = text::without_mark(content);
  std::string text;
  text.reserve(content.size());
  for (std::size_t i = 0; i < content.size(); ++i)
    if (!content.substr(i).starts_with("\r\n")) text += content[i];
  return text;
}

}  // namespace

const PassportEntry* Passport::find(std::uint32_t number) const noexcept {
  const auto place =
      std::lower_bound(entries.begin(), entries.end(), number,
                       [](const PassportEntry& entry, std::uint32_t n) { return entry.number < n; });
  return place != entries.end() && place->number == number ? &*place : nullptr;
}

PassportEntry passport_entry(const Parameter& parameter, std::optional<std::uint32_t> raw) {
  PassportEntry entry;
  entry.number = parameter.number;
  entry.name = parameter.name;
  entry.format = parameter.format;
  entry.raw = raw;
  if (raw) entry.value = scaled_text(parameter, raw_number(parameter, *raw));
  entry.unit = parameter.unit;
  entry.read_only = parameter.access != Access::read_write;
  entry.is_volatile = parameter.is_volatile;
  entry.identity = parameter.identity;
  return entry;
}

std::string passport_text(const Passport& passport) {
  std::string text = fmt::format("{}\nbus {}\nslave {}{}{}\nprofile {} {}\n", kFirstLine, passport.bus,
                                 passport.slave, passport.slave_name.empty() ? "" : " ", passport.slave_name,
                                 passport.profile, passport.profile_hash);
  if (!passport.taken.empty()) text += fmt::format("taken {}\n", passport.taken);
  for (const PassportEntry& entry : passport.entries) {
    if (entry.identity != Identity::none) text += line_of(entry);
  }
  for (const PassportEntry& entry : passport.entries) {
    if (entry.identity == Identity::none) text += line_of(entry);
  }
  return text + fmt::format("sha256 {}\n", sha256(text));
}

PassportReading parse_passport(std::string_view content) {
  const std::string text = as_written(content);
  if (!text.starts_with(kFirstLine)) {
    const std::string recognized = text::recognized_in_place_of_own(text);
    return wrong(1, fmt::format("this is no passport{}{}; allowed: a file that begins with '{}'",
                                recognized.empty() ? "" : ": ", recognized, kFirstLine));
  }
  Parser parser;
  PassportReading reading;
  std::size_t line = 0;
  bool complete = false;
  for (std::size_t at = 0; at < text.size() && !complete;) {
    ++line;
    const std::size_t end = std::min(text.find('\n', at), text.size());
    std::string_view rest = std::string_view(text).substr(at, end - at);
    if (rest.starts_with("sha256 ")) {
      complete = true;
      take_word(rest);
      reading.changed = reading.changed || rest != sha256(std::string_view(text).substr(0, at));
      if (end + 1 < text.size())
        leave_out(reading, line + 1, "something is behind the checksum; it is left out");
    } else if (const std::string problem = parser.take(rest); !problem.empty()) {
      leave_out(reading, line, problem + "; the line is left out");
    }
    at = end + 1;
  }
  if (!complete) leave_out(reading, line, "the last line, sha256, is missing; the file is not complete");
  std::string problem;
  reading.passport = parser.finish(problem);
  leave_out_doubles(reading, line);
  if (problem.empty() && reading.passport->entries.empty() && !reading.left_out.empty())
    problem = "no parameter can be used; the first of what is wrong is in line " + reading.left_out.front();
  return problem.empty() ? reading : wrong(line, std::move(problem));
}

PassportReading read_passport(const std::string& path) {
  const auto content = text::read_file(path, kPassportLimit);
  if (const auto* problem = std::get_if<text::FileProblem>(&content)) {
    throw std::runtime_error(fmt::format("{}: {}", path, problem->text));
  }
  PassportReading reading = parse_passport(std::get<std::string>(content));
  if (!reading.passport)
    throw std::runtime_error(fmt::format("{}:{}: {}", path, reading.line, reading.problem));
  for (std::string& one : reading.left_out) one = fmt::format("{}:{}", path, one);
  return reading;
}

}  // namespace profile
