#include "dbc/reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <map>

#include "dbc/tokens.h"
#include "text/counts.h"

namespace dbc {
namespace {

constexpr std::uint32_t kExtendedFlag = 0x80000000;
/// The name that stands for signals of no message.
constexpr std::string_view kNoMessage = "VECTOR__INDEPENDENT_SIG_MSG";
constexpr unsigned kLongestSignal = 64;

/// Ends the reading of a statement.
struct Wrong {
  Token token;
  std::string expected;
};

std::string found_text(const Token& token) {
  if (token.kind == Token::Kind::end) return "the end of the file";
  if (token.broken) return "a text that does not end";
  constexpr std::size_t kMostShown = 40;
  return "'" + as_utf8(token.text.substr(0, kMostShown)) + "'";
}

/// A word such as BO_, with which a line begins a statement.
bool begins_statement(const Token& token) {
  const auto fits = [](char c) { return (c >= 'A' && c <= 'Z') || c == '_'; };
  return token.kind == Token::Kind::word && token.first && token.text.ends_with('_') &&
         std::all_of(token.text.begin(), token.text.end(), fits);
}

class Reader {
 public:
  explicit Reader(std::string_view text) : tokens_(text) {}

  std::variant<Database, std::vector<Problem>> read() {
    while (tokens_.next().kind != Token::Kind::end && problems_.size() < kMostProblems) {
      try {
        read_statement();
      } catch (const Wrong& wrong) {
        tell(wrong.token, fmt::format("found {}; allowed: {}", found_text(wrong.token), wrong.expected));
        pass_over();
      }
    }
    if (problems_.empty()) check_all();
    if (!problems_.empty()) return std::move(problems_);
    return Database(std::move(messages_));
  }

 private:
  void tell(const Token& token, std::string text) {
    if (problems_.size() < kMostProblems) problems_.push_back({token.line, token.column, std::move(text)});
  }

  // ---- pieces ----

  Token take(Token::Kind kind, std::string_view expected) {
    if (tokens_.next().kind != kind || tokens_.next().broken)
      throw Wrong{tokens_.next(), std::string(expected)};
    return tokens_.take();
  }
  bool next_is(char sign) const {
    return tokens_.next().kind == Token::Kind::sign && tokens_.next().text.front() == sign;
  }
  void take_sign(char sign) {
    if (!next_is(sign)) throw Wrong{tokens_.next(), fmt::format("'{}'", sign)};
    (void)tokens_.take();
  }
  std::uint64_t take_unsigned(std::uint64_t most, std::string_view what) {
    const std::string expected = fmt::format("{}, 0..{}", what, most);
    const Token token = take(Token::Kind::number, expected);
    std::uint64_t value = 0;
    const auto end = token.text.data() + token.text.size();
    const auto [at, error] = std::from_chars(token.text.data(), end, value);
    if (error != std::errc() || at != end || value > most) throw Wrong{token, expected};
    return value;
  }
  double take_real(std::string_view what) {
    const Token token = take(Token::Kind::number, what);
    const std::string_view digits = token.text.substr(token.text.starts_with('+') ? 1 : 0);
    double value = 0.0;
    const auto end = digits.data() + digits.size();
    const auto [at, error] = std::from_chars(digits.data(), end, value);
    if (error != std::errc() || at != end || !std::isfinite(value)) throw Wrong{token, std::string(what)};
    return value;
  }
  /// Goes to the next statement.
  void pass_over() {
    while (tokens_.next().kind != Token::Kind::end && !begins_statement(tokens_.next())) {
      const bool last = next_is(';');
      (void)tokens_.take();
      if (last) return;
    }
  }

  // ---- statements ----

  void read_statement() {
    const Token word = tokens_.take();
    if (word.text == "BO_" && word.kind == Token::Kind::word) {
      read_message();
    } else if (word.text == "SG_") {
      throw Wrong{word, "a signal only below its message (BO_)"};
    } else if (word.text == "VAL_") {
      read_words();
    } else if (word.text == "SIG_VALTYPE_") {
      read_number_kind();
    } else if (word.text == "NS_") {
      // Its lines are the words of statements.
      while (tokens_.next().kind != Token::Kind::end && tokens_.next().text != "BS_" &&
             tokens_.next().text != "BU_")
        (void)tokens_.take();
    } else {
      pass_over();
    }
  }

  void read_message() {
    const Token place = tokens_.next();
    const auto number = static_cast<std::uint32_t>(take_unsigned(UINT32_MAX, "the number of a message"));
    Message message;
    message.extended = (number & kExtendedFlag) != 0;
    message.identifier = number & ~kExtendedFlag;
    message.name = take(Token::Kind::word, "the name of a message").text;
    take_sign(':');
    message.length = static_cast<unsigned>(take_unsigned(kLongestMessage, "a length in bytes"));
    (void)take(Token::Kind::word, "the name of who sends it");
    while (tokens_.next().kind == Token::Kind::word && tokens_.next().text == "SG_") {
      (void)tokens_.take();
      message.signals.push_back(read_signal());
    }
    if (message.name == kNoMessage) return;
    const std::uint32_t most = message.extended ? can::kExtendedIdentifierMask : can::kStandardIdentifierMask;
    if (message.identifier > most)
      return tell(place,
                  fmt::format("found {}; allowed: 0..2047, or 2147483648 and up to 536870911 more for 29 "
                              "bits",
                              number));
    if (!place_.emplace(number, messages_.size()).second)
      return tell(
          place,
          fmt::format("found {}, which is the number of an earlier message; allowed: each once", number));
    messages_.push_back(std::move(message));
    places_.push_back(place);
  }

  Signal read_signal() {
    Signal signal;
    signal.name = take(Token::Kind::word, "the name of a signal").text;
    if (tokens_.next().kind == Token::Kind::word) read_choice(signal, tokens_.take());
    take_sign(':');
    signal.start = static_cast<unsigned>(take_unsigned(8 * kLongestMessage - 1, "a start bit"));
    take_sign('|');
    const Token length = tokens_.next();
    signal.length = static_cast<unsigned>(take_unsigned(kLongestSignal, "a length in bits"));
    if (signal.length == 0) throw Wrong{length, "a length in bits, 1..64"};
    take_sign('@');
    signal.little_endian = take_unsigned(1, "the order of bytes") == 1;
    if (next_is('-')) {
      signal.kind = NumberKind::signed_integer;
      (void)tokens_.take();
    } else {
      take_sign('+');
    }
    take_sign('(');
    signal.factor = take_real("a factor");
    take_sign(',');
    signal.offset = take_real("an offset");
    take_sign(')');
    take_sign('[');
    (void)take_real("a minimum");
    take_sign('|');
    (void)take_real("a maximum");
    take_sign(']');
    signal.unit = as_utf8(take(Token::Kind::text, "a unit between quotation marks").text);
    (void)take(Token::Kind::word, "the name of who receives it");
    while (next_is(',')) {
      (void)tokens_.take();
      (void)take(Token::Kind::word, "the name of who receives it");
    }
    return signal;
  }

  /// M, or m and a number.
  void read_choice(Signal& signal, const Token& word) const {
    constexpr std::string_view kExpected = "':', M, or m and a number (choice over one level alone)";
    if (word.text == "M") {
      signal.chooses = true;
      return;
    }
    std::uint64_t value = 0;
    const auto end = word.text.data() + word.text.size();
    const auto [at, error] = std::from_chars(word.text.data() + 1, end, value);
    if (word.text.front() != 'm' || error != std::errc() || at != end)
      throw Wrong{word, std::string(kExpected)};
    signal.chosen_by = value;
  }

  /// The signal that a statement names by its message and name; null: there is none, or none that counts.
  Signal* take_signal() {
    const auto number = static_cast<std::uint32_t>(take_unsigned(UINT32_MAX, "the number of a message"));
    const Token name = take(Token::Kind::word, "the name of a signal");
    const auto found = place_.find(number);
    if (found == place_.end()) return nullptr;
    auto& signals = messages_[found->second].signals;
    const auto signal = std::find_if(signals.begin(), signals.end(),
                                     [&name](const Signal& one) { return one.name == name.text; });
    if (signal == signals.end())
      throw Wrong{name, fmt::format("a signal of message {}", messages_[found->second].name)};
    return &*signal;
  }

  void read_words() {
    // Of an environment variable, which has no number of a message.
    if (tokens_.next().kind == Token::Kind::word) return pass_over();
    Signal* signal = take_signal();
    while (!next_is(';')) {
      const double raw = take_real("a raw value, or ';'");
      std::string word = as_utf8(take(Token::Kind::text, "a name between quotation marks").text);
      constexpr double kLargest = 9007199254740992.0;  // whole numbers up to here are exact
      if (signal != nullptr && std::abs(raw) <= kLargest)
        signal->words.emplace_back(static_cast<std::int64_t>(raw), std::move(word));
    }
    take_sign(';');
  }

  void read_number_kind() {
    Signal* signal = take_signal();
    if (next_is(':')) take_sign(':');
    const Token token = tokens_.next();
    const auto kind = take_unsigned(2, "0 (whole numbers), 1 (32 bits) or 2 (64 bits)");
    if (next_is(';')) take_sign(';');
    if (signal == nullptr || kind == 0) return;
    constexpr std::array<unsigned, 3> kLengths = {0, 32, 64};
    if (signal->length != kLengths[kind])
      throw Wrong{token,
                  fmt::format("the kind of a number that has {}", text::counted(signal->length, "bit"))};
    signal->kind = kind == 1 ? NumberKind::float32 : NumberKind::float64;
  }

  // ---- when all is read ----

  void check_all() {
    for (std::size_t i = 0; i < messages_.size(); ++i) {
      const Message& message = messages_[i];
      const std::vector<std::uint8_t> data(message.length);
      const auto beyond = std::find_if(message.signals.begin(), message.signals.end(),
                                       [&data](const Signal& one) { return !raw_bits(one, data); });
      if (beyond != message.signals.end())
        tell(places_[i], fmt::format("signal {} does not fit into the {} of message {}", beyond->name,
                                     text::counted(message.length, "byte"), message.name));
      const auto choosing = std::count_if(message.signals.begin(), message.signals.end(),
                                          [](const Signal& one) { return one.chooses; });
      if (choosing > 1)
        tell(places_[i],
             fmt::format("message {} has {} signals that choose (M); allowed: one", message.name, choosing));
    }
  }

  Tokens tokens_;
  std::vector<Message> messages_;
  std::vector<Token> places_;                   ///< of each message
  std::map<std::uint32_t, std::size_t> place_;  ///< by number as the file has it, in messages_
  std::vector<Problem> problems_;
};

}  // namespace

std::variant<Database, std::vector<Problem>> read_database(std::string_view text) {
  return Reader(text).read();
}

}  // namespace dbc
