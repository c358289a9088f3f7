#include "cli/text/csv.h"

#include <fmt/format.h>

#include <algorithm>

namespace cansync::cli {
namespace {

constexpr std::size_t kLongestLine = 65536;

/// One line without its end; false when there is none. `ended`: a line end came.
bool read_line(std::istream& file, std::string& line, bool& ended) {
  line.clear();
  ended = false;
  for (int c = file.get(); c != std::istream::traits_type::eof(); c = file.get()) {
    if (c == '\n') {
      ended = true;
      if (!line.empty() && line.back() == '\r') line.pop_back();
      return true;
    }
    line += static_cast<char>(c);
    if (line.size() > kLongestLine) return true;
  }
  return !line.empty();
}

}  // namespace

std::string csv_field(std::string_view text) {
  std::string out;
  bool quotes = false;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    quotes = quotes || c == '"' || c == ',';
    if (c == '"') out += '"';
    out += byte < 0x20 || byte == 0x7F ? ' ' : c;
  }
  return quotes ? '"' + out + '"' : out;
}

CsvError CsvReader::error(std::size_t column, std::string_view what) const {
  return CsvError(fmt::format("{}: line {}, column {}: {}", name_, line_, column, what));
}

CsvField CsvReader::field(std::string_view text, std::size_t& at) const {
  CsvField out;
  out.column = at + 1;
  if (at == text.size() || text[at] != '"') {
    const std::size_t end = std::min(text.find(',', at), text.size());
    out.text = text.substr(at, end - at);
    if (const std::size_t quote = out.text.find('"'); quote != std::string::npos)
      throw error(at + quote + 1, "found a quote inside a field; allowed: doubled, in a field in quotes");
    at = end;
    return out;
  }
  for (++at;; ++at) {
    if (at == text.size()) throw error(out.column, "found no quote at the end of this field");
    if (text[at] == '"') {
      ++at;
      if (at == text.size() || text[at] != '"') break;
    }
    out.text += text[at];
  }
  if (at != text.size() && text[at] != ',')
    throw error(at + 1,
                fmt::format("found '{}' after the quote; allowed: a comma or the line's end", text[at]));
  return out;
}

bool CsvReader::next(std::vector<CsvField>& fields) {
  fields.clear();
  std::string text;
  bool ended = false;
  if (!read_line(file_, text, ended)) return false;
  ++line_;
  if (text.size() > kLongestLine) throw error(kLongestLine, "the line is too long; allowed: 65536 bytes");
  broken_off_ = !ended;
  for (std::size_t at = 0;; ++at) {
    fields.push_back(field(text, at));
    if (at == text.size()) return true;
  }
}

}  // namespace cansync::cli
