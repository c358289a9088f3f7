#pragma once

#include <cstdint>
#include <cstdio>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cli/text/styled_text.h"
#include "cli/text/table.h"
#include "text/json.h"

/// Where results and remarks go: data to stdout, everything else to stderr.
namespace cansync::cli {

using text::json_number;
using text::json_string;
using text::JsonArray;
using text::JsonObject;

/// When data have colours.
enum class ColourUse : unsigned char {
  automatic,  ///< on a terminal that draws, unless the environment has NO_COLOR
  always,
  never,
};

class Output {
 public:
  /// Both files stay open and belong to the caller; data are not buffered. `json`: data as objects, one a
  /// line.
  Output(std::FILE* data, std::FILE* remarks, bool json) : data_(data), remarks_(remarks), json_(json) {}

  /// To the same files, with another form and another place (set_place).
  Output for_line(bool json, std::string place) const {
    Output line(data_, remarks_, json);
    line.set_place(std::move(place));
    line.colours_ = colours_;
    line.wide_ = wide_;
    return line;
  }

  bool json() const noexcept { return json_; }
  /// Data go to a terminal, which can be redrawn in place.
  bool data_on_terminal() const noexcept;

  /// Default: automatic.
  void set_colours(ColourUse use) noexcept { colours_ = use; }
  /// Data for people have colours.
  bool colours() const noexcept;
  /// `text` as a terminal shows it in this style; as it is where there are no colours.
  std::string painted(std::string_view text, Style style) const;

  /// What follows concerns this slave of several: a line begins with "slave 3: ", and a table stands below a
  /// line "slave 3:". Objects and bytes stay as they are. Nothing: ends it.
  void set_slave(std::optional<unsigned> slave);
  /// From now on lines and remarks of slaves are kept until `end_group`, where those that differ in nothing but the number of
  /// their slave become one: "slaves 0-3: ...". Tables, objects and bytes are written at once.
  void begin_group() { grouping_ = true; }
  /// Writes what was kept of the slave, now.
  void say_kept();
  /// Writes what was kept, in the order of the first slave of each group.
  void end_group();
  /// What every remark begins with, after "cansync: "; empty: nothing.
  void set_place(std::string place) { place_ = std::move(place); }
  /// The last remark, without `place`.
  const std::string& last_remark() const noexcept { return last_remark_; }

  /// One line of data. Throws std::system_error when it cannot be written.
  void line(std::string_view text);
  void object(const JsonObject& object) { bytes(object.text() + '\n'); }
  /// Heading and rows, row n in the style `rows[n]`. On a terminal, unless everything is wanted (set_wide),
  /// in those columns that fit, with a remark when some do not.
  void table(const Table& table, const std::vector<Style>& rows = {});
  /// Characters of a line: the terminal's width less one (some wrap when the last column is written), or 79.
  std::size_t data_width() const noexcept;
  /// Default: false. True: lines and tables have all there is, however wide it is.
  void set_wide(bool wide) noexcept { wide_ = wide; }
  /// Characters that lines are to fit into: those of the terminal; 0: as many as they have, which is so where
  /// data go elsewhere, so that scripts find the same lines everywhere.
  std::size_t fitting_width() const noexcept { return wide_ || !data_on_terminal() ? 0 : data_width(); }
  /// Draws these lines over the screen's former content; only for a terminal.
  void redraw(const std::vector<std::string>& lines);
  /// Draws `table` over the screen's former content; only for a terminal.
  void redraw(std::string_view title, const Table& table);
  /// Data without a line end, e.g. a file's bytes.
  void bytes(std::string_view data);

  /// "cansync: " and `text` on stderr.
  void remark(std::string_view text);
  /// The same at once, also while what slaves have in common is kept back: what is being waited for.
  void remark_now(std::string_view text) const;

 private:
  /// A line or remark of a slave; its number is left out where it is `kSlaveHere`.
  struct Kept {
    bool data = false;
    std::string text;
    bool operator==(const Kept&) const = default;
  };
  /// Slaves of which the same is to be said.
  struct Group {
    std::uint32_t slaves = 0;
    std::vector<Kept> said;
  };
  void keep(bool data, std::string_view text);
  void say(const Group& group);

  std::FILE* data_;
  std::FILE* remarks_;
  bool json_;
  bool cleared_ = false;
  bool wide_ = false;
  ColourUse colours_ = ColourUse::automatic;
  std::string slave_;  ///< "slave 3:"; empty: none of several
  std::string place_;
  std::string last_remark_;
  bool grouping_ = false;
  std::optional<unsigned> of_slave_;
  std::vector<Kept> kept_;  ///< of that slave
  std::vector<Group> groups_;
};

}  // namespace cansync::cli
