#include "can/socketcan/bus_sockets.h"

#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <linux/net_tstamp.h>

#include <algorithm>
#include <cerrno>
#include <system_error>
#include <utility>

#include "can/socketcan/kernel_frame.h"

namespace can {
namespace {

std::vector<can_filter> to_filters(const std::vector<FrameFilter>& filters) {
  std::vector<can_filter> out;
  out.reserve(filters.size());
  for (const FrameFilter& filter : filters) out.push_back(to_kernel(filter));
  return out;
}

}  // namespace

BusSockets::BusSockets(const std::vector<FrameFilter>& filters, Kernel& kernel)
    : kernel_(kernel), filters_(to_filters(filters)) {
  const char* what = "";
  const int made = make(what);
  if (made < 0) throw std::system_error(-made, std::generic_category(), what);
  spare_ = made;
}

BusSockets::~BusSockets() {
  (void)bound_to(0);
  close_others(-1);
  if (spare_ >= 0) kernel_.close_socket(spare_);
}

int BusSockets::make(const char*& what) noexcept {
  const int socket = kernel_.open_socket();
  what = "SocketCAN: opening a socket";
  if (socket < 0) {
    what = socket == -EAFNOSUPPORT || socket == -EPROTONOSUPPORT
               ? "SocketCAN: the kernel has none; load it with: modprobe can-raw"
               : what;
    return socket;
  }
  const int error = socket <= kMost ? set_options(socket, what) : -EMFILE;
  if (error >= 0) return socket;
  kernel_.close_socket(socket);
  return error;
}

int BusSockets::set_options(int socket, const char*& what) noexcept {
  constexpr can_err_mask_t kErrors = CAN_ERR_MASK;
  constexpr int kStamps = SOF_TIMESTAMPING_RX_SOFTWARE | SOF_TIMESTAMPING_SOFTWARE |
                          SOF_TIMESTAMPING_RX_HARDWARE | SOF_TIMESTAMPING_RAW_HARDWARE;
  int result = 0;
  const auto set = [&](int level, int name, const void* value, std::size_t size, const char* words) {
    if (result < 0) return;
    what = words;
    result = kernel_.set_option(socket, level, name, value, size);
  };
  const auto number = [&](int level, int name, int value, const char* words) {
    set(level, name, &value, sizeof value, words);
  };
  set(SOL_CAN_RAW, CAN_RAW_FILTER, filters_.data(), filters_.size() * sizeof(can_filter),
      "SocketCAN: setting the identifier filter");
  set(SOL_CAN_RAW, CAN_RAW_ERR_FILTER, &kErrors, sizeof kErrors, "SocketCAN: switching error frames on");
  number(SOL_CAN_RAW, CAN_RAW_LOOPBACK, 1, "SocketCAN: switching the loopback on");
  number(SOL_CAN_RAW, CAN_RAW_RECV_OWN_MSGS, 1, "SocketCAN: reading own frames back");
  number(SOL_SOCKET, SO_RXQ_OVFL, 1, "SocketCAN: counting drops");
  number(SOL_SOCKET, SO_TIMESTAMPING, kStamps, "SocketCAN: switching time stamps on");
  // The kernel's least: a handful of frames. What does not leave in time is to be seen, not queued.
  number(SOL_SOCKET, SO_SNDBUF, 0, "SocketCAN: setting the send buffer");
  return result;
}

int BusSockets::bound_to(std::uint32_t index) noexcept {
  if (index == index_) return bound_;
  if (bound_ >= 0) retired_.push_back(bound_);
  bound_ = -1;
  index_ = 0;
  if (index == 0) return -1;
  const char* what = "";
  if (spare_ < 0) spare_ = std::max(make(what), -1);
  // An interface that goes takes a socket's filters along, so one that was bound is not bound again.
  if (spare_ < 0 || kernel_.bind_to(spare_, static_cast<int>(index)) < 0) return -1;
  bound_ = std::exchange(spare_, -1);
  index_ = index;
  return bound_;
}

void BusSockets::close_others(int in_use) noexcept {
  std::erase_if(retired_, [&](int socket) {
    if (socket == in_use) return false;
    kernel_.close_socket(socket);
    return true;
  });
}

}  // namespace can
