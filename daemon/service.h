#pragma once

#include <string>

/// Tells systemd how the service is; does nothing when the daemon was not started by systemd. Main thread.
namespace cansyncd::service {

void ready(const std::string& status);
void status(const std::string& text);
void reloading();
void stopping();

}  // namespace cansyncd::service
