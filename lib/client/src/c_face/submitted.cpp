#include <algorithm>
#include <chrono>
#include <memory>
#include <mutex>
#include <utility>
#include <variant>

#include "client/src/c_face/handle.h"

/// A request that the C face has handed over; the reply is kept, for its texts and data live as long.
struct cansync_job {
  using Job =
      std::variant<cansync::client::ParameterJob, cansync::client::TransferJob, cansync::client::CommandJob>;
  explicit cansync_job(Job of_kind) : job(std::move(of_kind)) {}

  Job job;
  std::mutex mutex = {};  ///< what follows
  bool ended = false;
  cansync_reply reply = {};
  std::string reason = {};
  std::vector<std::uint8_t> data = {};
};

namespace {

namespace client = cansync::client;
using client::Client;
using client::c_face::connected;
using client::c_face::fail;

static_assert(static_cast<int>(client::ParameterFormat::as_slave_says) == 2);

/// The job that `submit(client)` gives; null when the handle is of no use.
template <class Submit>
cansync_job* submitted(cansync_client* handle, const void* request, Submit&& submit) noexcept {
  std::unique_ptr<cansync_job> job;
  (void)connected(handle, [&](cansync_client& open, Client& client) {
    if (request == nullptr) return fail(open, CANSYNC_INVALID, "client: request is NULL");
    if (auto made = submit(open, client)) job = std::make_unique<cansync_job>(*made);
    return static_cast<int>(CANSYNC_DONE);
  });
  return job.release();
}

void fill(const client::ParameterReply& from, cansync_job& to) {
  to.reply.error_code = from.error_code;
  to.reply.value = from.value;
  to.reply.doubleword = from.doubleword ? 1 : 0;
  to.reply.intervals = from.intervals;
}

void fill(const client::TransferReply& from, cansync_job& to) {
  to.reply.error_code = from.error_code;
  to.reply.intervals = from.intervals;
  to.reply.done = from.done;
  to.reply.error_offset = from.error_offset;
  to.reply.repeated_telegrams = from.repeated_telegrams;
  to.reply.repeated_blocks = from.repeated_blocks;
  to.data = from.data;
  to.reply.data = to.data.data();
  to.reply.size = static_cast<std::uint32_t>(to.data.size());
}

void fill(const client::CommandReply&, cansync_job&) {}

/// Waits for the reply and keeps it; true when it is there.
bool ended_within(cansync_job& job, std::chrono::milliseconds time) {
  return std::visit(
      [&](const auto& of_kind) {
        const auto reply = of_kind.wait_for(time);
        const std::lock_guard lock(job.mutex);
        if (job.ended || !reply) return job.ended;
        job.reply.result = client::c_face::number_of(reply->code);
        job.reply.cause = static_cast<int>(reply->cause);
        job.reason = client::describe(*reply);
        job.reply.reason = job.reason.c_str();
        fill(*reply, job);
        return job.ended = true;
      },
      job.job);
}

std::optional<client::CommandJob> submit_command(cansync_client& open, Client& client,
                                                 const cansync_command_request& from) {
  client::MappingBytes mapping = {};
  std::copy_n(from.mapping, mapping.size(), mapping.begin());
  switch (from.kind) {
    case CANSYNC_COMMAND_CONTROL_WORD:
      return client.control_word(from.slave, from.control_word, from.timeout_ms);
    case CANSYNC_COMMAND_BROADCAST:
      return client.broadcast(
          {from.priority, from.slave_mask, from.action, from.data_byte, from.data_word, from.timeout_ms});
    case CANSYNC_COMMAND_MODE:
      if (from.mode < CANSYNC_MODE_SETUP || from.mode > CANSYNC_MODE_RESTART) {
        fail(open, CANSYNC_INVALID, "client: mode " + std::to_string(from.mode) + ": allowed 0..4");
        return std::nullopt;
      }
      return client.mode(static_cast<client::Mode>(from.mode), from.force != 0);
    case CANSYNC_COMMAND_RELEASE:
      return client.release(from.slave, from.force != 0);
    case CANSYNC_COMMAND_POLLING:
      return client.polling({from.one, from.two, from.three});
    case CANSYNC_COMMAND_CURSORS:
      return client.cursors({from.one, from.two, from.three});
    case CANSYNC_COMMAND_MAP_REFERENCES:
      return client.map_references(mapping);
    case CANSYNC_COMMAND_MAP_ACTUALS:
      return client.map_actuals(from.slave, mapping);
    default:
      fail(open, CANSYNC_INVALID, "client: kind " + std::to_string(from.kind) + ": allowed 0..7");
      return std::nullopt;
  }
}

}  // namespace

cansync_job* cansync_submit_parameter(cansync_client* handle,
                                      const cansync_parameter_request* request) noexcept {
  return submitted(
      handle, request, [&](cansync_client& open, Client& client) -> std::optional<client::ParameterJob> {
        if (request->format < 0 || request->format > 2) {
          fail(open, CANSYNC_INVALID, "client: format: allowed 0, 1, 2");
          return std::nullopt;
        }
        return client.submit(client::ParameterRequest{
            request->write != 0, request->slave, request->number, request->value, request->sub_slave,
            request->element, static_cast<client::ParameterFormat>(request->format), request->timeout_ms});
      });
}

cansync_job* cansync_submit_transfer(cansync_client* handle,
                                     const cansync_transfer_request* request) noexcept {
  return submitted(handle, request,
                   [&](cansync_client& open, Client& client) -> std::optional<client::TransferJob> {
                     client::TransferRequest to;
                     to.download = request->download != 0;
                     to.slave = request->slave;
                     to.address = request->address;
                     to.sub_slave = request->sub_slave;
                     to.block_size = request->block_size;
                     to.timeout_ms = request->timeout_ms;
                     if (!to.download) {
                       to.length = request->size;
                     } else if (request->data != nullptr) {
                       const auto* bytes = static_cast<const std::uint8_t*>(request->data);
                       to.data.assign(bytes, bytes + request->size);
                     } else {
                       fail(open, CANSYNC_INVALID, "client: data is NULL");
                       return std::nullopt;
                     }
                     return client.submit(to);
                   });
}

cansync_job* cansync_submit_command(cansync_client* handle, const cansync_command_request* request) noexcept {
  return submitted(handle, request, [&](cansync_client& open, Client& client) {
    return submit_command(open, client, *request);
  });
}

int cansync_job_wait(cansync_job* job, uint32_t timeout_ms) noexcept {
  try {
    return ended_within(*job, std::chrono::milliseconds(timeout_ms)) ? 1 : 0;
  } catch (const std::exception&) {  // no memory for the reply: tried again by the next call
    return 0;
  }
}

void cansync_job_progress(const cansync_job* job, uint32_t* done, uint32_t* total) noexcept {
  client::Progress progress;
  try {
    progress = std::visit([](const auto& of_kind) { return of_kind.progress(); }, job->job);
  } catch (const std::exception&) {  // the lock was not to be had: as before the first sign
  }
  if (done != nullptr) *done = progress.done;
  if (total != nullptr) *total = progress.total;
}

int cansync_job_reply(cansync_job* job, cansync_reply* out) noexcept {
  if (out == nullptr) return CANSYNC_INVALID;
  if (cansync_job_wait(job, 0) == 0) return CANSYNC_NO_DATA;
  const std::lock_guard lock(job->mutex);
  *out = job->reply;
  return CANSYNC_DONE;
}

int cansync_job_cancel(cansync_job* job) noexcept {
  try {
    const bool told = std::visit([](const auto& of_kind) { return of_kind.cancel(); }, job->job);
    return told ? CANSYNC_DONE : CANSYNC_FAILED;
  } catch (const std::exception&) {
    return CANSYNC_FAILED;
  }
}

void cansync_job_free(cansync_job* job) noexcept {
  delete job;
}
