#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "dds/daemon_identity.h"
#include "dds/endpoint.h"
#include "dds/overview/overview_topics.h"
#include "dds/participant.h"
#include "dds/signal.h"

namespace gateway::dds {

/// Who is connected to a daemon and what is open there, as it told last.
struct OpenRequestsNow {
  DaemonIdentity daemon = {};
  std::uint32_t connected = 0;  ///< all of them, also those that `programs` has no room for
  std::vector<gateway_ConnectedProgram> programs;
  std::uint32_t open = 0;  ///< likewise
  std::vector<gateway_OpenRequest> requests;
};

/// Reads topic OpenRequests. One thread.
class OpenRequestsReader {
 public:
  /// `participant` and `signal` (may be null) must outlive the object. Throws SetupError.
  OpenRequestsReader(const Participant& participant, DataSignal* signal) : reader_(participant, signal) {}

  /// Takes what has come; the newest, or nothing: none has come yet.
  const std::optional<OpenRequestsNow>& look();

  /// Is there a daemon that tells it?
  bool matched() const noexcept { return reader_.matched() != 0; }

 private:
  Reader<gateway_OpenRequests> reader_;
  std::optional<OpenRequestsNow> newest_;
};

/// "'recipes' (loader, process 12 on host plc7)": whose request it is; never empty.
std::string owner_of(const OpenRequestsNow& now, const gateway_OpenRequest& request);

/// "download 3000 bytes to slave 3 of 'recipes' (…) is at 12 %": what the request waits for; empty: it does
/// not wait, or that is not known.
std::string waited_for(const OpenRequestsNow& now, const gateway_OpenRequest& request);

}  // namespace gateway::dds
