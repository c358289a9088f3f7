#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <iterator>

namespace gateway::dds {

/// Names one start of a daemon. All zero: none.
using DaemonIdentity = std::array<std::uint8_t, 16>;

/// Whom a request or cancel is meant for.
enum class Addressee : std::uint8_t {
  this_daemon,
  another_daemon,  ///< another start of a daemon: that one answers, or nobody
  nobody,          ///< it names none
};

/// Whom a request that names `named` is meant for, to the daemon whose start is `own`. Any thread.
constexpr Addressee addressee(const DaemonIdentity& named, const DaemonIdentity& own) noexcept {
  if (named == DaemonIdentity{}) return Addressee::nobody;
  return named == own ? Addressee::this_daemon : Addressee::another_daemon;
}

/// The member `daemon` of a request, cancel or status.
template <class Sample>
DaemonIdentity daemon_of(const Sample& sample) noexcept {
  DaemonIdentity identity;
  std::copy(std::begin(sample.daemon), std::end(sample.daemon), identity.begin());
  return identity;
}

/// Sets that member.
template <class Sample>
void set_daemon(const DaemonIdentity& identity, Sample& sample) noexcept {
  std::copy(identity.begin(), identity.end(), std::begin(sample.daemon));
}

}  // namespace gateway::dds
