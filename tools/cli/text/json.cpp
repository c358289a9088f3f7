#include "cli/text/json.h"

#include <fmt/format.h>

#include <cmath>

namespace cansync::cli {
namespace {

void append_escaped(std::string& out, char c) {
  switch (c) {
    case '"':
      out += "\\\"";
      break;
    case '\\':
      out += "\\\\";
      break;
    case '\n':
      out += "\\n";
      break;
    case '\r':
      out += "\\r";
      break;
    case '\t':
      out += "\\t";
      break;
    default:
      if (static_cast<unsigned char>(c) < 0x20)
        out += fmt::format("\\u{:04x}", static_cast<unsigned>(c));
      else
        out += c;
  }
}

}  // namespace

std::string json_string(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) append_escaped(out, c);
  return out + '"';
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

}  // namespace cansync::cli
