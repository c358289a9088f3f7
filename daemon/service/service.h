#pragma once

#include <chrono>
#include <optional>
#include <string>

/// Tells systemd how the service is; does nothing when the daemon was not started by systemd. Any thread but
/// the realtime thread.
namespace cansyncd::service {

void ready();  ///< started, or reloaded
/// What `systemctl status` shows of a bus; with several buses all of them in one line.
void status(const std::string& bus, const std::string& text);
void alive();      ///< feeds the watchdog
void at_work();    ///< feeds the watchdog, and moves the end of a start or reload that takes long away
void reloading();  ///< the configuration is being read again; `ready` ends it
void stopping();   ///< about to end

/// Time after which the manager's watchdog takes an unfed service for hung; nothing: there is no watchdog.
std::optional<std::chrono::microseconds> watchdog();

}  // namespace cansyncd::service
