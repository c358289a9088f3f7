#include "daemon/cansync/texts/limit_text.h"

#include <fmt/format.h>

#include <cmath>

#include "daemon/cansync/texts/refusal_text.h"

namespace cansyncd {
namespace {

using cansync::LimitKind;

std::string in_unit(double number, const ValueConfig& value) {
  return fmt::format("{:.12g}{}{}", number, value.unit.empty() ? "" : " ", value.unit);
}

std::string scaled(std::int64_t number, const ValueConfig& value) {
  return in_unit(static_cast<double>(number) * value.factor + value.offset, value);
}

std::string label(std::string_view kind, unsigned number, const ValueConfig& value) {
  return value.name.empty() ? fmt::format("{} {}", kind, number)
                            : fmt::format("{} {} '{}'", kind, number, value.name);
}

std::string bound_text(const cansync::LimitViolation& beyond, const ValueConfig& value, bool below) {
  const std::string limit = scaled(beyond.limit, value);
  return fmt::format("{} is {} its {} {}; write {} or {}", scaled(beyond.number, value),
                     below ? "below" : "above", below ? "minimum" : "maximum", limit, limit,
                     below ? "more" : "less");
}

std::string step_text(const cansync::LimitViolation& beyond, const ValueConfig& value) {
  return fmt::format(
      "{} is more than max_step {} from {}, sent last; begin within max_step of it, or take the bus to setup and "
      "back to run",
      scaled(beyond.number, value),
      in_unit(static_cast<double>(beyond.limit) * std::abs(value.factor), value),
      scaled(beyond.against, value));
}

std::string start_text(const cansync::LimitViolation& beyond, const ValueConfig& value,
                       const Config& config) {
  const auto& start = config.reference_limits[beyond.value].start_within;
  // Changed by a reload meanwhile.
  if (!start) return "the release does not begin near its actual value (start_within)";
  const ValueConfig& actual = config.slaves[start->slave.value()].actual[start->value];
  const std::string which = fmt::format("{} of {}", label("actual value", start->value, actual),
                                        slave_label(config, start->slave.value()));
  if (beyond.kind == LimitKind::start_unknown) {
    return fmt::format(
        "start_within needs {}, which has not been received lately; check that slave and its "
        "mapping, then write again",
        which);
  }
  return fmt::format("a release must begin within {} of {}, which is {}; found {}",
                     in_unit(start->distance, value), which, scaled(beyond.against, actual),
                     scaled(beyond.number, value));
}

std::string what(const cansync::LimitViolation& beyond, const ValueConfig& value, const Config& config) {
  switch (beyond.kind) {
    case LimitKind::minimum:
      return bound_text(beyond, value, value.factor > 0);
    case LimitKind::maximum:
      return bound_text(beyond, value, value.factor < 0);
    case LimitKind::max_step:
      return step_text(beyond, value);
    case LimitKind::start_within:
    case LimitKind::start_unknown:
      break;
  }
  return start_text(beyond, value, config);
}

std::string or_none(std::string_view name, std::int64_t number, std::int64_t none) {
  return number == none ? fmt::format("no {}", name) : fmt::format("{} {}", name, number);
}

}  // namespace

gateway::dds::Denial limit_denial(const cansync::LimitViolation& beyond, const Config& config) {
  const ValueConfig& value = config.references[beyond.value];
  return {gateway_CAUSE_FIELD,
          fmt::format("{}: {}", label("reference value", beyond.value, value), what(beyond, value, config))};
}

std::string limits_text(const cansync::ReferenceLimits& limits) {
  constexpr std::int64_t kNone = cansync::ReferenceLimits::kNone;
  std::string start = "no start_within";
  if (limits.start_within) {
    start = fmt::format("start_within {:.12g} of actual value {} of slave {}", limits.start_within->distance,
                        limits.start_within->value, limits.start_within->slave.value());
  }
  return fmt::format("{}, {}, {}, {}", or_none("minimum", limits.minimum, -kNone),
                     or_none("maximum", limits.maximum, kNone), or_none("max_step", limits.max_step, kNone),
                     start);
}

}  // namespace cansyncd
