#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace dbc {

/// A piece of a DBC file.
struct Token {
  enum class Kind : unsigned char {
    end,     ///< of the file
    word,    ///< letters, digits and '_', begun by a letter or '_'
    number,  ///< as written; a sign only when it stands right before it
    text,    ///< what stood between quotation marks
    sign,    ///< one other character
  };
  Kind kind = Kind::end;
  std::string_view text;   ///< without the quotation marks
  std::size_t line = 1;    ///< where it begins, from 1
  std::size_t column = 1;  ///< in bytes, from 1
  bool first = false;      ///< nothing but blanks stands before it in its line
  bool broken = false;     ///< a text that does not end
};

/// Cuts a file into its pieces, one after the other.
class Tokens {
 public:
  explicit Tokens(std::string_view text) : text_(text) { take(); }

  /// The next piece, which stays the next one.
  const Token& next() const noexcept { return next_; }
  /// The same, and goes on.
  Token take();

 private:
  void pass(std::size_t count) noexcept;
  void pass_blanks() noexcept;
  std::size_t length_of_number() const noexcept;

  std::string_view text_;
  std::size_t at_ = 0;
  std::size_t line_ = 1;
  std::size_t line_begin_ = 0;
  bool first_ = true;
  Token next_;
};

/// `text` as UTF-8: as it is, or when it is none, taken for ISO-8859-1.
std::string as_utf8(std::string_view text);

}  // namespace dbc
