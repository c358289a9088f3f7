#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "dbc/tokens.h"

namespace dbc {

/// Ends the reading of a statement: what was found in the place of what is allowed.
struct Wrong {
  Token token;
  std::string expected;
};

/// "'65'", "the end of the file", "a text that does not end".
std::string found_text(const Token& token);
/// "found '65'; allowed: a length in bits".
std::string wrong_text(const Wrong& wrong);

/// Takes the pieces that a statement must have, and throws Wrong for others.
class Pieces {
 public:
  explicit Pieces(std::string_view text) : tokens_(text) { line_end_.kind = Token::Kind::line_end; }

  /// The next piece; where the statement has to be in one line, that ends with the line.
  const Token& next() const noexcept;
  bool next_is(Token::Kind kind) const noexcept { return next().kind == kind; }
  bool next_is(char sign) const noexcept { return next_is(Token::Kind::sign) && next().text.front() == sign; }
  Token take();
  /// What comes must be in this line, up to `end_line`.
  void begin_line(std::size_t line) noexcept { line_ = line; }
  /// Leaves the line; what is left of it is passed over.
  void end_line();
  std::optional<Token> skip_statement() { return tokens_.skip_statement(); }
  /// Does the next piece begin a line that is part of no statement, in the place where one is to begin?
  bool at_foreign_line() const noexcept;
  /// Leaves the line in which the next piece begins.
  void skip_line() { tokens_.skip_line(); }

  Token take(Token::Kind kind, std::string_view expected);
  void take_sign(char sign);
  /// True: it was there.
  bool take_if(char sign);
  std::uint64_t take_unsigned(std::uint64_t most, std::string_view what);
  double take_real(std::string_view what);
  /// Nothing: what comes is no finite number, and stays.
  std::optional<double> take_real_if();
  /// A raw value; one over 63 bits becomes its two's complement.
  std::int64_t take_raw();

 private:
  Tokens tokens_;
  std::size_t line_ = 0;  ///< 0: any
  Token line_end_;        ///< the next piece when the line has no more
};

}  // namespace dbc
