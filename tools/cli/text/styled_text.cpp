#include "cli/text/styled_text.h"

#include "cli/text/table.h"
#include "text/visible.h"

namespace cansync::cli {
namespace {

/// Bytes of the first `width` characters.
std::size_t bytes_of(std::string_view text, std::size_t width) {
  std::size_t at = 0;
  for (std::size_t seen = 0; at < text.size(); ++at) {
    const bool begins = (static_cast<unsigned char>(text[at]) & 0xC0u) != 0x80u;
    if (begins && seen++ == width) break;
  }
  return at;
}

}  // namespace

StyledLine& StyledLine::add(std::string text, Style style) {
  if (!text.empty()) spans.push_back({text::visible(text), style});
  return *this;
}

std::size_t StyledLine::width() const {
  std::size_t sum = 0;
  for (const Span& span : spans) sum += display_width(span.text);
  return sum;
}

StyledLine& StyledLine::pad_to(std::size_t column, Style style) {
  const std::size_t now = width();
  return add(std::string(column > now ? column - now : 0, ' '), style);
}

StyledLine& StyledLine::cut(std::size_t width) {
  std::size_t left = width;
  for (std::size_t i = 0; i < spans.size(); ++i) {
    spans[i].text.resize(bytes_of(spans[i].text, left));
    left -= display_width(spans[i].text);
  }
  std::erase_if(spans, [](const Span& span) { return span.text.empty(); });
  return *this;
}

std::string StyledLine::text() const {
  std::string out;
  for (const Span& span : spans) out += span.text;
  return out;
}

std::string shortened(std::string_view text, std::size_t width) {
  if (display_width(text) <= width) return std::string(text);
  if (width == 0) return "";
  return std::string(text.substr(0, bytes_of(text, width - 1))) + "~";
}

std::string fitted(std::string_view text, std::size_t width, bool right) {
  const std::string cut = shortened(text, width);
  const std::string space(width - display_width(cut), ' ');
  return right ? space + cut : cut + space;
}

std::string ascii(std::string_view text) {
  std::string out;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte >= 0x20 && byte < 0x7F)
      out += c;
    else if ((byte & 0xC0u) != 0x80u)
      out += '?';
  }
  return out;
}

}  // namespace cansync::cli
