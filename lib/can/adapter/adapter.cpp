#include "can/adapter/adapter.h"

#include <algorithm>
#include <charconv>
#include <vector>

namespace can {
namespace {

constexpr std::string_view kAllowed =
    "allowed: path=PATH or serial=NUMBER, each once, and channel=0..255 with one of them, with commas between";

/// Blanks and commas would end the value in this form, and blanks in a .link file of systemd, too.
bool is_value(std::string_view text, std::size_t most) noexcept {
  return !text.empty() && text.size() < most && std::all_of(text.begin(), text.end(), [](char letter) {
    return letter > ' ' && letter < '\x7F' && letter != ',' && letter != '"';
  });
}

std::optional<std::uint32_t> channel_in(std::string_view text) noexcept {
  std::uint32_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size() || number > 255) return std::nullopt;
  return number;
}

/// False: no part of a pin, or one that was given before.
bool take(std::string_view part, AdapterPin& pin) {
  const std::size_t sign = part.find('=');
  if (sign == std::string_view::npos) return false;
  const std::string_view key = part.substr(0, sign);
  const std::string_view value = part.substr(sign + 1);
  if (key == "path" && pin.path.empty() && is_value(value, Adapter{}.path.size())) {
    pin.path = value;
    return true;
  }
  if (key == "serial" && pin.serial.empty() && is_value(value, Adapter{}.serial.size())) {
    pin.serial = value;
    return true;
  }
  if (key != "channel" || pin.channel) return false;
  pin.channel = channel_in(value);
  return pin.channel.has_value();
}

std::string joined(std::string_view path, std::string_view serial, std::optional<std::uint32_t> channel) {
  std::string out;
  const auto add = [&out](std::string_view key, std::string_view value) {
    if (value.empty()) return;
    if (!out.empty()) out += ',';
    out += key;
    out += value;
  };
  add("path=", path);
  add("serial=", serial);
  if (channel) add("channel=", std::to_string(*channel));
  return out;
}

}  // namespace

ReadPin read_pin(std::string_view text) {
  ReadPin read;
  if (text.empty()) return read;
  std::string_view rest = text;
  for (bool more = true; more;) {
    const std::size_t comma = rest.find(',');
    const std::string_view part = rest.substr(0, comma);
    if (!take(part, read.pin)) {
      read.problem = "found \"" + std::string(part) + "\"; " + std::string(kAllowed);
      return read;
    }
    more = comma != std::string_view::npos;
    if (more) rest.remove_prefix(comma + 1);
  }
  if (read.pin.path.empty() && read.pin.serial.empty())
    read.problem = "found \"" + std::string(text) + "\", which names no adapter; " + std::string(kAllowed);
  return read;
}

bool matches(const AdapterPin& pin, const Adapter& adapter) noexcept {
  return (pin.path.empty() || pin.path == adapter.path.data()) &&
         (pin.serial.empty() || pin.serial == adapter.serial.data()) &&
         (!pin.channel || *pin.channel == adapter.channel);
}

std::string text_of(const Adapter& adapter) {
  if (!adapter.known()) return {};
  return joined(adapter.path.data(), adapter.serial.data(), adapter.channel);
}

std::string text_of(const AdapterPin& pin) {
  return joined(pin.path, pin.serial, pin.channel);
}

std::string words_of(const Adapter& adapter) {
  return adapter.known() ? text_of(adapter) : "no adapter that is known (a virtual interface has none)";
}

}  // namespace can
