#include "text/json.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

namespace text {
std::string json_string(std::string_view text) {
  using nlohmann::json;
  return json(text).dump(-1, ' ', false, json::error_handler_t::replace);
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
