#include "can/socketcan/receive_batch.h"

#include <linux/errqueue.h>

#include <chrono>
#include <cstring>

namespace can {
namespace {

std::optional<Time> stamp_of(const timespec& stamp) noexcept {
  if (stamp.tv_sec == 0 && stamp.tv_nsec == 0) return std::nullopt;
  return std::chrono::seconds(stamp.tv_sec) + std::chrono::nanoseconds(stamp.tv_nsec);
}

/// Copies a value out of a control message; nothing when it is too short.
template <class T>
std::optional<T> payload(const cmsghdr& header) noexcept {
  if (header.cmsg_len < CMSG_LEN(sizeof(T))) return std::nullopt;
  T value;
  std::memcpy(&value, CMSG_DATA(&header), sizeof(T));
  return value;
}

void read_control(const cmsghdr& header, RawMessage& out) noexcept {
  if (header.cmsg_level != SOL_SOCKET) return;
  if (header.cmsg_type == SO_RXQ_OVFL) out.drops = payload<std::uint32_t>(header);
  if (header.cmsg_type != SO_TIMESTAMPING) return;
  if (const auto stamps = payload<scm_timestamping>(header)) {
    out.stamps.software = stamp_of(stamps->ts[0]);
    out.stamps.hardware = stamp_of(stamps->ts[2]);
  }
}

}  // namespace

ReceiveBatch::ReceiveBatch() noexcept {
  for (unsigned i = 0; i < kFrames; ++i) {
    vectors_[i] = {&frames_[i], sizeof(can_frame)};
    prepare(i);
  }
}

void ReceiveBatch::prepare(unsigned index) noexcept {
  msghdr& header = headers_[index].msg_hdr;
  header.msg_iov = &vectors_[index];
  header.msg_iovlen = 1;
  header.msg_control = controls_[index].bytes.data();
  header.msg_controllen = kControlSize;
  header.msg_flags = 0;
}

int ReceiveBatch::receive(Kernel& kernel, int socket) noexcept {
  for (unsigned i = 0; i < used_; ++i) prepare(i);
  used_ = 0;
  const int count = kernel.receive(socket, headers_.data(), kFrames);
  if (count > 0) used_ = static_cast<unsigned>(count);
  return count;
}

RawMessage ReceiveBatch::message(unsigned index) const noexcept {
  const mmsghdr& header = headers_[index];
  RawMessage out;
  out.frame = frames_[index];
  out.whole = header.msg_len == sizeof(can_frame);
  out.own = (header.msg_hdr.msg_flags & MSG_CONFIRM) != 0;
  // CMSG_NXTHDR takes a header that is not const, though it does not write to it.
  msghdr control = header.msg_hdr;
  for (const cmsghdr* part = CMSG_FIRSTHDR(&control); part != nullptr;
       part = CMSG_NXTHDR(&control, const_cast<cmsghdr*>(part))) {
    read_control(*part, out);
  }
  return out;
}

}  // namespace can
