#pragma once

#include <cstddef>
#include <cstdint>
#include <istream>
#include <map>
#include <string>
#include <utility>
#include <vector>

/// What a recording (`record`) has to plot. No files of its own; one thread.
namespace cansync::cli {

/// The course of one value of one slave in a bounded number of points: however long it is, the least and the
/// greatest value of every stretch of time stay.
class Curve {
 public:
  static constexpr std::size_t kMostStretches = 2048;

  struct Point {
    double time = 0;  ///< s
    double value = 0;
  };

  /// Times are expected to rise.
  void add(Point point);
  /// In the order they came.
  std::vector<Point> points() const;

 private:
  /// Points that stand for `samples` ones in a row.
  struct Stretch {
    Point least;
    Point greatest;
    std::uint64_t samples = 0;
  };
  void merge();

  std::vector<Stretch> stretches_;
  std::uint64_t samples_each_ = 1;
};

/// One value, or several slaves' values of that name: a panel of the plot.
struct Panel {
  std::string heading;                                ///< "position [mm]"
  std::vector<std::pair<std::string, Curve>> curves;  ///< by slave
};

struct PlotData {
  std::vector<Panel> panels;
  std::vector<unsigned> slaves;  ///< numbers, rising
  std::uint64_t rows = 0;        ///< that were taken
  bool broken_off = false;       ///< the last line had no end and was left out
};

/// Reads a recording. `values`: these alone, by the name before the unit (empty: all). `slaves`: a set as in
/// `parse_slave_set`, by number or name (empty: all). Throws CsvError with line and column for what is no
/// recording, UsageError for a value or slave that is not in it.
PlotData read_recording(std::istream& file, const std::string& name, const std::vector<std::string>& values,
                        const std::string& slaves);

}  // namespace cansync::cli
