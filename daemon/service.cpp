#include "daemon/service.h"

#include <fmt/format.h>
#include <systemd/sd-daemon.h>

#include <chrono>

namespace cansyncd::service {
namespace {

// The service runs on without its manager: a message that does not arrive changes nothing here.
void notify(const std::string& message) {
  (void)::sd_notify(0, message.c_str());
}

}  // namespace

void ready(const std::string& status) {
  notify("READY=1\nSTATUS=" + status);
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
