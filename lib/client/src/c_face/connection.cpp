#include <new>

#include "client/src/c_face/handle.h"
#include "profile/folders.h"

namespace {

namespace client = cansync::client;

// The numbers of the two lists are the same.
static_assert(static_cast<int>(client::ReplyCode::done) == CANSYNC_DONE);
static_assert(static_cast<int>(client::ReplyCode::value_too_wide) == CANSYNC_VALUE_TOO_WIDE);
static_assert(static_cast<int>(client::ReplyCode::no_reply) == CANSYNC_NO_REPLY);
static_assert(static_cast<int>(client::RefusalCause::none) == CANSYNC_CAUSE_NONE);
static_assert(static_cast<int>(client::RefusalCause::shared_limit) == CANSYNC_CAUSE_SHARED_LIMIT);
static_assert(static_cast<int>(client::Retry::never) == CANSYNC_RETRY_NEVER);
static_assert(static_cast<int>(client::Retry::look_first) == CANSYNC_RETRY_LOOK_FIRST);

std::string text_or(const char* text, const std::string& otherwise) {
  return text == nullptr ? otherwise : text;
}

}  // namespace

namespace cansync::client::c_face {

Options options_of(const cansync_options* given) {
  const cansync_options from = given == nullptr ? cansync_options{} : *given;
  Options options;
  options.domain = from.domain;
  options.bus = text_or(from.bus, options.bus);
  options.interface = text_or(from.interface, options.interface);
  options.client_name = text_or(from.client_name, options.client_name);
  options.security = text_or(from.security, options.security);
  options.final_types = from.final_types != 0;
  if (from.wait_ms != 0) options.wait = std::chrono::milliseconds(from.wait_ms);
  if (from.go_on != nullptr)
    options.go_on = [go_on = from.go_on, user = from.user] { return go_on(user) != 0; };
  return options;
}

}  // namespace cansync::client::c_face

const char* cansync_version() noexcept {
  return CANSYNC_VERSION;
}

const char* cansync_result_name(int result) noexcept {
  switch (result) {
    case CANSYNC_NO_DAEMON:
      return "no_daemon";
    case CANSYNC_SETUP_FAILED:
      return "setup_failed";
    case CANSYNC_NO_DATA:
      return "no_data";
    case CANSYNC_INVALID:
      return "invalid";
    case CANSYNC_FAILED:
      return "failed";
    case CANSYNC_TAKE_UP:
      return "take_up";
    case CANSYNC_REPLACED:
      return client::name(client::ReplyCode::replaced).data();
    default:
      break;
  }
  if (result < CANSYNC_DONE || result > CANSYNC_NO_REPLY) return "unknown";
  // The words are literals, terminated by 0.
  return client::name(static_cast<client::ReplyCode>(result)).data();
}

const char* cansync_cause_name(int cause) noexcept {
  const bool known = cause >= CANSYNC_CAUSE_NONE && cause <= CANSYNC_CAUSE_SHARED_LIMIT;
  return client::name(known ? static_cast<client::RefusalCause>(cause) : client::RefusalCause::unknown)
      .data();
}

int cansync_retry(int result, int cause) noexcept {
  switch (result) {
    case CANSYNC_SETUP_FAILED:
    case CANSYNC_FAILED:
      return CANSYNC_RETRY_AFTER_CHANGE;
    case CANSYNC_NO_DATA:
      return CANSYNC_RETRY_SOON;
    case CANSYNC_TAKE_UP:
      return CANSYNC_RETRY_LOOK_FIRST;
    case CANSYNC_NO_DAEMON:
      return static_cast<int>(client::retry(client::ReplyCode::no_daemon, client::RefusalCause::none));
    case CANSYNC_REPLACED:
      return static_cast<int>(client::retry(client::ReplyCode::replaced, client::RefusalCause::none));
    default:
      break;
  }
  if (result < CANSYNC_DONE || result > CANSYNC_NO_REPLY) return CANSYNC_RETRY_NEVER;
  const bool known = cause >= CANSYNC_CAUSE_NONE && cause <= CANSYNC_CAUSE_SHARED_LIMIT;
  return static_cast<int>(
      client::retry(static_cast<client::ReplyCode>(result),
                    known ? static_cast<client::RefusalCause>(cause) : client::RefusalCause::unknown));
}

cansync_client* cansync_new() noexcept {
  return new (std::nothrow) cansync_client;
}

void cansync_free(cansync_client* handle) noexcept {
  delete handle;
}

const char* cansync_last_error(const cansync_client* handle) noexcept {
  return handle == nullptr ? "the handle is NULL" : handle->error.c_str();
}

int cansync_last_cause(const cansync_client* handle) noexcept {
  return handle == nullptr ? static_cast<int>(CANSYNC_CAUSE_NONE) : static_cast<int>(handle->cause);
}

int cansync_connect(cansync_client* handle, const cansync_options* options) noexcept {
  return client::c_face::guarded(handle, [&](cansync_client& open) {
    if (open.client)
      return client::c_face::fail(open, CANSYNC_INVALID,
                                  "the handle is connected already; take a new one for another bus");
    const cansync_options given = options == nullptr ? cansync_options{} : *options;
    open.profile_folders = profile::standard_folders();
    if (given.profiles != nullptr && *given.profiles != '\0')
      open.profile_folders.insert(open.profile_folders.begin(), given.profiles);
    open.client.emplace(client::Client::connect(client::c_face::options_of(options)));
    return static_cast<int>(CANSYNC_DONE);
  });
}
