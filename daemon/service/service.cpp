#include "daemon/service/service.h"

#include <fmt/format.h>
#include <systemd/sd-daemon.h>

#include <chrono>
#include <cstdint>
#include <map>
#include <mutex>

namespace cansyncd::service {
namespace {

// The service runs on without its manager: a message that does not arrive changes nothing here.
void notify(const std::string& message) {
  (void)::sd_notify(0, message.c_str());
}

}  // namespace

void ready() {
  notify("READY=1");
}

void status(const std::string& bus, const std::string& text) {
  static std::mutex mutex;
  static std::map<std::string, std::string> buses;
  const std::lock_guard lock(mutex);
  buses[bus] = text;
  std::string line;
  for (const auto& [name, state] : buses) line += (line.empty() ? "" : " | ") + state;
  notify("STATUS=" + line);
}

void alive() {
  notify("WATCHDOG=1");
}

void at_work() {
  notify("WATCHDOG=1\nEXTEND_TIMEOUT_USEC=10000000");
}

std::optional<std::chrono::microseconds> watchdog() {
  std::uint64_t timeout = 0;
  if (::sd_watchdog_enabled(0, &timeout) <= 0) return std::nullopt;
  return std::chrono::microseconds(timeout);
}

void reloading() {
  using std::chrono::microseconds;
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  notify(
      fmt::format("RELOADING=1\nMONOTONIC_USEC={}", std::chrono::duration_cast<microseconds>(now).count()));
}

void stopping() {
  notify("STOPPING=1");
}

}  // namespace cansyncd::service
