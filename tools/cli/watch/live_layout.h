#pragma once

#include <string>
#include <vector>

#include "cli/text/styled_text.h"
#include "cli/watch/live_view.h"

/// What the live view shows: from what is known and how it is looked at to the lines of a screen. Pure
/// functions; any thread.
namespace cansync::cli {

/// Size of a screen in characters.
struct ScreenSize {
  std::size_t columns = 80;
  std::size_t rows = 24;
};

inline constexpr ScreenSize kLeastScreen{60, 12};

/// Characters the terminal has.
enum class Symbols : unsigned char { ascii, unicode };

/// The screen: at most `size.rows` lines of at most `size.columns` characters. On a screen smaller than
/// kLeastScreen it says how large it is to be.
std::vector<StyledLine> live_lines(const LiveModel& model, const ViewState& state, ScreenSize size,
                                   Symbols symbols);

/// What keys need to know of that screen.
ViewFacts view_facts(const LiveModel& model, const ViewState& state, ScreenSize size);

/// A line of `width` characters at most that goes up and down like the points, between their least and
/// greatest one; a space where there is no point.
std::string trend_line(const std::vector<std::optional<double>>& points, std::size_t width, Symbols symbols);

/// A bar of `width` characters that is filled to `permille` (0..1000) of them.
std::string load_bar(std::uint32_t permille, std::size_t width, Symbols symbols);

/// The lines above the table: bus, state, timing, load.
std::vector<StyledLine> header_lines(const LiveModel& model, const ViewState& state, ScreenSize size,
                                     Symbols symbols);

/// The table: its heading, then `rows` lines.
std::vector<StyledLine> table_lines(const LiveModel& model, const ViewState& state, std::size_t columns,
                                    std::size_t rows, Symbols symbols);

/// What the columns and keys mean, for the help of the verb.
std::string live_help();

/// The page that explains the keys.
std::vector<StyledLine> help_lines();

}  // namespace cansync::cli
