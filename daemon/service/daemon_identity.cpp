#include "daemon/service/daemon_identity.h"

#include <sys/random.h>

#include <cerrno>
#include <system_error>

namespace cansyncd {

DaemonIdentity random_daemon_identity() {
  DaemonIdentity identity;
  // So few bytes never come in part.
  if (getrandom(identity.data(), identity.size(), 0) != static_cast<ssize_t>(identity.size()))
    throw std::system_error(errno, std::generic_category(), "no random numbers for the daemon's identity");
  return identity;
}

}  // namespace cansyncd
