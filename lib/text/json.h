#pragma once

#include <concepts>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

/// Writes JSON on one line; keys stand in the order they are added. Not for realtime threads: it allocates.
namespace text {

/// `text` as a JSON string with its quotes; bytes that are no UTF-8 become U+FFFD.
std::string json_string(std::string_view text);
/// `number` as JSON; null when it is not finite.
std::string json_number(double number);

/// An array under construction.
class JsonArray {
 public:
  JsonArray& add(std::string_view text);
  JsonArray& add(const char* text) { return add(std::string_view(text)); }
  JsonArray& add(bool value);
  JsonArray& add(double value);
  JsonArray& add(std::integral auto value) { return add_json(std::to_string(+value)); }
  JsonArray& add_null();
  /// Adds what is JSON already.
  JsonArray& add_json(std::string_view json);
  std::string text() const { return "[" + items_ + "]"; }

 private:
  std::string items_;
};

/// An object under construction.
class JsonObject {
 public:
  JsonObject& add(std::string_view key, std::string_view text);
  JsonObject& add(std::string_view key, const char* text) { return add(key, std::string_view(text)); }
  JsonObject& add(std::string_view key, bool value);
  JsonObject& add(std::string_view key, double value);
  JsonObject& add(std::string_view key, std::integral auto value) {
    return add_json(key, std::to_string(+value));
  }
  JsonObject& add(std::string_view key, const JsonArray& array);
  JsonObject& add(std::string_view key, const JsonObject& object);
  JsonObject& add_null(std::string_view key);
  /// Adds what is JSON already.
  JsonObject& add_json(std::string_view key, std::string_view json);
  std::string text() const { return "{" + members_ + "}"; }

 private:
  std::string members_;
};

}  // namespace text
