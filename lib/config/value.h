#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

/// Values of a TOML file; no parser in it.
namespace config {

/// One scalar of TOML.
using Scalar = std::variant<bool, std::int64_t, double, std::string>;

/// A value as it was found: one scalar, a list of scalars, or something no option takes (neither).
struct Value {
  enum class Kind : std::uint8_t { scalar, list, other };
  Kind kind = Kind::other;
  std::vector<Scalar> items;  ///< one for a scalar
  std::string text;           ///< the same in TOML's notation, for messages and comparisons
};

/// A scalar in TOML's notation.
std::string to_toml(const Scalar& scalar);

/// A value with its text filled in.
Value scalar_value(Scalar scalar);
Value list_value(std::vector<Scalar> items);

/// The scalar's content when it has that type, else null.
template <class T>
const T* scalar(const Value& value) noexcept {
  return value.kind == Value::Kind::scalar ? std::get_if<T>(&value.items.front()) : nullptr;
}

}  // namespace config
