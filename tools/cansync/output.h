#pragma once

#include <cstdio>
#include <string>
#include <string_view>
#include <vector>

#include "cansync/json.h"
#include "cansync/table.h"

/// Where results and remarks go: data to stdout, everything else to stderr.
namespace cansync::cli {

class Output {
 public:
  /// Both files stay open and belong to the caller. `json`: data as objects, one a line.
  Output(std::FILE* data, std::FILE* remarks, bool json) : data_(data), remarks_(remarks), json_(json) {}

  bool json() const noexcept { return json_; }
  /// Data go to a terminal, which can be redrawn in place.
  bool data_on_terminal() const noexcept;

  /// One line of data, flushed. Throws std::runtime_error when it cannot be written.
  void line(std::string_view text);
  void object(const JsonObject& object) { line(object.text()); }
  /// Heading and rows.
  void table(const Table& table);
  /// Characters of a line: the terminal's width less one (some wrap when the last column is written), or 79.
  std::size_t data_width() const noexcept;
  /// Draws these lines over the screen's former content; only for a terminal.
  void redraw(const std::vector<std::string>& lines);
  /// Draws `table` over the screen's former content; only for a terminal.
  void redraw(std::string_view title, const Table& table);
  /// Data without a line end, e.g. a file's bytes; flushed.
  void bytes(std::string_view data);

  /// "cansync: " and `text` on stderr.
  void remark(std::string_view text);

 private:
  std::FILE* data_;
  std::FILE* remarks_;
  bool json_;
  bool cleared_ = false;
};

}  // namespace cansync::cli
