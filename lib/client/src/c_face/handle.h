#pragma once

#include <cansync/cansync_c.h>
#include <cansync/client.h>

#include <atomic>
#include <exception>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "profile/named.h"

/// What stands behind the handle of the C face. Internal to lib/client.
struct cansync_client {
  std::optional<cansync::client::Client> client;
  std::string error;                                                          ///< of the last call
  cansync::client::RefusalCause cause = cansync::client::RefusalCause::none;  ///< likewise
  std::atomic<bool> stop = false;  ///< the transfer that is waited for is to be cancelled
  std::vector<std::string> profile_folders;
  std::map<std::string, profile::NamedProfile> profiles;  ///< by SHA-256
  // After the client: they end before it.
  std::optional<cansync::client::ReferenceWriter> writer;
  cansync::client::Subscription actual_values;
  cansync::client::Subscription events;
};

namespace cansync::client::c_face {

/// Keeps the reason and gives the result back. `Handle`: cansync_client or cansync_application.
template <class Handle>
int fail(Handle& handle, int result, const std::string& reason) {
  handle.error = reason;
  return result;
}

/// What the options say; NULL: the defaults.
Options options_of(const cansync_options* given);

/// The result that stands for a code.
int number_of(ReplyCode code) noexcept;

/// The result of a reply; cause and reason are kept, with who said it.
int result_of(cansync_client& handle, const Reply& reply);

/// The result of looking at what no daemon that is there has told.
int not_told(cansync_client& handle, const Client& client);

/// Runs `call(handle)` and turns what it throws into a result.
template <class Handle, class Call>
int guarded(Handle* handle, Call&& call) noexcept {
  if (handle == nullptr) return CANSYNC_INVALID;
  try {
    handle->error.clear();
    handle->cause = RefusalCause::none;
    return std::forward<Call>(call)(*handle);
  } catch (const NoDaemon& error) {
    return fail(*handle, CANSYNC_NO_DAEMON, error.what());
  } catch (const SetupError& error) {
    return fail(*handle, CANSYNC_SETUP_FAILED, error.what());
  } catch (const std::exception& error) {
    return fail(*handle, CANSYNC_FAILED, error.what());
  }
}

/// Like `guarded`, for a handle that must be connected: `call(handle, client)`.
template <class Call>
int connected(cansync_client* handle, Call&& call) noexcept {
  return guarded(handle, [&](cansync_client& open) {
    if (!open.client)
      return fail(open, CANSYNC_INVALID, "the handle is not connected; call cansync_connect() first");
    return std::forward<Call>(call)(open, *open.client);
  });
}

}  // namespace cansync::client::c_face
