#pragma once

#include <cstddef>
#include <istream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

/// Comma-separated values as RFC 4180 has them: fields in quotes may hold commas and doubled quotes.
namespace cansync::cli {

/// A file is no CSV, or not the one expected; the text begins with its name, line and column.
class CsvError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// `text` as a field, in quotes when it needs them. Control characters become spaces.
std::string csv_field(std::string_view text);

/// One field and where it begins: column 1 is the first character of the line.
struct CsvField {
  std::string text;
  std::size_t column = 1;
};

/// Reads a file line by line. Lines end with LF or CR LF; a field does not go over a line's end.
class CsvReader {
 public:
  /// `name` stands in errors. `file` must outlive the reader.
  CsvReader(std::istream& file, std::string name) : file_(file), name_(std::move(name)) {}

  /// The fields of the next line; false at the end. Throws CsvError for a quote out of place and a line over
  /// 65536 bytes.
  bool next(std::vector<CsvField>& fields);
  /// Of the line that was read last, from 1.
  std::size_t line() const noexcept { return line_; }
  /// The last line ended without a line end: whoever wrote the file was stopped in the middle of it.
  bool broken_off() const noexcept { return broken_off_; }
  /// An error at this column of the line that was read last.
  CsvError error(std::size_t column, std::string_view what) const;

 private:
  CsvField field(std::string_view text, std::size_t& at) const;

  std::istream& file_;
  std::string name_;
  std::size_t line_ = 0;
  bool broken_off_ = false;
};

}  // namespace cansync::cli
