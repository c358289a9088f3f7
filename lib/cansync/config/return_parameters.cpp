#include "cansync/config/return_parameters.h"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace cansyncd {

std::optional<std::uint32_t> to_raw_number(std::string_view text) {
  const bool hexadecimal = text.starts_with("0x") || text.starts_with("0X");
  if (hexadecimal) text.remove_prefix(2);
  std::uint32_t number = 0;
  const char* const last = text.data() + text.size();
  const auto [end, error] = std::from_chars(text.data(), last, number, hexadecimal ? 16 : 10);
  if (error != std::errc{} || end != last) return std::nullopt;
  return number;
}

std::optional<cansync::ParameterValue> to_return_parameter(const Scalar& item) {
  const auto* text = std::get_if<std::string>(&item);
  if (text == nullptr) return std::nullopt;
  const std::size_t equals = text->find('=');
  if (equals == std::string::npos) return std::nullopt;
  const auto number = to_raw_number(std::string_view(*text).substr(0, equals));
  const auto value = to_raw_number(std::string_view(*text).substr(equals + 1));
  if (!number || !value) return std::nullopt;
  const auto parameter = cansync::ParameterNumber::from(*number);
  if (!parameter) return std::nullopt;
  return cansync::ParameterValue{*parameter, *value};
}

bool takes_return_parameters(const Draft& /*draft*/, const Value& value) {
  if (value.kind != Value::Kind::list || value.items.size() > cansync::kListedParameters) return false;
  std::vector<cansync::ParameterNumber> seen;
  for (const Scalar& item : value.items) {
    const auto parameter = to_return_parameter(item);
    if (!parameter || std::find(seen.begin(), seen.end(), parameter->number) != seen.end()) return false;
    seen.push_back(parameter->number);
  }
  return true;
}

}  // namespace cansyncd
