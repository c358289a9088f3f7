#include "daemon/status/metrics_text.h"

#include <fmt/format.h>

#include <utility>

namespace cansyncd {

std::string label(std::string_view name, std::string_view value) {
  std::string out = fmt::format("{}=\"", name);
  for (const char c : value) {
    if (c == '\n') {
      out += "\\n";
      continue;
    }
    if (c == '\\' || c == '"') out.push_back('\\');
    out.push_back(c);
  }
  out.push_back('"');
  return out;
}

MetricSamples::MetricSamples(std::string_view bus) : bus_(label("bus", bus)) {}

void MetricSamples::add(std::string_view labels, std::uint64_t value, std::string_view suffix) {
  line(labels, suffix, fmt::format("{}", value));
}

void MetricSamples::add(std::string_view labels, std::int64_t value, std::string_view suffix) {
  line(labels, suffix, fmt::format("{}", value));
}

void MetricSamples::add(std::string_view labels, double value, std::string_view suffix) {
  line(labels, suffix, fmt::format("{}", value));
}

void MetricSamples::line(std::string_view labels, std::string_view suffix, std::string_view value) {
  text_ += fmt::format("{}{}{{{}{}{}}} {}\n", name_, suffix, bus_, labels.empty() ? "" : ",", labels, value);
}

std::string MetricSamples::take() {
  return std::exchange(text_, {});
}

std::string_view name(MetricType type) noexcept {
  switch (type) {
    case MetricType::counter:
      return "counter";
    case MetricType::histogram:
      return "histogram";
    case MetricType::gauge:
      break;
  }
  return "gauge";
}

std::string_view MetricFamily::unit() const noexcept {
  for (const std::string_view base : {"seconds", "ratio", "bits_per_second"})
    if (name.ends_with(base)) return base;
  return {};
}

namespace {

void add_family(const MetricFamily& family, const MetricsSource& from, MetricSamples& samples,
                std::string& out) {
  const std::string full =
      fmt::format("{}{}", family.name, family.type == MetricType::counter ? "_total" : "");
  samples.begin(full);
  if (family.fill != nullptr)
    family.fill(from, samples);
  else
    fill_from_member(family, from, samples);
  const std::string lines = samples.take();
  // A family without samples is left out, as for the time before the first sample of Timing.
  if (lines.empty()) return;
  out +=
      fmt::format("# HELP {} {}\n# TYPE {} {}\n", family.name, family.help, family.name, name(family.type));
  if (!family.unit().empty()) out += fmt::format("# UNIT {} {}\n", family.name, family.unit());
  out += lines;
}

}  // namespace

std::string metrics_text(const MetricsSource& from, std::initializer_list<MetricFamilies> families) {
  MetricSamples samples(from.bus);
  std::string out;
  for (const MetricFamilies& some : families) {
    for (const MetricFamily& family : some) add_family(family, from, samples, out);
  }
  return out + "# EOF\n";
}

}  // namespace cansyncd
