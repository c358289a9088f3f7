#include "cli/cansync/passport.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <stdexcept>
#include <variant>

#include "cli/text/slave_list.h"
#include "profile/hash.h"
#include "profile/reader.h"
#include "profile/scaling.h"
#include "text/text_file.h"

namespace cansync::cli {
namespace {

constexpr std::string_view kFirstLine = "# CANsync drive passport, version 1; docs/passport.md";
constexpr std::string_view kNone = "-";
constexpr unsigned kHighestParameter = 4095;
constexpr std::size_t kFields = 7;

std::string_view keyword(profile::Identity identity) noexcept {
  switch (identity) {
    case profile::Identity::type:
      return "type";
    case profile::Identity::unit:
      return "unit";
    case profile::Identity::none:
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
                     entry.number, entry.name, profile::name(entry.format),
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
    if (word == "bus") return take_text(rest, passport_.bus, "bus NAME");
    if (word == "taken") return take_text(rest, passport_.taken, "taken TIME");
    if (word == "slave") return take_slave(rest);
    if (word == "profile") return take_profile(rest);
    if (word == "parameter") return take_entry(rest, profile::Identity::none);
    if (word == "type") return take_entry(rest, profile::Identity::type);
    if (word == "unit") return take_entry(rest, profile::Identity::unit);
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
    const auto twice = std::adjacent_find(
        entries.begin(), entries.end(),
        [](const PassportEntry& a, const PassportEntry& b) { return a.number == b.number; });
    if (twice != entries.end()) problem = fmt::format("parameter {} is there twice", twice->number);
    return std::move(passport_);
  }

 private:
  static std::string take_text(std::string_view rest, std::string& text, std::string_view allowed) {
    if (rest.empty() || !text.empty()) return fmt::format("allowed: '{}' once", allowed);
    text = rest;
    return "";
  }

  std::string take_slave(std::string_view rest) {
    if (slave_known_ || !to_number(take_word(rest), kSlaves - 1, passport_.slave)) {
      return "allowed: 'slave NUMBER NAME' once, with a number 0..31";
    }
    passport_.slave_name = rest;
    slave_known_ = true;
    return "";
  }

  std::string take_profile(std::string_view rest) {
    const std::string_view name = take_word(rest);
    const std::string_view hash = take_word(rest);
    if (!passport_.profile.empty() || !profile::is_name(name) || hash.empty() || !rest.empty()) {
      return "allowed: 'profile NAME HASH' once";
    }
    passport_.profile = name;
    passport_.profile_hash = hash;
    return "";
  }

  std::string take_entry(std::string_view rest, profile::Identity identity) {
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
    if (!profile::is_name(name)) return not_allowed(name, "a name of lower-case letters, digits and '-'");
    entry.name = name;
    if (format != "word" && format != "doubleword") return not_allowed(format, "word, doubleword");
    entry.format = format == "word" ? profile::Format::word : profile::Format::doubleword;
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
  return {std::nullopt, false, line, std::move(problem)};
}

}  // namespace

const PassportEntry* Passport::find(std::uint32_t number) const noexcept {
  const auto place =
      std::lower_bound(entries.begin(), entries.end(), number,
                       [](const PassportEntry& entry, std::uint32_t n) { return entry.number < n; });
  return place != entries.end() && place->number == number ? &*place : nullptr;
}

PassportEntry passport_entry(const profile::Parameter& parameter, std::optional<std::uint32_t> raw) {
  PassportEntry entry;
  entry.number = parameter.number;
  entry.name = parameter.name;
  entry.format = parameter.format;
  entry.raw = raw;
  if (raw) entry.value = profile::scaled_text(parameter, profile::raw_number(parameter, *raw));
  entry.unit = parameter.unit;
  entry.read_only = parameter.access != profile::Access::read_write;
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
    if (entry.identity != profile::Identity::none) text += line_of(entry);
  }
  for (const PassportEntry& entry : passport.entries) {
    if (entry.identity == profile::Identity::none) text += line_of(entry);
  }
  return text + fmt::format("sha256 {}\n", profile::sha256(text));
}

PassportReading parse_passport(std::string_view text) {
  if (!text.starts_with(kFirstLine)) {
    return wrong(1, fmt::format("this is no passport; allowed: a file that begins with '{}'", kFirstLine));
  }
  Parser parser;
  std::size_t line = 0;
  for (std::size_t at = 0; at < text.size();) {
    ++line;
    const std::size_t end = std::min(text.find('\n', at), text.size());
    std::string_view rest = text.substr(at, end - at);
    if (rest.starts_with("sha256 ")) {
      if (end + 1 < text.size()) return wrong(line + 1, "something stands behind the checksum");
      take_word(rest);
      PassportReading reading;
      reading.passport = parser.finish(reading.problem);
      if (!reading.problem.empty()) return wrong(line, reading.problem);
      reading.changed = rest != profile::sha256(text.substr(0, at));
      return reading;
    }
    if (std::string problem = parser.take(rest); !problem.empty()) return wrong(line, std::move(problem));
    at = end + 1;
  }
  return wrong(line, "the last line, sha256, is missing; the file is not complete");
}

Passport read_passport(const std::string& path, bool& changed) {
  const auto content = text::read_file(path, kPassportLimit);
  if (const auto* problem = std::get_if<text::FileProblem>(&content)) {
    throw std::runtime_error(fmt::format("{}: {}", path, problem->text));
  }
  PassportReading reading = parse_passport(std::get<std::string>(content));
  if (!reading.passport)
    throw std::runtime_error(fmt::format("{}:{}: {}", path, reading.line, reading.problem));
  changed = reading.changed;
  return std::move(*reading.passport);
}

}  // namespace cansync::cli
