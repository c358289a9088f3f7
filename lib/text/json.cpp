#include "text/json.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace text {
namespace {

/// DEL and the controls of C1, which JSON allows and some terminals obey, as escapes of the same value.
std::string without_high_controls(std::string json) {
  if (json.find_first_of("\x7F\xC2") == std::string::npos) return json;
  std::string out;
  for (std::size_t i = 0; i < json.size(); ++i) {
    const auto byte = static_cast<unsigned char>(json[i]);
    const unsigned next = i + 1 < json.size() ? static_cast<unsigned char>(json[i + 1]) : 0;
    if (byte == 0x7F)
      out += "\\u007f";
    else if (byte == 0xC2 && next < 0xA0)
      out += fmt::format("\\u{:04x}", static_cast<unsigned char>(json[++i]));
    else
      out += json[i];
  }
  return out;
}

}  // namespace

std::string json_string(std::string_view text) {
  const auto plain = [](char c) { return c >= 0x20 && c < 0x7F && c != '"' && c != '\\'; };
  if (std::all_of(text.begin(), text.end(), plain)) {
    std::string out;
    out.reserve(text.size() + 2);
    return out.append(1, '"').append(text).append(1, '"');
  }
  using nlohmann::json;
  return without_high_controls(json(text).dump(-1, ' ', false, json::error_handler_t::replace));
}

std::string json_number(double number) {
  return std::isfinite(number) ? fmt::format("{}", number) : "null";
}

JsonArray& JsonArray::add(std::string_view text) {
  return add_json(json_string(text));
}
JsonArray& JsonArray::add(bool value) {
  return add_json(value ? "true" : "false");
}
JsonArray& JsonArray::add(double value) {
  return add_json(json_number(value));
}
JsonArray& JsonArray::add_null() {
  return add_json("null");
}
JsonArray& JsonArray::add_json(std::string_view json) {
  if (!items_.empty()) items_ += ',';
  items_ += json;
  return *this;
}

JsonObject& JsonObject::add(std::string_view key, std::string_view text) {
  return add_json(key, json_string(text));
}
JsonObject& JsonObject::add(std::string_view key, bool value) {
  return add_json(key, value ? "true" : "false");
}
JsonObject& JsonObject::add(std::string_view key, double value) {
  return add_json(key, json_number(value));
}
JsonObject& JsonObject::add(std::string_view key, const JsonArray& array) {
  return add_json(key, array.text());
}
JsonObject& JsonObject::add(std::string_view key, const JsonObject& object) {
  return add_json(key, object.text());
}
JsonObject& JsonObject::add_null(std::string_view key) {
  return add_json(key, "null");
}
JsonObject& JsonObject::add_json(std::string_view key, std::string_view json) {
  if (!members_.empty()) members_ += ',';
  members_ += json_string(key);
  members_ += ':';
  members_ += json;
  return *this;
}

}  // namespace text
