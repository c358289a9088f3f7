#include "cli/record/plot_script.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>

namespace cansync::cli {
namespace {

constexpr unsigned kWidth = 1100;  // px, like all that follow
constexpr unsigned kHead = 60;
constexpr unsigned kPanel = 240;
constexpr unsigned kKeyLine = 18;
/// Curves in one column of the key.
constexpr std::size_t kKeyRows = 16;

/// Colours that are told apart on white, also by people who do not see red and green (after Okabe and Ito).
constexpr std::array<std::string_view, 8> kColours{"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                                   "#56b4e9", "#e69f00", "#000000", "#8c6d1f"};
/// Beyond the colours curves are told apart by their dashes.
constexpr std::array<unsigned, 4> kDashes{1, 2, 4, 5};

/// A string in single quotes, in which gnuplot looks for nothing but the closing quote.
std::string in_quotes(std::string_view text) {
  std::string out = "'";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x20 || byte == 0x7F)
      out += ' ';
    else if (c == '\'')
      out += "''";
    else
      out += c == '`' ? '"' : c;
  }
  return out + "'";
}

/// Whether the key of the first panel tells this one's curves too.
bool has_own_key(const PlotData& data, std::size_t index) {
  const auto same = [](const auto& a, const auto& b) { return a.first == b.first; };
  const auto& first = data.panels.front().curves;
  const auto& own = data.panels[index].curves;
  return index == 0 || !std::equal(first.begin(), first.end(), own.begin(), own.end(), same);
}

unsigned panel_height(const PlotData& data, std::size_t index) {
  const std::size_t rows =
      has_own_key(data, index) ? std::min(data.panels[index].curves.size(), kKeyRows) : 0;
  return std::max(kPanel, 70 + kKeyLine * static_cast<unsigned>(rows));
}

std::string data_blocks(const PlotData& data) {
  std::string out;
  std::size_t block = 0;
  for (const Panel& panel : data.panels) {
    for (const auto& [name, curve] : panel.curves) {
      out += fmt::format("$curve{} << END\n", block++);
      for (const Curve::Point& point : curve.points()) out += fmt::format("{} {}\n", point.time, point.value);
      out += "END\n";
    }
  }
  return out;
}

double end_of(const PlotData& data) {
  double end = 0;
  for (const Panel& panel : data.panels)
    for (const auto& [name, curve] : panel.curves)
      for (const Curve::Point& point : curve.points()) end = std::max(end, point.time);
  return end > 0 ? end : 1;
}

}  // namespace

std::string plot_script(const PlotData& data, std::string_view title, PlotFormat format) {
  unsigned height = kHead;
  std::size_t keys = 1;
  for (std::size_t i = 0; i < data.panels.size(); ++i) {
    height += panel_height(data, i);
    keys = std::max(keys, (data.panels[i].curves.size() + kKeyRows - 1) / kKeyRows);
  }
  std::string out = fmt::format(
      "set encoding utf8\nset terminal {} size {},{} background rgb '#ffffff' font 'sans-serif,12' "
      "noenhanced\n",
      format == PlotFormat::svg ? "svg" : "pngcairo", kWidth, height);
  out += data_blocks(data);
  out += fmt::format("set multiplot title {} font 'sans-serif,15' noenhanced\n", in_quotes(title));
  out += "set grid lc rgb '#dddddd' lt 1\nset border 3 lc rgb '#555555'\nset tics nomirror\n";
  const std::string key = fmt::format(
      "set key outside right top vertical maxrows {} Left reverse noenhanced samplen 2\n", kKeyRows);
  out += fmt::format("set lmargin at screen 0.085\nset rmargin at screen {:.3f}\n",
                     0.99 - 0.175 * static_cast<double>(keys));
  out += fmt::format("set xrange [0:{}]\n", end_of(data));
  double top = 1.0 - static_cast<double>(kHead) / height * 0.62;
  std::size_t block = 0;
  for (std::size_t i = 0; i < data.panels.size(); ++i) {
    const Panel& panel = data.panels[i];
    const double share = static_cast<double>(panel_height(data, i)) / height;
    out += fmt::format("set tmargin at screen {:.4f}\nset bmargin at screen {:.4f}\n", top - 12.0 / height,
                       top - share + 26.0 / height);
    top -= share;
    out += fmt::format("set ylabel {} offset 1 noenhanced\n", in_quotes(panel.heading));
    if (i + 1 == data.panels.size()) out += "set xlabel 'time in s' offset 0,0.4\n";
    out += has_own_key(data, i) ? key : "set key off\n";
    std::string curves;
    for (std::size_t n = 0; n < panel.curves.size(); ++n)
      curves += fmt::format("{} $curve{} using 1:2 with lines lw 1.7 lc rgb '{}' dt {} title {}",
                            n == 0 ? "plot" : ",", block++, kColours[n % kColours.size()],
                            kDashes[n / kColours.size() % kDashes.size()], in_quotes(panel.curves[n].first));
    out += curves + '\n';
  }
  return out + "unset multiplot\n";
}

}  // namespace cansync::cli
