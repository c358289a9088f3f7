#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

/// Lines of text with attributes, as a terminal shows them. Pure values; any thread.
namespace cansync::cli {

/// How a piece of text looks; what that is in colours is the screen's business.
enum class Style : unsigned char { plain, bar, heading, chosen, dim, strong, good, warning, bad, trend };

/// Text in one style.
struct Span {
  std::string text;
  Style style = Style::plain;
  bool operator==(const Span&) const = default;
};

/// One line of a screen, from the left.
struct StyledLine {
  std::vector<Span> spans;
  bool highlighted = false;  ///< the whole line, for the row that is selected

  StyledLine& add(std::string text, Style style = Style::plain);
  /// Characters so far.
  std::size_t width() const;
  /// Spaces up to column `column`; none when the line is that long already.
  StyledLine& pad_to(std::size_t column, Style style = Style::plain);
  /// Drops what goes beyond `width` characters.
  StyledLine& cut(std::size_t width);
  /// The text alone.
  std::string text() const;
};

/// The first `width` characters of UTF-8 `text`; "~" takes the last one's place when some were dropped.
std::string shortened(std::string_view text, std::size_t width);
/// `text` in exactly `width` characters, spaces added on the right, or on the left when `right`.
std::string fitted(std::string_view text, std::size_t width, bool right = false);
/// `text` with every character beyond ASCII, and every control character, as "?".
std::string ascii(std::string_view text);

}  // namespace cansync::cli
