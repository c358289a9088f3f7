#include "dbc/tokens.h"

#include <algorithm>
#include <cctype>
#include <cstdint>

namespace dbc {
namespace {

bool is_word(char c) noexcept {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_';
}

bool is_digit(char c) noexcept {
  return c >= '0' && c <= '9';
}

bool is_blank(char c) noexcept {
  return c == ' ' || c == '\t' || c == '\r' || c == '\n';
}

/// Bytes that a character begun by `lead` has besides; over 3: it cannot begin one.
unsigned following_bytes(unsigned char lead) noexcept {
  if (lead < 0x80) return 0;
  if (lead >= 0xC2 && lead < 0xE0) return 1;
  if (lead >= 0xE0 && lead < 0xF0) return 2;
  if (lead >= 0xF0 && lead < 0xF5) return 3;
  return 4;
}

bool is_utf8(std::string_view text) noexcept {
  for (std::size_t i = 0; i < text.size();) {
    const unsigned more = following_bytes(static_cast<unsigned char>(text[i]));
    if (more > 3 || i + more >= text.size() + (more == 0 ? 1 : 0)) return false;
    for (unsigned k = 1; k <= more; ++k)
      if ((static_cast<unsigned char>(text[i + k]) & 0xC0U) != 0x80U) return false;
    i += more + 1;
  }
  return true;
}

}  // namespace

std::string as_utf8(std::string_view text) {
  if (is_utf8(text)) return std::string(text);
  std::string out;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x80) {
      out += c;
    } else {
      out += static_cast<char>(0xC0U | (byte >> 6U));
      out += static_cast<char>(0x80U | (byte & 0x3FU));
    }
  }
  return out;
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
  const std::size_t digits = i;
  while (i < rest.size() && (is_digit(rest[i]) || rest[i] == '.')) ++i;
  if (i == digits) return 0;
  if (i < rest.size() && (rest[i] == 'e' || rest[i] == 'E')) {
    std::size_t k = i + 1;
    if (k < rest.size() && (rest[k] == '-' || rest[k] == '+')) ++k;
    const std::size_t exponent = k;
    while (k < rest.size() && is_digit(rest[k])) ++k;
    if (k > exponent) i = k;
  }
  return i;
}

Token Tokens::take() {
  const Token taken = next_;
  pass_blanks();
  next_ = {Token::Kind::end, {}, line_, at_ - line_begin_ + 1, first_, false};
  if (at_ >= text_.size()) return taken;
  const char c = text_[at_];
  std::size_t length = 1;
  if (c == '"') {
    const std::size_t begin = at_ + 1;
    std::size_t end = begin;
    while (end < text_.size() && text_[end] != '"') end += text_[end] == '\\' ? 2 : 1;
    end = std::min(end, text_.size());
    next_.kind = Token::Kind::text;
    next_.text = text_.substr(begin, end - begin);
    next_.broken = end == text_.size();
    length = std::min(end + 1, text_.size()) - at_;
  } else if (is_digit(c) || ((c == '-' || c == '+') && length_of_number() > 0)) {
    length = length_of_number();
    next_.kind = Token::Kind::number;
  } else if (is_word(c)) {
    while (at_ + length < text_.size() && is_word(text_[at_ + length])) ++length;
    next_.kind = Token::Kind::word;
  } else {
    next_.kind = Token::Kind::sign;
  }
  if (next_.kind != Token::Kind::text) next_.text = text_.substr(at_, length);
  first_ = false;
  pass(length);
  return taken;
}

}  // namespace dbc
