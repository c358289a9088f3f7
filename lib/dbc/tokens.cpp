#include "dbc/tokens.h"

#include <algorithm>
#include <array>
#include <cctype>

namespace dbc {
namespace {

constexpr auto kKeywords = std::to_array<std::string_view>({"VERSION",
                                                            "NS_",
                                                            "BS_",
                                                            "BU_",
                                                            "BO_",
                                                            "SG_",
                                                            "BO_TX_BU_",
                                                            "EV_",
                                                            "ENVVAR_DATA_",
                                                            "SGTYPE_",
                                                            "SIG_GROUP_",
                                                            "CM_",
                                                            "BA_DEF_",
                                                            "BA_",
                                                            "VAL_",
                                                            "VAL_TABLE_",
                                                            "BA_DEF_DEF_",
                                                            "SIG_VALTYPE_",
                                                            "SIGTYPE_VALTYPE_",
                                                            "BA_DEF_SGTYPE_",
                                                            "BA_SGTYPE_",
                                                            "SIG_TYPE_REF_",
                                                            "CAT_DEF_",
                                                            "CAT_",
                                                            "FILTER",
                                                            "BA_DEF_REL_",
                                                            "BA_REL_",
                                                            "BA_DEF_DEF_REL_",
                                                            "BU_SG_REL_",
                                                            "BU_EV_REL_",
                                                            "BU_BO_REL_",
                                                            "SG_MUL_VAL_",
                                                            "EV_DATA_",
                                                            "NS_DESC_"});

bool is_word(char c) noexcept {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_';
}

bool is_digit(char c) noexcept {
  return c >= '0' && c <= '9';
}

bool is_blank_in_line(char c) noexcept {
  return c == ' ' || c == '\t' || c == '\r';
}

bool is_blank(char c) noexcept {
  return is_blank_in_line(c) || c == '\n';
}

/// Reads along a text; what it takes is gone from `rest`.
struct Cursor {
  std::string_view rest;

  bool blanks() noexcept {
    const std::size_t before = rest.size();
    while (!rest.empty() && is_blank_in_line(rest.front())) rest.remove_prefix(1);
    return rest.size() != before;
  }
  std::string_view word() noexcept {
    std::size_t length = 0;
    while (length < rest.size() && is_word(rest[length])) ++length;
    const std::string_view taken = rest.substr(0, length);
    rest.remove_prefix(length);
    return taken;
  }
  bool ends_line() noexcept {
    blanks();
    return rest.empty() || rest.front() == '\n';
  }
  bool next_is(char c) const noexcept { return !rest.empty() && rest.front() == c; }
};

/// The keyword with which this line begins a statement; empty: it begins none. A keyword alone is one of the
/// list of NS_.
std::string_view statement_of(Cursor& line) noexcept {
  line.blanks();
  const std::string_view word = line.word();
  if (!is_keyword(word)) return {};
  if (line.next_is(':')) return word;
  return line.blanks() && !line.ends_line() ? word : std::string_view();
}

/// Does a statement begin here so clearly that no text goes beyond it?
bool surely_begins_statement(std::string_view text) noexcept {
  Cursor line{text};
  const std::string_view keyword = statement_of(line);
  if (keyword.empty() || keyword == "FILTER" || keyword == "VERSION") return false;
  if (keyword == "BO_") {  // BO_ 291 Motor: 8
    const std::string_view number = line.word();
    line.blanks();
    const std::string_view name = line.word();
    line.blanks();
    return !name.empty() && !number.empty() && std::all_of(number.begin(), number.end(), is_digit) &&
           line.next_is(':');
  }
  if (keyword == "SG_") {  // SG_ Speed m1 : 0|16
    line.word();
    line.blanks();
    line.word();
    line.blanks();
    if (!line.next_is(':')) return false;
    line.rest.remove_prefix(1);
    line.blanks();
    const std::string_view start = line.word();
    return !start.empty() && line.next_is('|');
  }
  return true;
}

}  // namespace

bool is_keyword(std::string_view word) noexcept {
  return std::find(kKeywords.begin(), kKeywords.end(), word) != kKeywords.end();
}

void Tokens::pass(std::size_t count) noexcept {
  for (; count > 0; --count, ++at_) {
    if (text_[at_] != '\n') continue;
    ++line_;
    line_begin_ = at_ + 1;
    first_ = true;
  }
}

void Tokens::pass_blanks() noexcept {
  while (at_ < text_.size()) {
    if (text_.substr(at_, 2) == "//") {
      pass(std::min(text_.find('\n', at_), text_.size()) - at_);
    } else if (is_blank(text_[at_])) {
      pass(1);
    } else {
      return;
    }
  }
}

std::size_t Tokens::length_of_number() const noexcept {
  const std::string_view rest = text_.substr(at_);
  std::size_t i = rest[0] == '-' || rest[0] == '+' ? 1 : 0;
  const std::size_t begin = i;
  bool digits = false;
  for (; i < rest.size() && (is_digit(rest[i]) || rest[i] == '.'); ++i) digits = digits || is_digit(rest[i]);
  if (i == begin || !digits) return 0;
  if (i < rest.size() && (rest[i] == 'e' || rest[i] == 'E')) {
    std::size_t k = i + 1;
    if (k < rest.size() && (rest[k] == '-' || rest[k] == '+')) ++k;
    const std::size_t exponent = k;
    while (k < rest.size() && is_digit(rest[k])) ++k;
    if (k > exponent) i = k;
  }
  return i;
}

/// The next line behind `begin` that surely begins a statement, or the end of the file.
std::size_t Tokens::border_of(std::size_t begin) noexcept {
  if (border_from_ <= begin && begin <= border_) return border_;
  border_from_ = begin;
  border_ = text_.find('\n', begin);
  while (border_ < text_.size() && !surely_begins_statement(text_.substr(border_ + 1)))
    border_ = text_.find('\n', border_ + 1);
  border_ = std::min(border_, text_.size());
  return border_;
}

/// Does the quotation mark there end a text, by what follows it?
bool Tokens::ends_text(std::size_t mark, bool escaped) noexcept {
  Cursor after{text_.substr(mark + 1)};
  switch (follower_) {
    case Follower::anything:
      if (!escaped) return true;
      after.blanks();
      return after.next_is(';') && Cursor{after.rest.substr(1)}.ends_line();
    case Follower::statement_end: {
      after.blanks();
      if (!after.next_is(';')) return false;
      Cursor behind{after.rest.substr(1)};
      if (behind.ends_line()) return true;
      return is_keyword(behind.word());
    }
    case Follower::next_value: {
      while (!after.rest.empty() && is_blank(after.rest.front())) after.rest.remove_prefix(1);
      if (after.rest.empty() || after.next_is(';')) return true;
      const std::size_t number =
          std::min(after.rest.find_first_not_of("+-.0123456789abcdefxABCDEFX"), after.rest.size());
      after.rest.remove_prefix(number);
      return number > 0 && after.blanks() && after.next_is('"');
    }
    case Follower::receiver:
      if (after.ends_line()) return true;
      return is_word(after.rest.front()) || after.next_is(',');
  }
  return true;
}

/// The mark that ends the text which begins there, as its follower confirms it; `border`: there is none.
std::size_t Tokens::strict_end(std::size_t begin, std::size_t border) noexcept {
  if (begin < no_end_before_) return border;
  bool escaped = false;
  for (std::size_t i = begin; i < border; ++i) {
    if (text_[i] == '"' && ends_text(i, escaped)) return i;
    escaped = text_[i] == '\\' && !escaped;
  }
  no_end_before_ = border;
  return border;
}

void Tokens::read_text() {
  const std::size_t begin = at_ + 1;
  std::size_t border = border_of(begin);
  if (follower_ == Follower::receiver) border = std::min(border, text_.find('\n', begin));
  std::size_t end = strict_end(begin, border);
  if (end == border) {
    end = begin;
    while (end < border && text_[end] != '"') end += text_[end] == '\\' ? 2 : 1;
    end = std::min(end, border);
  }
  next_.kind = Token::Kind::text;
  next_.text = text_.substr(begin, end - begin);
  next_.broken = end == border;
  pass(std::min(next_.broken ? end : end + 1, text_.size()) - at_);
}

/// What must follow the texts of the statement that the next piece begins, if it begins one.
void Tokens::begin_statement() noexcept {
  const bool signal = in_message_ && next_.text == "SG_";
  if (!is_keyword(next_.text) || !(next_.first || signal)) return;
  in_message_ = next_.text == "BO_" || next_.text == "SG_";
  no_end_before_ = 0;
  follower_ = Follower::anything;
  if (next_.text == "CM_") follower_ = Follower::statement_end;
  if (next_.text == "VAL_" || next_.text == "VAL_TABLE_") follower_ = Follower::next_value;
  if (next_.text == "SG_") follower_ = Follower::receiver;
}

Token Tokens::take() {
  const Token taken = next_;
  pass_blanks();
  begin_of_next_ = at_;
  next_ = {Token::Kind::end, {}, line_, at_ - line_begin_ + 1, first_, false};
  if (at_ >= text_.size()) return taken;
  const char c = text_[at_];
  if (c == '"') {
    first_ = false;
    read_text();
    return taken;
  }
  std::size_t length = length_of_number();
  if (length > 0) {
    next_.kind = Token::Kind::number;
  } else if (is_word(c)) {
    while (at_ + length < text_.size() && is_word(text_[at_ + length])) ++length;
    next_.kind = Token::Kind::word;
  } else {
    length = 1;
    next_.kind = Token::Kind::sign;
  }
  next_.text = text_.substr(at_, length);
  if (next_.kind == Token::Kind::word) begin_statement();
  first_ = false;
  pass(length);
  return taken;
}

/// Goes on at the place `at`, at or behind the begin of the next piece.
void Tokens::restart(std::size_t at) noexcept {
  line_ = next_.line;
  line_begin_ = begin_of_next_ - (next_.column - 1);
  first_ = next_.first;
  at_ = begin_of_next_;
  if (at > at_) first_ = false;
  pass(at - at_);
  take();
}

bool Tokens::begins_statement() const noexcept {
  Cursor line{text_.substr(begin_of_next_)};
  return next_.first && !statement_of(line).empty();
}

void Tokens::skip_line() {
  const std::size_t end = text_.find('\n', begin_of_next_);
  restart(end == text_.npos ? text_.size() : end + 1);
}

std::optional<Token> Tokens::skip_statement() {
  while (next_.kind != Token::Kind::end && !begins_statement()) {
    const Token passed = take();
    if (passed.broken) return passed;
    if (passed.kind == Token::Kind::sign && passed.text == ";") break;
  }
  return std::nullopt;
}

}  // namespace dbc
