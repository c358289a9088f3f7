#pragma once

#include <string>

/// Tells systemd how the service is; does nothing when the daemon was not started by systemd. Main thread.
namespace cansyncd::service {

void ready(const std::string& status);  ///< started, or reloaded; `status` is what `systemctl status` shows
void reloading();                       ///< the configuration is being read again; `ready` ends it
void stopping();                        ///< about to end

}  // namespace cansyncd::service
