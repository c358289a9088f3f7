#include "config/value.h"

#include <fmt/format.h>

#include <utility>

namespace config {
namespace {

std::string in_quotes(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      out += '\\';
      out += c;
    } else if (c == '\n') {
      out += "\\n";
    } else if (c == '\t') {
      out += "\\t";
    } else if (byte < 0x20 || byte == 0x7F) {
      out += fmt::format("\\u{:04X}", byte);
    } else {
      out += c;
    }
  }
  return out + '"';
}

/// A float that reads back as a float: "2" becomes "2.0".
std::string float_text(double number) {
  std::string text = fmt::format("{}", number);
  if (text.find_first_of(".en") == std::string::npos) text += ".0";
  return text;
}

}  // namespace

std::string to_toml(const Scalar& scalar) {
  if (const auto* flag = std::get_if<bool>(&scalar)) return *flag ? "true" : "false";
  if (const auto* number = std::get_if<std::int64_t>(&scalar)) return std::to_string(*number);
  if (const auto* number = std::get_if<double>(&scalar)) return float_text(*number);
  return in_quotes(std::get<std::string>(scalar));
}

Value scalar_value(Scalar scalar) {
  std::string text = to_toml(scalar);
  Value value;
  value.kind = Value::Kind::scalar;
  value.items.push_back(std::move(scalar));
  value.text = std::move(text);
  return value;
}

Value list_value(std::vector<Scalar> items) {
  Value value;
  value.kind = Value::Kind::list;
  value.text = "[";
  for (const Scalar& item : items) {
    if (value.text.size() > 1) value.text += ", ";
    value.text += to_toml(item);
  }
  value.text += ']';
  value.items = std::move(items);
  return value;
}

}  // namespace config
