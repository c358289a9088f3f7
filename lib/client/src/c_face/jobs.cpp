#include <algorithm>

#include "client/src/c_face/handle.h"

/// Parameters and transfers of the C face.
namespace {

using cansync::client::Client;
using cansync::client::OnProgress;
using cansync::client::ParameterReply;
using cansync::client::TransferReply;
using cansync::client::TransferRequest;
using cansync::client::c_face::connected;
using cansync::client::c_face::fail;
using cansync::client::c_face::result_of;

TransferReply transfer(cansync_client& open, Client& client, const TransferRequest& request,
                       cansync_progress progress, void* user) {
  // Not reset here: a cancel that has just come is for this transfer.
  struct Reset {
    std::atomic<bool>& stop;
    ~Reset() { stop = false; }
  };
  const Reset reset{open.stop};
  const OnProgress on_progress = [&](std::uint32_t done, std::uint32_t total) {
    if (progress != nullptr && progress(user, done, total) != 0) open.stop = true;
  };
  return client.submit(request).wait(open.stop, on_progress);
}

}  // namespace

int cansync_read(cansync_client* handle, uint32_t slave, uint32_t number, uint32_t timeout_ms,
                 cansync_parameter* out) noexcept {
  return connected(handle, [&](cansync_client& open, Client& client) {
    if (out == nullptr) return fail(open, CANSYNC_INVALID, "client: out is NULL");
    const ParameterReply reply = client.read(slave, number, timeout_ms);
    *out = {reply.value, reply.doubleword ? 1 : 0, reply.error_code, reply.intervals};
    return result_of(open, reply);
  });
}

int cansync_write(cansync_client* handle, uint32_t slave, uint32_t number, uint32_t value,
                  uint32_t timeout_ms) noexcept {
  return connected(handle, [&](cansync_client& open, Client& client) {
    return result_of(open, client.write(slave, number, value, timeout_ms));
  });
}

int cansync_upload(cansync_client* handle, uint32_t slave, uint32_t address, void* data, uint32_t size,
                   uint32_t* done, cansync_progress progress, void* user) noexcept {
  return connected(handle, [&](cansync_client& open, Client& client) {
    if (data == nullptr) return fail(open, CANSYNC_INVALID, "client: data is NULL");
    TransferRequest request;
    request.slave = slave;
    request.address = address;
    request.length = size;
    const TransferReply reply = transfer(open, client, request, progress, user);
    const std::size_t count = std::min<std::size_t>(reply.data.size(), size);
    std::copy_n(reply.data.begin(), count, static_cast<std::uint8_t*>(data));
    if (done != nullptr) *done = static_cast<std::uint32_t>(count);
    return result_of(open, reply);
  });
}

int cansync_download(cansync_client* handle, uint32_t slave, uint32_t address, const void* data,
                     uint32_t size, cansync_progress progress, void* user) noexcept {
  return connected(handle, [&](cansync_client& open, Client& client) {
    if (data == nullptr) return fail(open, CANSYNC_INVALID, "client: data is NULL");
    const auto* bytes = static_cast<const std::uint8_t*>(data);
    TransferRequest request;
    request.download = true;
    request.slave = slave;
    request.address = address;
    request.data.assign(bytes, bytes + size);
    return result_of(open, transfer(open, client, request, progress, user));
  });
}

void cansync_cancel_transfer(cansync_client* handle) noexcept {
  if (handle != nullptr) handle->stop = true;
}
