#include "dbc/pieces.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "dbc/foreign_text.h"

namespace dbc {
namespace {

template <class Number>
std::optional<Number> number_of(std::string_view digits) {
  if (digits.starts_with('+')) digits.remove_prefix(1);
  Number value = {};
  const auto end = digits.data() + digits.size();
  const auto [at, error] = std::from_chars(digits.data(), end, value);
  return error == std::errc() && at == end ? std::optional(value) : std::nullopt;
}

}  // namespace

std::string found_text(const Token& token) {
  if (token.kind == Token::Kind::end) return "the end of the file";
  if (token.kind == Token::Kind::line_end) return "the end of the line";
  if (token.broken) return "a text that does not end";
  constexpr std::size_t kMostShown = 40;
  return "'" + plain_text(token.text.substr(0, kMostShown)) + "'";
}

std::string wrong_text(const Wrong& wrong) {
  return fmt::format("found {}; allowed: {}", found_text(wrong.token), wrong.expected);
}

const Token& Pieces::next() const noexcept {
  return line_ == 0 || tokens_.next().line == line_ ? tokens_.next() : line_end_;
}

Token Pieces::take() {
  const Token taken = tokens_.take();
  line_end_.line = taken.line;
  line_end_.column = taken.column + taken.text.size();
  return taken;
}

void Pieces::end_line() {
  if (line_ != 0 && tokens_.next().kind != Token::Kind::end && tokens_.next().line == line_)
    tokens_.skip_line();
  line_ = 0;
}

bool Pieces::at_foreign_line() const noexcept {
  const Token& next = tokens_.next();
  return next.first && next.kind != Token::Kind::end && !is_keyword(next.text);
}

Token Pieces::take(Token::Kind kind, std::string_view expected) {
  if (next().kind != kind || next().broken) throw Wrong{next(), std::string(expected)};
  return take();
}

void Pieces::take_sign(char sign) {
  if (!next_is(sign)) throw Wrong{next(), fmt::format("'{}'", sign)};
  (void)take();
}

bool Pieces::take_if(char sign) {
  if (!next_is(sign)) return false;
  (void)take();
  return true;
}

std::uint64_t Pieces::take_unsigned(std::uint64_t most, std::string_view what) {
  const std::string expected = fmt::format("{}, 0..{}", what, most);
  const Token token = take(Token::Kind::number, expected);
  const auto value = number_of<std::uint64_t>(token.text);
  if (!value || *value > most) throw Wrong{token, expected};
  return *value;
}

double Pieces::take_real(std::string_view what) {
  const Token token = take(Token::Kind::number, what);
  const auto value = number_of<double>(token.text);
  if (!value || !std::isfinite(*value)) throw Wrong{token, std::string(what)};
  return *value;
}

std::optional<double> Pieces::take_real_if() {
  if (!next_is(Token::Kind::number)) return std::nullopt;
  const auto value = number_of<double>(next().text);
  if (!value || !std::isfinite(*value)) return std::nullopt;
  (void)take();
  return value;
}

std::int64_t Pieces::take_raw() {
  const Token token = take(Token::Kind::number, "a raw value, or ';'");
  if (const auto value = number_of<std::int64_t>(token.text)) return *value;
  if (const auto value = number_of<std::uint64_t>(token.text)) return static_cast<std::int64_t>(*value);
  // Some tools write whole numbers with a point. Up to the largest they are exact.
  constexpr double kLargest = 9007199254740992.0;
  const auto value = number_of<double>(token.text);
  if (!value || !(std::abs(*value) <= kLargest) || std::trunc(*value) != *value)
    throw Wrong{token, "a raw value, which is a whole number, or ';'"};
  return static_cast<std::int64_t>(*value);
}

}  // namespace dbc
