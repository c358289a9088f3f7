#include "can/candump.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <ctime>
#include <optional>

namespace can {
namespace {

constexpr std::uint32_t kErrorFlag = 0x20000000;

// Appends to a buffer that is known to be large enough.
class Writer {
 public:
  explicit Writer(std::span<char> out) : out_(out) {}
  void put(char c) {
    if (size_ < out_.size()) out_[size_++] = c;
  }
  void put(std::string_view text) {
    for (const char c : text) put(c);
  }
  void hex(std::uint32_t value, unsigned digits) {
    while (digits-- > 0) put("0123456789ABCDEF"[(value >> (4 * digits)) & 0xF]);
  }
  void decimal(std::uint64_t value, unsigned least_digits) {
    char digits[20];
    unsigned count = 0;
    do {
      digits[count++] = static_cast<char>('0' + value % 10);
      value /= 10;
    } while (value != 0);
    for (unsigned i = count; i < least_digits; ++i) put('0');
    while (count > 0) put(digits[--count]);
  }
  std::size_t size() const { return size_; }

 private:
  std::span<char> out_;
  std::size_t size_ = 0;
};

constexpr unsigned kNoDigit = 0xFF;

constexpr auto kHexDigits = [] {
  std::array<std::uint8_t, 256> digits{};
  digits.fill(kNoDigit);
  for (unsigned i = 0; i < 10; ++i) digits['0' + i] = static_cast<std::uint8_t>(i);
  for (unsigned i = 0; i < 6; ++i) digits['A' + i] = digits['a' + i] = static_cast<std::uint8_t>(10 + i);
  return digits;
}();

/// 0 to 15, or `kNoDigit`.
unsigned hex_digit(char c) {
  return kHexDigits[static_cast<std::uint8_t>(c)];
}

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

// "found 'x'" or "found the end of the line".
std::string found(std::string_view text, std::size_t at) {
  if (at >= text.size()) return "found the end of the text";
  return "found '" + std::string(1, text[at]) + "'";
}

CandumpError error(std::string_view text, std::size_t at, const std::string& expected) {
  return {at + 1, "expected " + expected + ", " + found(text, at)};
}

// Reads the digits of one number; nothing when there are none or more than `most`.
std::optional<std::uint64_t> take_decimal(std::string_view text, std::size_t& at, std::size_t most) {
  const std::size_t begin = at;
  std::uint64_t value = 0;
  while (at < text.size() && is_digit(text[at]) && at - begin < most) {
    value = value * 10 + static_cast<std::uint64_t>(text[at++] - '0');
  }
  if (at == begin) return std::nullopt;
  return value;
}

// "#80:03:0000ABCD#": flags, type and acceptance field, which CAN XL alone has behind its identifier.
bool is_can_xl(std::string_view text) {
  return text.size() > 6 && text[0] == '#' && text[3] == ':' && text[6] == ':';
}

// Identifier and flags; `at` ends behind the '#'.
std::variant<Frame, CandumpError> parse_identifier(std::string_view text, std::size_t& at) {
  Frame frame;
  std::size_t digits = 0;
  while (at < text.size() && digits <= 8) {
    const unsigned digit = hex_digit(text[at]);
    if (digit == kNoDigit) break;
    frame.id = (frame.id << 4) | digit;
    ++digits;
    ++at;
  }
  if (is_can_xl(text.substr(at))) return CandumpError{1, "CAN XL frames are not supported"};
  if (digits != 3 && digits != 8) {
    return CandumpError{1,
                        "expected an identifier of 3 (standard) or 8 (extended) hexadecimal digits, found " +
                            std::to_string(digits) + (digits > 8 ? " or more" : "") + " digits"};
  }
  if (digits == 3 && frame.id > kStandardIdentifierMask) {
    return CandumpError{1, "identifier " + std::string(text.substr(0, 3)) +
                               " is over 7FF; larger ones are written with 8 digits"};
  }
  if (digits == 8 && (frame.id & ~(kExtendedIdentifierMask | kErrorFlag)) != 0) {
    return CandumpError{1, "identifier " + std::string(text.substr(0, 8)) + " is over 1FFFFFFF"};
  }
  if (at >= text.size() || text[at] != '#') return error(text, at, "'#' after the identifier");
  ++at;
  if (at < text.size() && text[at] == '#')
    return CandumpError{at + 1, "CAN FD frames ('##') are not supported"};
  if (digits == 8) {
    frame.error = (frame.id & kErrorFlag) != 0;
    frame.extended = !frame.error;
    frame.id &= kExtendedIdentifierMask;
  }
  return frame;
}

// 9 to F: of a frame of 8 bytes the code of its length that was on the bus.
bool is_length_code(char c) {
  return hex_digit(c) > 8 && hex_digit(c) != kNoDigit;
}

// "_9" to "_F" at the end, as cansend takes the code behind a length of 8.
bool ends_in_length_code(std::string_view text, std::size_t at) {
  return at + 2 == text.size() && text[at] == '_' && is_length_code(text[at + 1]);
}

// Data bytes, or the R of a remote frame with its optional length.
std::optional<CandumpError> parse_data(std::string_view text, std::size_t at, Frame& frame) {
  if (at < text.size() && (text[at] == 'R' || text[at] == 'r') && !frame.error) {
    frame.remote = true;
    ++at;
    if (at < text.size() && text[at] >= '0' && text[at] <= '8') {
      frame.dlc = static_cast<std::uint8_t>(text[at++] - '0');
    }
    if (at != text.size() && !(frame.dlc == 8 && ends_in_length_code(text, at)))
      return error(text, at, "at most one length digit 0..8 after 'R'");
    return std::nullopt;
  }
  for (; at < text.size(); at += 2) {
    // As cansend takes them: a '.' between two bytes.
    if (text[at] == '.' && frame.dlc > 0 && at + 1 < text.size()) ++at;
    if (frame.dlc == 8 && ends_in_length_code(text, at)) return std::nullopt;
    const unsigned high = hex_digit(text[at]);
    if (high == kNoDigit) return error(text, at, "a hexadecimal digit");
    if (frame.dlc == 8) return CandumpError{at + 1, "more than 8 data bytes"};
    const unsigned low = at + 1 < text.size() ? hex_digit(text[at + 1]) : kNoDigit;
    if (low == kNoDigit) return error(text, at + 1, "the second hexadecimal digit of a byte");
    frame.data[frame.dlc++] = static_cast<std::uint8_t>((high << 4) | low);
  }
  return std::nullopt;
}

// "2009-02-13 23:31:30", in the time zone of this computer; nothing: it is none.
std::optional<std::uint64_t> take_date(std::string_view line, std::size_t& at) {
  constexpr std::string_view kForm = "dddd-dd-dd dd:dd:dd";
  const std::string_view text = line.substr(at, kForm.size());
  for (std::size_t i = 0; i < kForm.size(); ++i)
    if (i >= text.size() || (kForm[i] == 'd' ? !is_digit(text[i]) : text[i] != kForm[i])) return std::nullopt;
  const auto number = [text](std::size_t from, std::size_t digits) {
    return static_cast<int>(*take_decimal(text, from, digits));
  };
  std::tm date = {};
  date.tm_year = number(0, 4) - 1900;
  date.tm_mon = number(5, 2) - 1;
  date.tm_mday = number(8, 2);
  date.tm_hour = number(11, 2);
  date.tm_min = number(14, 2);
  date.tm_sec = number(17, 2);
  date.tm_isdst = -1;
  const std::time_t seconds = std::mktime(&date);
  if (seconds < 0) return std::nullopt;
  at += kForm.size();
  return static_cast<std::uint64_t>(seconds);
}

// "(seconds.micros)", with nine digits of nanoseconds, or with a date; `at` ends behind the ')'.
std::variant<std::chrono::microseconds, CandumpError> parse_time(std::string_view line, std::size_t& at) {
  if (line.empty() || line[0] != '(') return error(line, 0, "'(' before the time stamp");
  at = 1;
  auto seconds = take_date(line, at);
  if (!seconds) seconds = take_decimal(line, at, 12);
  if (!seconds) return error(line, at, "the seconds of the time stamp");
  if (at >= line.size() || line[at] != '.') return error(line, at, "'.' after the seconds");
  const std::size_t begin = ++at;
  const auto fraction = take_decimal(line, at, 9);
  const std::size_t digits = at - begin;
  if (!fraction || (digits != 6 && digits != 9))
    return error(line, at, "six digits of microseconds, or nine of nanoseconds");
  if (at >= line.size() || line[at] != ')') return error(line, at, "')' after the time stamp");
  ++at;
  return std::chrono::microseconds(*seconds * 1'000'000 + (digits == 9 ? *fraction / 1000 : *fraction));
}

// The next word after spaces; `at` ends behind it, `begin` is where it starts.
std::string_view take_word(std::string_view line, std::size_t& at, std::size_t& begin) {
  while (at < line.size() && line[at] == ' ') ++at;
  begin = at;
  while (at < line.size() && line[at] != ' ') ++at;
  return line.substr(begin, at - begin);
}

}  // namespace

bool is_interface_name(std::string_view name) noexcept {
  return !name.empty() && name.size() <= kInterfaceNameLimit &&
         std::all_of(name.begin(), name.end(), [](char c) { return c > ' ' && c < '\x7f'; });
}

std::size_t write_candump_line(std::chrono::microseconds time, std::string_view interface, const Frame& frame,
                               std::span<char, kCandumpLineLimit> out) noexcept {
  const auto micros = static_cast<std::uint64_t>(std::max<std::int64_t>(time.count(), 0));
  Writer writer(out);
  writer.put('(');
  writer.decimal(micros / 1'000'000, 10);
  writer.put('.');
  writer.decimal(micros % 1'000'000, 6);
  writer.put(") ");
  writer.put(interface.substr(0, kInterfaceNameLimit));
  writer.put(' ');
  writer.hex(frame.identifier() | (frame.error ? kErrorFlag : 0), frame.error || frame.extended ? 8 : 3);
  writer.put('#');
  const unsigned length = std::min<unsigned>(frame.dlc, 8);
  if (frame.remote) {
    writer.put('R');
    if (length != 0) writer.decimal(length, 1);
  } else {
    for (unsigned i = 0; i < length; ++i) writer.hex(frame.data[i], 2);
  }
  writer.put('\n');
  return writer.size();
}

std::variant<Frame, CandumpError> parse_candump_frame(std::string_view text) {
  std::size_t at = 0;
  auto result = parse_identifier(text, at);
  if (auto* frame = std::get_if<Frame>(&result)) {
    if (auto wrong = parse_data(text, at, *frame)) return *wrong;
  }
  return result;
}

namespace {

// The bytes of a line of the screen; `at` stands behind the length, as many are to come.
std::optional<CandumpError> parse_screen_bytes(std::string_view line, std::size_t at, unsigned length,
                                               Frame& frame) {
  std::size_t begin = 0;
  std::string_view word = take_word(line, at, begin);
  frame.dlc = static_cast<std::uint8_t>(length);
  if (word == "remote" && !frame.error) {
    frame.remote = true;
    length = 0;
    word = take_word(line, at, begin);
    if (word == "request") word = take_word(line, at, begin);
  }
  for (unsigned i = 0; i < length; ++i, word = take_word(line, at, begin)) {
    const unsigned high = word.empty() ? kNoDigit : hex_digit(word[0]);
    const unsigned low = word.size() == 2 ? hex_digit(word[1]) : kNoDigit;
    if (high == kNoDigit || low == kNoDigit) return error(line, begin, "a byte of two hexadecimal digits");
    frame.data[i] = static_cast<std::uint8_t>((high << 4) | low);
  }
  // Behind them candump may show characters, or what an error frame says.
  if (!word.empty() && word.front() != '\'' && word != "ERRORFRAME")
    return error(line, begin, "the end of the line");
  return std::nullopt;
}

// A line as candump shows it on a screen; nothing: it is none.
std::optional<std::variant<CandumpLine, CandumpError>> parse_screen_line(std::string_view line) {
  if (line.find_first_of("[{") == line.npos) return std::nullopt;
  CandumpLine result;
  std::size_t at = std::min(line.find_first_not_of(' '), line.size());
  if (at < line.size() && line[at] == '(') {
    std::size_t end = 0;
    const auto time = parse_time(line.substr(at), end);
    if (!std::holds_alternative<std::chrono::microseconds>(time)) return std::nullopt;
    result.time = std::get<std::chrono::microseconds>(time);
    at += end;
  }
  std::size_t begin = 0;
  result.interface = take_word(line, at, begin);
  std::string_view word = take_word(line, at, begin);
  while (word == "RX" || word == "TX" || word == "-") word = take_word(line, at, begin);
  const std::string identifier = std::string(word) + '#';
  const std::size_t identifier_begin = begin;
  std::string_view length = take_word(line, at, begin);
  // "{F}", as candump -8 shows such a code.
  if (length.size() == 3 && length.front() == '{' && length.back() == '}' && is_length_code(length[1]))
    length = "[8]";
  if (!is_interface_name(result.interface) || length.size() < 3 || length.front() != '[' ||
      length.back() != ']')
    return std::nullopt;
  if (length.size() == 4)
    return CandumpError{begin + 1, "CAN FD frames ('" + std::string(length) + "') are not supported"};
  if (length.size() == 6)
    return CandumpError{begin + 1, "CAN XL frames ('" + std::string(length) + "') are not supported"};
  if (length.size() != 3 || length[1] < '0' || length[1] > '8')
    return CandumpError{begin + 1, "expected a length of [0] to [8], found '" + std::string(length) + "'"};
  std::size_t ignored = 0;
  auto frame = parse_identifier(identifier, ignored);
  if (auto* wrong = std::get_if<CandumpError>(&frame))
    return CandumpError{identifier_begin + wrong->column, wrong->message};
  if (ignored != identifier.size())
    return error(line, identifier_begin + ignored - 1, "a space behind the identifier");
  result.frame = std::get<Frame>(frame);
  if (auto wrong = parse_screen_bytes(line, at, static_cast<unsigned>(length[1] - '0'), result.frame))
    return *wrong;
  return result;
}

}  // namespace

std::variant<CandumpLine, CandumpError> parse_candump_line(std::string_view line) {
  while (!line.empty() && (line.back() == '\n' || line.back() == '\r')) line.remove_suffix(1);
  if (auto screen = parse_screen_line(line)) return *screen;
  CandumpLine result;
  std::size_t at = 0;
  auto time = parse_time(line, at);
  if (auto* wrong = std::get_if<CandumpError>(&time)) return *wrong;
  result.time = std::get<std::chrono::microseconds>(time);

  std::size_t begin = 0;
  const std::string_view interface = take_word(line, at, begin);
  if (!is_interface_name(interface)) {
    return CandumpError{begin + 1, "expected an interface name of 1 to 15 characters, found '" +
                                       std::string(interface) + "'"};
  }
  result.interface = interface;

  auto frame = parse_candump_frame(take_word(line, at, begin));
  if (auto* wrong = std::get_if<CandumpError>(&frame)) {
    return CandumpError{begin + wrong->column, wrong->message};
  }
  result.frame = std::get<Frame>(frame);

  const std::string_view rest = take_word(line, at, begin);
  if (!rest.empty() && rest != "R" && rest != "T") {
    return CandumpError{begin + 1,
                        "expected the end of the line, 'R' or 'T', found '" + std::string(rest) + "'"};
  }
  if (at < line.size()) return error(line, at, "the end of the line");
  return result;
}

}  // namespace can
