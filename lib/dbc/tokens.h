#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

namespace dbc {

/// A piece of a DBC file.
struct Token {
  enum class Kind : unsigned char {
    end,       ///< of the file
    line_end,  ///< of a statement that has to be in one line (Pieces)
    word,      ///< letters, digits and '_', begun by a letter or '_'
    number,    ///< as written; a sign only when it stands right before it
    text,      ///< what stood between quotation marks
    sign,      ///< one other character
  };
  Kind kind = Kind::end;
  std::string_view text;   ///< without the quotation marks
  std::size_t line = 1;    ///< where it begins, from 1
  std::size_t column = 1;  ///< in bytes, from 1
  bool first = false;      ///< nothing but blanks stands before it in its line
  bool broken = false;     ///< a text that does not end
};

/// Cuts a file into its pieces, one after the other.
///
/// Tools write quotation marks and backslashes into texts without escaping them. Where a text ends is
/// therefore decided by what must follow it in its statement, and no text goes beyond a line that begins a
/// statement. Every operation is linear in what it passes.
class Tokens {
 public:
  explicit Tokens(std::string_view text) : text_(text) { take(); }

  /// The next piece, which stays the next one.
  const Token& next() const noexcept { return next_; }
  /// The same, and goes on.
  Token take();
  /// Does the next piece begin a statement, as the first of its line?
  bool begins_statement() const noexcept;
  /// Goes on behind the end of the line in which the next piece begins.
  void skip_line();
  /// Goes on behind the ';' that ends the statement, behind a text that does not end, which it returns, or
  /// before the next line that begins a statement.
  std::optional<Token> skip_statement();

 private:
  /// What must follow a text, by the statement it is in.
  enum class Follower : unsigned char {
    anything,       ///< the next quotation mark ends it
    statement_end,  ///< ';' and the end of the line
    next_value,     ///< ';', or a number and the next text
    receiver,       ///< a name, or the end of the line
  };

  void pass(std::size_t count) noexcept;
  void pass_blanks() noexcept;
  void restart(std::size_t at) noexcept;
  std::size_t length_of_number() const noexcept;
  void begin_statement() noexcept;
  void read_text();
  bool ends_text(std::size_t mark, bool escaped) noexcept;
  std::size_t strict_end(std::size_t begin, std::size_t border) noexcept;
  std::size_t border_of(std::size_t begin) noexcept;

  std::string_view text_;
  std::size_t at_ = 0;
  std::size_t line_ = 1;
  std::size_t line_begin_ = 0;
  bool first_ = true;
  bool in_message_ = false;  ///< BO_ and its signals, which may be in one line
  Follower follower_ = Follower::anything;
  std::size_t begin_of_next_ = 0;
  std::size_t border_ = 0;         ///< the next line that begins a statement, looked for from border_from_
  std::size_t border_from_ = 1;    ///< over border_: not looked for yet
  std::size_t no_end_before_ = 0;  ///< texts that begin before it have no end that their follower confirms
  Token next_;
};

/// Is this word one that begins a statement of the format, e.g. BO_?
bool is_keyword(std::string_view word) noexcept;

}  // namespace dbc
