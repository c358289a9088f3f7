#include "cli/record/plot_data.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <set>

#include "cli/record/recording.h"
#include "cli/text/csv.h"
#include "cli/text/slave_list.h"
#include "cli/text/values.h"
#include "text/counts.h"

namespace cansync::cli {
namespace {

constexpr std::size_t kSeconds = 1;
constexpr std::size_t kSlave = 4;
constexpr std::size_t kNameColumn = 5;

template <class T>
std::optional<T> number(const std::string& text) {
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

/// The name of a heading "position [mm]".
std::string value_of(const std::string& heading) {
  return heading.substr(0, heading.find(" ["));
}

/// A file while it is read.
class Reading {
 public:
  Reading(std::istream& file, const std::string& name) : reader_(file, name) {}

  PlotData take(const std::vector<std::string>& values, const std::string& slaves) {
    read_header();
    choose(values);
    while (reader_.next(fields_)) {
      // What was being written when the recording was stopped is no error.
      if (reader_.broken_off() && fields_.size() != headings_.size()) {
        data_.broken_off = true;
        break;
      }
      if (fields_.front().text.starts_with('#')) continue;  // a comment
      take_row();
    }
    finish(slaves);
    return std::move(data_);
  }

 private:
  void read_header() {
    if (!reader_.next(fields_))
      throw reader_.error(1, "found nothing; expected a recording made by `cansync record`");
    for (std::size_t i = 0; i < kRecordColumns.size(); ++i) {
      const std::string found = i < fields_.size() ? fields_[i].text : "";
      const std::size_t column = i < fields_.size() ? fields_[i].column : fields_.back().column;
      if (found != kRecordColumns[i])
        throw reader_.error(column,
                            fmt::format("found '{}'; expected the heading '{}' of a recording made by "
                                        "`cansync record`",
                                        found, kRecordColumns[i]));
    }
    for (const CsvField& field : fields_) headings_.push_back(field.text);
  }

  void choose(const std::vector<std::string>& values) {
    std::vector<std::string> unknown = values;
    for (std::size_t i = kRecordColumns.size(); i < headings_.size(); ++i) {
      const std::string own = value_of(headings_[i]);
      if (!values.empty() && std::find(values.begin(), values.end(), own) == values.end()) continue;
      std::erase(unknown, own);
      chosen_.push_back(i);
    }
    if (unknown.empty() && !chosen_.empty()) return;
    std::vector<std::string> known;
    for (std::size_t i = kRecordColumns.size(); i < headings_.size(); ++i)
      known.push_back(value_of(headings_[i]));
    throw UsageError(fmt::format("--values: found '{}'; allowed, of this recording: {}",
                                 fmt::join(unknown, ","),
                                 known.empty() ? "none" : fmt::format("{}", fmt::join(known, ", "))));
  }

  double real(std::size_t index) const {
    const auto value = number<double>(fields_[index].text);
    if (!value || !std::isfinite(*value))
      throw reader_.error(fields_[index].column, fmt::format("{}: found '{}'; allowed: a number",
                                                             headings_[index], fields_[index].text));
    return *value;
  }

  void take_row() {
    if (fields_.size() != headings_.size())
      throw reader_.error(fields_.back().column,
                          fmt::format("found {}; expected {} as in line 1",
                                      text::counted(fields_.size(), "field"), headings_.size()));
    const auto slave = number<unsigned>(fields_[kSlave].text);
    if (!slave || *slave >= kSlaves)
      throw reader_.error(fields_[kSlave].column,
                          fmt::format("slave: found '{}'; allowed: 0..31", fields_[kSlave].text));
    const double time = real(kSeconds);
    names_[*slave] = fields_[kNameColumn].text;
    ++rows_[*slave];
    for (const std::size_t i : chosen_)
      if (!fields_[i].text.empty()) curves_[{i, *slave}].add({time, real(i)});
  }

  /// Mask of a list of the recording's slaves (slave_list.h), or a mask in hexadecimal.
  std::uint32_t parse_slaves(const std::string& text) const {
    if (text.starts_with("0x") || text.starts_with("0X")) return parse_slave_mask(text);
    std::uint32_t all = 0;
    std::vector<std::string> known;
    for (const auto& [slave, name] : names_) {
      all |= 1u << slave;
      known.push_back(name.empty() ? fmt::format("{}", slave) : name);
    }
    const auto find = [this](std::string_view wanted) {
      for (const auto& [slave, name] : names_)
        if (name == wanted) return static_cast<int>(slave);
      return -1;
    };
    return parse_slave_list(text, {find, [all] { return all; },
                                   [&known](std::string_view wanted) {
                                     return fmt::format("found '{}'; allowed, of this recording: {}", wanted,
                                                        fmt::join(known, ", "));
                                   }});
  }

  void finish(const std::string& slaves) {
    std::uint32_t wanted = 0xFFFFFFFF;
    if (!slaves.empty()) wanted = parse_slaves(slaves);
    for (const auto& [slave, rows] : rows_) {
      if (((wanted >> slave) & 1u) == 0) continue;
      data_.slaves.push_back(slave);
      data_.rows += rows;
    }
    for (const std::size_t i : chosen_) {
      Panel panel{headings_[i], {}};
      for (auto& [place, curve] : curves_) {
        if (place.first != i || ((wanted >> place.second) & 1u) == 0) continue;
        const std::string& name = names_[place.second];
        panel.curves.emplace_back(name.empty() ? fmt::format("slave {}", place.second) : name,
                                  std::move(curve));
      }
      if (!panel.curves.empty()) data_.panels.push_back(std::move(panel));
    }
  }

  CsvReader reader_;
  std::vector<CsvField> fields_;
  std::vector<std::string> headings_;
  std::vector<std::size_t> chosen_;
  std::map<unsigned, std::string> names_;
  std::map<unsigned, std::uint64_t> rows_;
  std::map<std::pair<std::size_t, unsigned>, Curve> curves_;
  PlotData data_;
};

}  // namespace

void Curve::add(Point point) {
  if (stretches_.empty() || stretches_.back().samples == samples_each_) {
    if (stretches_.size() == kMostStretches) merge();
    stretches_.push_back({point, point, 1});
    return;
  }
  Stretch& last = stretches_.back();
  if (point.value < last.least.value) last.least = point;
  if (point.value > last.greatest.value) last.greatest = point;
  ++last.samples;
}

void Curve::merge() {
  for (std::size_t i = 0; i + 1 < stretches_.size(); i += 2) {
    Stretch both = stretches_[i];
    const Stretch& second = stretches_[i + 1];
    if (second.least.value < both.least.value) both.least = second.least;
    if (second.greatest.value > both.greatest.value) both.greatest = second.greatest;
    both.samples += second.samples;
    stretches_[i / 2] = both;
  }
  stretches_.resize(stretches_.size() / 2);
  samples_each_ *= 2;
}

std::vector<Curve::Point> Curve::points() const {
  std::vector<Point> out;
  for (const Stretch& stretch : stretches_) {
    const bool falls = stretch.greatest.time < stretch.least.time;
    out.push_back(falls ? stretch.greatest : stretch.least);
    if (stretch.least.time != stretch.greatest.time) out.push_back(falls ? stretch.least : stretch.greatest);
  }
  return out;
}

PlotData read_recording(std::istream& file, const std::string& name, const std::vector<std::string>& values,
                        const std::string& slaves) {
  return Reading(file, name).take(values, slaves);
}

}  // namespace cansync::cli
