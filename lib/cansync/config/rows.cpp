#include "cansync/config/rows.h"

namespace cansyncd {
namespace {

bool takes_four_numbers(const Value& value, std::int64_t minimum, std::int64_t maximum) {
  return value.kind == Value::Kind::list && value.items.size() == cansync::kWords &&
         std::all_of(value.items.begin(), value.items.end(), [&](const Scalar& item) {
           const auto* number = std::get_if<std::int64_t>(&item);
           return number != nullptr && *number >= minimum && *number <= maximum;
         });
}

}  // namespace

bool rows::takes_cursor(const Draft& draft, const Value& value) {
  if (value.kind != Value::Kind::scalar) return false;
  const auto* word = scalar<std::string>(value);
  if (word != nullptr && (*word == "automatic" || *word == "nobody")) return true;
  return find_slave(draft.config, value.items.front()).has_value();
}

bool rows::takes_slaves(const Draft& draft, const Value& value) {
  return value.kind == Value::Kind::list &&
         std::all_of(value.items.begin(), value.items.end(),
                     [&](const Scalar& item) { return find_slave(draft.config, item).has_value(); });
}

bool rows::takes_registers(const Draft& /*draft*/, const Value& value) {
  constexpr int kMostRegister = 127;
  return takes_four_numbers(value, 0, kMostRegister);
}

bool rows::takes_value_numbers(const Draft& /*draft*/, const Value& value) {
  return takes_four_numbers(value, -1, cansync::kValues - 1);
}

bool rows::takes_flags(const Draft& /*draft*/, const Value& value) {
  return value.kind == Value::Kind::list && value.items.size() == cansync::kWords &&
         std::all_of(value.items.begin(), value.items.end(),
                     [](const Scalar& item) { return std::holds_alternative<bool>(item); });
}

std::optional<cansync::SlaveNumber> rows::find_slave(const Config& config, const Scalar& who) {
  const auto configured = [&](std::uint64_t number) { return config.master.slaves[number].configured; };
  if (const auto* number = std::get_if<std::int64_t>(&who)) {
    if (*number < 0 || *number >= cansync::kSlaves || !configured(static_cast<std::uint64_t>(*number))) {
      return std::nullopt;
    }
    return cansync::SlaveNumber::from(static_cast<std::uint64_t>(*number));
  }
  const auto* name = std::get_if<std::string>(&who);
  if (name == nullptr) return std::nullopt;
  for (unsigned n = 0; n < cansync::kSlaves; ++n) {
    if (configured(n) && config.slaves[n].name == *name) return cansync::SlaveNumber::from(n);
  }
  return std::nullopt;
}

cansync::Cursor rows::to_cursor(const Config& config, const Value& value) {
  using Kind = cansync::Cursor::Kind;
  if (const auto* word = scalar<std::string>(value)) {
    if (*word == "automatic") return {Kind::automatic, {}};
    if (*word == "nobody") return {Kind::nobody, {}};
  }
  const auto slave = find_slave(config, value.items.front());
  return slave ? cansync::Cursor{Kind::fixed, *slave} : cansync::Cursor{Kind::nobody, {}};
}

Value rows::to_value(const cansync::Cursor& cursor) {
  using Kind = cansync::Cursor::Kind;
  if (cursor.kind == Kind::fixed) return config::scalar_value(std::int64_t{cursor.slave.value()});
  return config::scalar_value(std::string(cursor.kind == Kind::automatic ? "automatic" : "nobody"));
}

cansync::SlaveMask rows::slave_mask(const Config& config, const Value& value) {
  cansync::SlaveMask mask;
  for (const Scalar& item : value.items) {
    if (const auto slave = find_slave(config, item)) mask.set(*slave);
  }
  return mask;
}

}  // namespace cansyncd
