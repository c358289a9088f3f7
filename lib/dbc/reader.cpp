#include "dbc/reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <map>
#include <optional>
#include <set>
#include <tuple>
#include <unordered_map>

#include "dbc/choices.h"
#include "dbc/encode.h"
#include "dbc/foreign_text.h"
#include "dbc/pieces.h"
#include "text/counts.h"
#include "text/foreign_file.h"

namespace dbc {
namespace {

constexpr std::uint32_t kExtendedFlag = 0x80000000;
/// The name that stands for signals of no message.
constexpr std::string_view kNoMessage = "VECTOR__INDEPENDENT_SIG_MSG";
constexpr unsigned kLongestNumber = 64;
constexpr unsigned kByteBits = 8;
constexpr std::uint64_t kMostBits = std::uint64_t{kByteBits} * kLongestMessage;

/// A signal that a statement names.
struct Named {
  std::size_t message;  ///< in the list of messages
  std::size_t signal;   ///< in the message
};

/// A message while its file is read.
struct OpenMessage {
  Message message;
  Choices choices;
  std::vector<Token> places;                                  ///< of its signals
  std::unordered_map<std::string_view, std::size_t> signals;  ///< by the name that the file has first
  std::set<std::string_view> left_out;                        ///< names of signals
  std::map<std::size_t, std::string> long_names;              ///< by place in the message
};

class Reader {
 public:
  explicit Reader(std::string_view text) : text_(text), pieces_(text::without_mark(text)) {}

  File read() {
    while (!pieces_.next_is(Token::Kind::end)) read_statement();
    for (OpenMessage& open : messages_) close(open);
    File& file = file_;
    std::vector<Message> messages;
    for (OpenMessage& open : messages_) messages.push_back(std::move(open.message));
    if (messages.empty()) {
      const std::string recognized = text::recognized_text(text_);
      file.refused = "no message (BO_) is in this file" + (recognized.empty() ? "" : "; " + recognized);
    }
    file.database = Database(std::move(messages));
    return std::move(file);
  }

 private:
  void remark(const Token& token, std::string text) {
    if (file_.remarks.size() >= kMostRemarks)
      ++file_.more_remarks;
    else
      file_.remarks.push_back({token.line, token.column, std::move(text)});
  }

  // ---- statements ----

  void read_statement() {
    if (pieces_.next_is('#') && pieces_.at_foreign_line()) return leave_line("a statement of a DBC file");
    const Token word = pieces_.take();
    try {
      if (word.kind == Token::Kind::word && word.text == "BO_") return read_message(word);
      if (word.kind == Token::Kind::word && word.text == "SG_") return leave_signal(word);
      if (word.text == "VAL_") return read_words();
      if (word.text == "SIG_VALTYPE_") return read_number_kind();
      if (word.text == "SG_MUL_VAL_") return read_ranges();
      if (word.text == "BA_") return read_attribute();
    } catch (const Wrong& wrong) {
      remark(wrong.token, fmt::format("{}; this {} is left out", wrong_text(wrong), word.text));
      pieces_.end_line();
      (void)pieces_.skip_statement();
      return;
    }
    const bool separator = word.kind == Token::Kind::sign && word.text == ";";
    if (separator) return;
    if (word.kind != Token::Kind::word || !is_keyword(word.text))
      remark(word,
             fmt::format("found {}; allowed: a statement of a DBC file; it is left out up to the next one",
                         found_text(word)));
    if (const auto broken = pieces_.skip_statement())
      remark(*broken, "found a text that does not end; it is left out up to the next statement");
  }

  /// A line of its own among the statements, such as a remark.
  void leave_line(std::string_view allowed) {
    remark(pieces_.next(),
           fmt::format("found {}; allowed: {}; the line is left out", found_text(pieces_.next()), allowed));
    pieces_.skip_line();
  }

  /// A signal that is below no message: the remark on the message says it of all of them.
  void leave_signal(const Token& word) {
    if (!message_left_out_)
      remark(word, "found 'SG_'; allowed: below its message (BO_); the signal is left out");
    pieces_.begin_line(word.line);
    pieces_.end_line();
  }

  void read_message(const Token& begin) {
    pieces_.begin_line(begin.line);
    const Token place = pieces_.next();
    message_left_out_ = true;
    OpenMessage open;
    Message& message = open.message;
    std::uint32_t number = 0;
    try {
      number = static_cast<std::uint32_t>(pieces_.take_unsigned(UINT32_MAX, "the number of a message"));
      message.extended = (number & kExtendedFlag) != 0;
      message.identifier = number & ~kExtendedFlag;
      message.name = pieces_.take(Token::Kind::word, "the name of a message").text;
      pieces_.take_sign(':');
      message.length = static_cast<unsigned>(pieces_.take_unsigned(kLongestMessage, "a length in bytes"));
    } catch (const Wrong& wrong) {
      remark(wrong.token, wrong_text(wrong) + "; the message and its signals are left out");
      numbers_left_out_.insert(number);
      return pieces_.end_line();
    }
    // The sender may be missing.
    if (pieces_.next_is(Token::Kind::word) && pieces_.next().text != "SG_") (void)pieces_.take();
    if (!takes_identifier(place, number, message)) {
      numbers_left_out_.insert(number);
      return pieces_.end_line();
    }
    message_left_out_ = false;
    if (pieces_.next().text != "SG_") leave_rest_of_line();
    pieces_.begin_line(0);
    for (;;) {
      if (pieces_.next_is(Token::Kind::word) && pieces_.next().text == "SG_")
        add_signal(open);
      else if (pieces_.at_foreign_line())
        leave_line("a signal (SG_), or a statement of a DBC file");
      else
        break;
    }
    place_.emplace(number, messages_.size());
    messages_.push_back(std::move(open));
  }

  /// False: the message is left out.
  bool takes_identifier(const Token& place, std::uint32_t number, Message& message) {
    if (message.name == kNoMessage) return false;
    if (!message.extended && message.identifier > can::kStandardIdentifierMask &&
        message.identifier <= can::kExtendedIdentifierMask) {
      message.extended = true;
      remark(
          place,
          fmt::format("found {}, which is over 2047 and without bit 31; taken for the identifier 0x{:08X} of "
                      "29 bits",
                      number, number));
    }
    if (message.identifier > can::kExtendedIdentifierMask) {
      remark(place, fmt::format(
                        "found {}; allowed: 0..2047, or 2147483648 and up to 536870911 more for 29 bits; the "
                        "message and its signals are left out",
                        number));
      return false;
    }
    if (!identifiers_.emplace(message.identifier, message.extended).second) {
      remark(
          place,
          fmt::format("found {}, which is the number of an earlier message; allowed: each once; this message "
                      "and its signals are left out",
                      number));
      return false;
    }
    return true;
  }

  void leave_rest_of_line() {
    if (!pieces_.next_is(Token::Kind::line_end) && !pieces_.next_is(Token::Kind::end))
      remark(pieces_.next(), fmt::format("found {}; allowed: the end of the line; the rest of it is left out",
                                         found_text(pieces_.next())));
    pieces_.end_line();
  }

  void add_signal(OpenMessage& open) {
    pieces_.begin_line(pieces_.take().line);
    const Token name = pieces_.next();
    try {
      if (open.message.signals.size() >= kMostSignals)
        throw Wrong{name, fmt::format("{} signals in a message", kMostSignals)};
      std::optional<std::uint64_t> mark;
      Signal signal = read_signal(mark);
      if (!open.signals.emplace(name.text, open.message.signals.size()).second)
        remark(name, fmt::format("signal {} is in message {} twice; names of values count for the first",
                                 signal.name, open.message.name));
      open.choices.add_signal(mark);
      open.places.push_back(name);
      open.message.signals.push_back(std::move(signal));
      if (pieces_.next().text != "SG_") leave_rest_of_line();
      pieces_.begin_line(0);
    } catch (const Wrong& wrong) {
      remark(wrong.token, wrong_text(wrong) + "; the signal is left out");
      if (name.kind == Token::Kind::word) open.left_out.insert(name.text);
      pieces_.end_line();
    }
  }

  Signal read_signal(std::optional<std::uint64_t>& mark) {
    Signal signal;
    signal.name = pieces_.take(Token::Kind::word, "the name of a signal").text;
    if (pieces_.next_is(Token::Kind::word)) mark = read_mark(signal, pieces_.take());
    pieces_.take_sign(':');
    const Token place = pieces_.next();
    signal.start = static_cast<unsigned>(pieces_.take_unsigned(kMostBits - 1, "a start bit"));
    pieces_.take_sign('|');
    const Token length = pieces_.next();
    signal.length = static_cast<unsigned>(pieces_.take_unsigned(kMostBits, "a length in bits"));
    if (signal.length == 0) throw Wrong{length, fmt::format("a length in bits, 1..{}", kMostBits)};
    pieces_.take_sign('@');
    signal.little_endian = pieces_.take_unsigned(1, "the order of bytes") == 1;
    if (pieces_.take_if('-'))
      signal.kind = NumberKind::signed_integer;
    else
      pieces_.take_sign('+');
    if (signal.length > kLongestNumber) {
      const unsigned whole_from = signal.little_endian ? 0 : kByteBits - 1;
      if (signal.length % kByteBits != 0 || signal.start % kByteBits != whole_from)
        throw Wrong{signal.length % kByteBits != 0 ? length : place,
                    "of over 64 bits a text, which has whole bytes"};
      signal.kind = NumberKind::text;
    }
    read_scale(signal);
    read_receivers();
    return signal;
  }

  void read_scale(Signal& signal) {
    pieces_.take_sign('(');
    const Token factor = pieces_.next();
    signal.factor = pieces_.take_real("a factor");
    pieces_.take_sign(',');
    signal.offset = pieces_.take_real("an offset");
    pieces_.take_sign(')');
    pieces_.take_sign('[');
    const auto lowest = pieces_.take_real_if();
    const bool both = pieces_.take_if('|');
    const auto highest = pieces_.take_real_if();
    // Tools write 1.#INF there and worse, which is no limit.
    const bool readable = both && lowest && highest && pieces_.next_is(']');
    while (!pieces_.next_is(']') && !pieces_.next_is(Token::Kind::text) &&
           !pieces_.next_is(Token::Kind::line_end) && !pieces_.next_is(Token::Kind::end))
      (void)pieces_.take();
    pieces_.take_sign(']');
    signal.unit = plain_text(pieces_.take(Token::Kind::text, "a unit between quotation marks").text);
    if (signal.factor == 0.0) {
      remark(factor, "found a factor of 0, with which every value would be the same; taken as 1");
      signal.factor = 1.0;
    }
    // Two equal ones, mostly 0, are how tools write that there are none.
    if (readable && *lowest != *highest) signal.limits = std::minmax(*lowest, *highest);
  }

  void read_receivers() {
    while ((pieces_.next_is(Token::Kind::word) && pieces_.next().text != "SG_") || pieces_.next_is(','))
      (void)pieces_.take();
  }

  /// M, m and a number, or both; the number.
  static std::optional<std::uint64_t> read_mark(Signal& signal, const Token& word) {
    std::string_view rest = word.text;
    signal.chooses = rest.ends_with('M');
    if (signal.chooses) rest.remove_suffix(1);
    if (rest.empty()) return std::nullopt;
    std::uint64_t value = 0;
    const auto end = rest.data() + rest.size();
    const auto [at, error] = std::from_chars(rest.data() + 1, end, value);
    if (rest.front() != 'm' || error != std::errc() || at != end)
      throw Wrong{word, "':', M, m and a number, or m, a number and M"};
    return value;
  }

  /// The message that a statement names by its number; nothing, with a remark unless there is one of the
  /// message itself: there is none.
  std::optional<std::size_t> take_message() {
    const Token place = pieces_.next();
    const std::uint32_t number =
        static_cast<std::uint32_t>(pieces_.take_unsigned(UINT32_MAX, "the number of a message"));
    const auto found = place_.find(number);
    if (found != place_.end()) return found->second;
    if (number != (kExtendedFlag | 0x40000000U) && !numbers_left_out_.contains(number))
      throw Wrong{place, "the number of a message of this file"};
    return std::nullopt;
  }

  /// Likewise the signal, by its message and name.
  std::optional<Named> take_signal() {
    const auto message = take_message();
    const Token name = pieces_.take(Token::Kind::word, "the name of a signal");
    if (!message) return std::nullopt;
    return signal_of(*message, name);
  }

  std::optional<Named> signal_of(std::size_t message, const Token& name) {
    const OpenMessage& open = messages_[message];
    const auto signal = open.signals.find(name.text);
    if (signal != open.signals.end()) return Named{message, signal->second};
    if (!open.left_out.contains(name.text))
      throw Wrong{name, fmt::format("a signal of message {}", open.message.name)};
    return std::nullopt;
  }

  Signal& at(const Named& named) { return messages_[named.message].message.signals[named.signal]; }

  void read_words() {
    // Of an environment variable, which has no number of a message.
    if (pieces_.next_is(Token::Kind::word)) return (void)pieces_.skip_statement();
    const auto named = take_signal();
    try {
      while (!pieces_.next_is(';')) {
        const Token place = pieces_.next();
        const std::int64_t raw = pieces_.take_raw();
        std::string word = plain_text(pieces_.take(Token::Kind::text, "a name between quotation marks").text);
        if (named) add_word(*named, place, raw, std::move(word));
      }
      pieces_.take_sign(';');
    } catch (const Wrong& wrong) {
      remark(wrong.token, wrong_text(wrong) + "; the names of values from here on are left out");
      (void)pieces_.skip_statement();
    }
  }

  /// A signal may have several lists of names.
  void add_word(const Named& named, const Token& place, std::int64_t raw, std::string word) {
    auto& words = at(named).words;
    const auto [known, is_new] = named_.try_emplace({named.message, named.signal, raw}, words.size());
    if (is_new) {
      words.emplace_back(raw, std::move(word));
    } else if (words[known->second].second != word) {
      remark(place, fmt::format("{} of signal {} is named twice; the first name, '{}', counts", raw,
                                at(named).name, words[known->second].second));
    }
  }

  void read_number_kind() {
    const auto named = take_signal();
    (void)pieces_.take_if(':');
    const Token token = pieces_.next();
    const auto kind = pieces_.take_unsigned(2, "0 (whole numbers), 1 (32 bits) or 2 (64 bits)");
    (void)pieces_.take_if(';');
    if (!named || kind == 0) return;
    Signal& signal = at(*named);
    constexpr std::array<unsigned, 3> kLengths = {0, 32, 64};
    if (signal.length != kLengths[kind])
      return remark(
          token, fmt::format("found '{}', which is a number of {}; signal {} has {} and stays a whole number",
                             kind, text::counted(kLengths[kind], "bit"), signal.name,
                             text::counted(signal.length, "bit")));
    signal.kind = kind == 1 ? NumberKind::float32 : NumberKind::float64;
  }

  /// SG_MUL_VAL_ 291 Rpm Pid 12-12, 20-30;
  void read_ranges() {
    const auto message = take_message();
    const Token name = pieces_.take(Token::Kind::word, "the name of a signal");
    const Token by = pieces_.take(Token::Kind::word, "the name of its multiplexor");
    std::vector<std::pair<std::uint64_t, std::uint64_t>> ranges;
    do {
      const std::uint64_t first = pieces_.take_unsigned(UINT64_MAX, "a raw value");
      const Token last = pieces_.take(Token::Kind::number, "'-' and a raw value");
      std::uint64_t value = 0;
      const auto end = last.text.data() + last.text.size();
      const auto [at, error] = std::from_chars(last.text.data() + 1, end, value);
      if (last.text.front() != '-' || error != std::errc() || at != end || value < first)
        throw Wrong{last, fmt::format("'-' and a raw value, {} at least", first)};
      ranges.emplace_back(first, value);
    } while (pieces_.take_if(','));
    (void)pieces_.take_if(';');
    if (!message) return;
    const auto signal = signal_of(*message, name);
    const auto multiplexor = signal_of(*message, by);
    if (!signal || !multiplexor) return;
    if (!at(*multiplexor).chooses)
      throw Wrong{by, fmt::format("a multiplexor (M) of message {}", messages_[*message].message.name)};
    messages_[*message].choices.add_ranges(signal->signal, multiplexor->signal, std::move(ranges));
  }

  /// The long names, which CANdb++ keeps in attributes.
  void read_attribute() {
    const Token name = pieces_.take(Token::Kind::text, "the name of an attribute");
    const bool of_signal = name.text == "SystemSignalLongSymbol";
    if (!of_signal && name.text != "SystemMessageLongSymbol") return (void)pieces_.skip_statement();
    (void)pieces_.take(Token::Kind::word, of_signal ? "SG_" : "BO_");
    if (of_signal) {
      const auto named = take_signal();
      std::string text = plain_text(pieces_.take(Token::Kind::text, "a long name").text);
      if (named && !text.empty()) messages_[named->message].long_names[named->signal] = std::move(text);
    } else {
      const auto message = take_message();
      std::string text = plain_text(pieces_.take(Token::Kind::text, "a long name").text);
      if (message && !text.empty()) messages_[*message].message.name = std::move(text);
    }
    (void)pieces_.take_if(';');
  }

  // ---- when all is read ----

  void close(OpenMessage& open) {
    for (std::size_t i = 0; i < open.message.signals.size(); ++i)
      check_limits(open.message.signals[i], open.places[i]);
    for (auto& [signal, name] : open.long_names) open.message.signals[signal].name = std::move(name);
    std::vector<std::string> names;
    for (const Signal& signal : open.message.signals) names.push_back(signal.name);
    open.choices.resolve(open.message, [&](std::size_t signal, const std::string& why) {
      remark(open.places[signal], fmt::format("signal {}: {}; it is left out", names[signal], why));
    });
  }

  /// With limits that none of its values keeps it could never be sent.
  void check_limits(Signal& signal, const Token& place) {
    if (!signal.limits || signal.kind == NumberKind::text) return;
    const auto [lowest, highest] = range_of(signal);
    if (signal.limits->first <= highest && signal.limits->second >= lowest) return;
    remark(place,
           fmt::format(
               "signal {}: found the limits {:.10g}..{:.10g}; allowed: within {:.10g}..{:.10g}, which is "
               "what its bits can be; the limits are left out",
               signal.name, signal.limits->first, signal.limits->second, lowest, highest));
    signal.limits.reset();
  }

  std::string_view text_;
  Pieces pieces_;
  File file_;
  std::vector<OpenMessage> messages_;
  std::map<std::uint32_t, std::size_t> place_;            ///< by number as the file has it, in messages_
  std::set<std::pair<std::uint32_t, bool>> identifiers_;  ///< of messages that are used
  /// Which raw values have names, and where these are in their signal.
  std::map<std::tuple<std::size_t, std::size_t, std::int64_t>, std::size_t> named_;
  std::set<std::uint32_t> numbers_left_out_;  ///< of messages with a remark of their own
  bool message_left_out_ = false;             ///< the last message was
};

}  // namespace

File read_database(std::string_view text) {
  return Reader(text).read();
}

}  // namespace dbc
