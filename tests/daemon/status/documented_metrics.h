#pragma once

#include <fmt/format.h>

#include <fstream>
#include <set>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/status/metrics_text.h"

namespace cansyncd {

/// The rows of metrics below a heading of docs/metrics.md.
inline std::vector<std::string> documented_metrics(std::string_view heading) {
  std::ifstream file(CANSYNC_SOURCE_DIR "/docs/metrics.md");
  std::vector<std::string> rows;
  bool below = false;
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("## ")) below = line.substr(3) == heading;
    if (below && line.starts_with("| `cansync_")) rows.push_back(line);
  }
  return rows;
}

/// As they must stand there.
inline std::vector<std::string> rows_of(MetricFamilies families) {
  std::vector<std::string> rows;
  for (const MetricFamily& family : families) {
    rows.push_back(fmt::format("| `{}{}` | {} | {} | `{}` | {} |", family.name,
                               family.type == MetricType::counter ? "_total" : "", name(family.type),
                               family.labels, family.source, family.help));
  }
  return rows;
}

/// What the families are made of.
inline std::set<std::string_view> sources_of(MetricFamilies families) {
  std::set<std::string_view> sources;
  for (const MetricFamily& family : families) sources.insert(family.source);
  return sources;
}

inline std::set<std::string> lines_of(const std::string& text) {
  std::set<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.insert(line);
  return lines;
}

}  // namespace cansyncd
