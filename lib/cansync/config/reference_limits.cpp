#include "cansync/config/reference_limits.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string_view>
#include <utility>

#include "cansync/config/rows.h"
#include "config/fields.h"

namespace cansyncd {
namespace {

using namespace config::rows;  // the table reads better without the prefix in every line
using namespace rows;

constexpr std::size_t kSlaveItem = 0;
constexpr std::size_t kValueItem = 1;
constexpr std::size_t kDistanceItem = 2;

ReferenceLimitsConfig& limits_of(Draft& draft) {
  return draft.config.reference_limits[draft.value];
}

constexpr auto kLimitRows = std::to_array<Row>({
    {example("-3000.0",
             reloadable(real_number(
                 "reference.minimum", "(no limit)", false,
                 "Least value that is released, in the value's unit. A sample with a value beyond a limit is "
                 "refused completely: what was released before continues as long as it was given for."))),
     [](Draft& d, const Value& v) { limits_of(d).minimum = real(v); }},
    {example("3000.0",
             reloadable(real_number("reference.maximum", "(no limit)", false,
                                    "Greatest value that is released, in the value's unit. See minimum."))),
     [](Draft& d, const Value& v) { limits_of(d).maximum = real(v); }},
    {example("20.0",
             reloadable(real_number(
                 "reference.max_step", "(no limit)", true,
                 "Greatest difference between two values that follow each other on the bus, in the value's "
                 "unit. Intervals without a telegram do not add to it. See minimum."))),
     [](Draft& d, const Value& v) { limits_of(d).max_step = real(v); }},
    {example(
         "[\"slave0\", 0, 50.0]",
         reloadable(other(
             "reference.start_within", kStartWithinWords, "(no limit)",
             "The first value of a release must be within this distance, in the reference value's unit, of "
             "that actual value of that slave. Needs process.poll_without_reference = true. See minimum."))),
     [](Draft& d, const Value& v) { d.start_within[d.value] = v; }, takes_start_within},
});

/// A number of a [[reference]] and what its mapping can carry.
struct Range {
  double lowest = 0.0;
  double highest = 0.0;
  std::string_view width = "32 bits";
};

Range range_of(const Draft& draft, unsigned value) {
  const bool word = ((cansync::word_mask(draft.config.master.process.reference_mapping) >> value) & 1u) != 0;
  const bool is_signed = draft.config.references[value].is_signed;
  const std::string_view width = word ? "16 bits" : "32 bits";
  const double half = word ? 0x8000 : 0x8000'0000;
  return is_signed ? Range{-half, half - 1, width} : Range{0.0, 2 * half - 1, width};
}

std::string number_text(double number) {
  return fmt::format("{:.12g}", number);
}

/// Whole numbers next to `number`; scaling by decimal factors leaves a rest that is none.
double rounded_up(double number) {
  const double rest = std::max(1e-6, std::abs(number) * 1e-12);
  return std::abs(number - std::round(number)) <= rest ? std::round(number) : std::ceil(number);
}
double rounded_down(double number) {
  return -rounded_up(-number);
}

const ValueConfig& actual_of(const Draft& draft, unsigned slave, unsigned value) {
  return draft.config.slaves[slave].actual[value];
}

/// The actual value of that number or name.
std::optional<std::uint8_t> find_actual(const Draft& draft, unsigned slave, const Scalar& which) {
  if (const auto* number = std::get_if<std::int64_t>(&which)) {
    if (*number < 0 || *number >= cansync::kValues) return std::nullopt;
    return static_cast<std::uint8_t>(*number);
  }
  const auto* name = std::get_if<std::string>(&which);
  for (std::uint8_t v = 0; name != nullptr && v < cansync::kValues; ++v) {
    if (!name->empty() && actual_of(draft, slave, v).name == *name) return v;
  }
  return std::nullopt;
}

/// Turns the limits of one reference value into numbers.
class LimitsOfValue {
 public:
  LimitsOfValue(Draft& draft, unsigned value, std::vector<LimitProblem>& problems)
      : draft_(draft),
        value_(value),
        problems_(problems),
        scaling_(draft.config.references[value]),
        given_(draft.config.reference_limits[value]),
        range_(range_of(draft, value)) {}

  void finish() {
    limits_.is_signed = scaling_.is_signed;
    if (given_.minimum) bound("minimum", *given_.minimum, scaling_.factor > 0);
    if (given_.maximum) bound("maximum", *given_.maximum, scaling_.factor < 0);
    if (given_.max_step) step(*given_.max_step);
    if (draft_.start_within[value_]) start(draft_.start_within[value_]->items);
    if (wrong_) return;
    if (limits_.minimum > limits_.maximum) {
      problem(
          given_.minimum ? "minimum" : "maximum",
          fmt::format("found {}, and maximum is {}; allowed: a minimum up to the maximum, with a number of "
                      "the factor between them",
                      number_text(given_.minimum.value_or(0)), number_text(given_.maximum.value_or(0))));
      return;
    }
    draft_.config.master.process.reference_limits[value_] = limits_;
  }

 private:
  void problem(std::string_view option, std::string text) {
    wrong_ = true;
    problems_.push_back({fmt::format("reference.{}.{}", value_, option), std::move(text)});
  }

  double scaled(double number) const { return number * scaling_.factor + scaling_.offset; }

  void bound(std::string_view option, double limit, bool lower) {
    const double number = (limit - scaling_.offset) / scaling_.factor;
    const double low = rounded_up(number);
    const double high = rounded_down(number);
    if (!(low >= range_.lowest && high <= range_.highest)) {
      const auto [least, most] = std::minmax({scaled(range_.lowest), scaled(range_.highest)});
      problem(option, fmt::format("found {}; allowed: {}..{}, which is what {} {} a sign hold with this "
                                  "factor and offset",
                                  number_text(limit), number_text(least), number_text(most), range_.width,
                                  scaling_.is_signed ? "with" : "without"));
    } else if (lower) {
      limits_.minimum = static_cast<std::int64_t>(low);
    } else {
      limits_.maximum = static_cast<std::int64_t>(high);
    }
  }

  void step(double limit) {
    const double number = rounded_down(limit / std::abs(scaling_.factor));
    const double most = range_.highest - range_.lowest;
    if (number >= 1 && number <= most) {
      limits_.max_step = static_cast<std::int64_t>(number);
      return;
    }
    problem("max_step",
            fmt::format("found {}; allowed: {}..{}, from one number to all that {} hold with this factor",
                        number_text(limit), number_text(std::abs(scaling_.factor)),
                        number_text(most * std::abs(scaling_.factor)), range_.width));
  }

  void start(const std::vector<Scalar>& items) {
    const auto slave = find_slave(draft_.config, items[kSlaveItem]);
    if (!slave) {
      return problem("start_within",
                     fmt::format("found slave {}; allowed: number or name of a configured slave",
                                 config::to_toml(items[kSlaveItem])));
    }
    const auto actual = find_actual(draft_, slave->value(), items[kValueItem]);
    if (!actual) {
      return problem(
          "start_within",
          fmt::format("found actual value {}; allowed: 0..7 or the name of an actual value of slave {}",
                      config::to_toml(items[kValueItem]), slave->value()));
    }
    if (auto why = never_comes(*slave, *actual)) return problem("start_within", std::move(*why));
    const double distance = config::rows::real(config::scalar_value(items[kDistanceItem]));
    given_.start_within = StartWithinConfig{*slave, *actual, distance};
    const ValueConfig& from = actual_of(draft_, slave->value(), *actual);
    limits_.start_within = cansync::StartWithin{
        *slave,
        *actual,
        from.is_signed,
        from.factor / scaling_.factor,
        (from.offset - scaling_.offset) / scaling_.factor,
        distance / std::abs(scaling_.factor),
    };
  }

  /// Why this actual value cannot come before a release.
  std::optional<std::string> never_comes(cansync::SlaveNumber slave, std::uint8_t actual) const {
    const cansync::ProcessSettings& process = draft_.config.master.process;
    const unsigned channel = actual / cansync::kWords;
    if (!process.poll_without_reference) {
      return "found without process.poll_without_reference = true; allowed: beside it, because actual values "
             "come else only while reference values are released";
    }
    const cansync::Cursor& cursor = process.polling[channel];
    const bool asked = cursor.kind == cansync::Cursor::Kind::automatic
                           ? slave.value() <= process.maximum_slave.value()
                           : cursor.kind == cansync::Cursor::Kind::fixed && cursor.slave == slave;
    if (!asked) {
      return fmt::format(
          "found slave {}, which process.polling_{} does not ask; allowed: a slave that is asked for this "
          "actual value",
          slave.value(), channel + 1);
    }
    const auto& mapping = draft_.config.master.slaves[slave.value()].actual_mapping[channel];
    if (((mapping.value_mask() >> actual) & 1u) == 0) {
      return fmt::format(
          "found actual value {}, which the mapping of slave {} does not carry; allowed: a mapped "
          "actual value",
          actual, slave.value());
    }
    return std::nullopt;
  }

  Draft& draft_;
  unsigned value_;
  std::vector<LimitProblem>& problems_;
  const ValueConfig& scaling_;
  ReferenceLimitsConfig& given_;
  Range range_;
  cansync::ReferenceLimits limits_;
  bool wrong_ = false;
};

}  // namespace

bool takes_start_within(const Draft& /*draft*/, const Value& value) {
  if (value.kind != Value::Kind::list || value.items.size() != 3) return false;
  const auto names = [](const Scalar& item) {
    return std::holds_alternative<std::int64_t>(item) || std::holds_alternative<std::string>(item);
  };
  const Scalar& distance = value.items[kDistanceItem];
  const bool number =
      std::holds_alternative<std::int64_t>(distance) || std::holds_alternative<double>(distance);
  if (!names(value.items[kSlaveItem]) || !names(value.items[kValueItem]) || !number) return false;
  const double length = config::rows::real(config::scalar_value(distance));
  return std::isfinite(length) && length >= 0.0;
}

std::vector<LimitProblem> finish_reference_limits(Draft& draft) {
  std::vector<LimitProblem> problems;
  for (unsigned value = 0; value < cansync::kValues; ++value) LimitsOfValue(draft, value, problems).finish();
  return problems;
}

std::span<const Row> rows::reference_limit_options() {
  return kLimitRows;
}

}  // namespace cansyncd
