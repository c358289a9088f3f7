#include "can/link_facts.h"

#include <linux/can/netlink.h>
#include <linux/if.h>
#include <linux/if_arp.h>
#include <linux/if_link.h>
#include <linux/rtnetlink.h>

#include <algorithm>
#include <cstring>

namespace can {
namespace {

using Bytes = std::span<const std::byte>;

/// Copies a value from the front; nothing when there is less.
template <class T>
std::optional<T> front(Bytes bytes) noexcept {
  if (bytes.size() < sizeof(T)) return std::nullopt;
  T value;
  std::memcpy(&value, bytes.data(), sizeof(T));
  return value;
}

constexpr std::size_t aligned(std::size_t size) noexcept {
  return (size + 3) & ~std::size_t{3};
}

Bytes after(Bytes bytes, std::size_t size) noexcept {
  return bytes.subspan(std::min(size, bytes.size()));
}

std::string_view text(Bytes bytes) noexcept {
  const auto* start = reinterpret_cast<const char*>(bytes.data());  // text is told in bytes
  return {start, static_cast<std::size_t>(std::find(start, start + bytes.size(), '\0') - start)};
}

/// Calls `take` with type and payload of every attribute, up to the first that is cut off.
template <class Take>
void for_each_attribute(Bytes bytes, const Take& take) noexcept {
  while (const auto header = front<rtattr>(bytes)) {
    if (header->rta_len < sizeof(rtattr) || header->rta_len > bytes.size()) return;
    take(header->rta_type & NLA_TYPE_MASK, bytes.subspan(sizeof(rtattr), header->rta_len - sizeof(rtattr)));
    bytes = after(bytes, aligned(header->rta_len));
  }
}

std::optional<ControllerState> to_state(std::uint32_t state) noexcept {
  switch (state) {
    case CAN_STATE_ERROR_ACTIVE:
      return ControllerState::error_active;
    case CAN_STATE_ERROR_WARNING:
      return ControllerState::error_warning;
    case CAN_STATE_ERROR_PASSIVE:
      return ControllerState::error_passive;
    case CAN_STATE_BUS_OFF:
      return ControllerState::bus_off;
    case CAN_STATE_STOPPED:
    case CAN_STATE_SLEEPING:
      return ControllerState::stopped;
    default:
      return std::nullopt;
  }
}

void read_controller(Bytes data, LinkFacts& facts) noexcept {
  for_each_attribute(data, [&facts](unsigned type, Bytes payload) {
    if (type == IFLA_CAN_BITTIMING) {
      const auto timing = front<can_bittiming>(payload);
      if (timing && timing->bitrate != 0) {
        facts.timing = LinkTiming{timing->bitrate, static_cast<std::uint16_t>(timing->sample_point)};
      }
    } else if (type == IFLA_CAN_STATE) {
      if (const auto state = front<std::uint32_t>(payload)) facts.state = to_state(*state);
    } else if (type == IFLA_CAN_CTRLMODE) {
      if (const auto mode = front<can_ctrlmode>(payload)) {
        facts.one_shot = (mode->flags & CAN_CTRLMODE_ONE_SHOT) != 0;
        facts.listen_only = (mode->flags & CAN_CTRLMODE_LISTENONLY) != 0;
      }
    } else if (type == IFLA_CAN_CTRLMODE_EXT) {
      for_each_attribute(payload, [&facts](unsigned part, Bytes modes) {
        const auto supported = front<std::uint32_t>(modes);
        if (part != IFLA_CAN_CTRLMODE_SUPPORTED || !supported) return;
        facts.can_one_shot = (*supported & CAN_CTRLMODE_ONE_SHOT) != 0;
      });
    } else if (type == IFLA_CAN_RESTART_MS) {
      facts.restart_ms = front<std::uint32_t>(payload);
    } else if (type == IFLA_CAN_BERR_COUNTER) {
      if (const auto counters = front<can_berr_counter>(payload)) {
        facts.has_counters = true;
        facts.transmit_errors = counters->txerr;
        facts.receive_errors = counters->rxerr;
      }
    }
  });
}

void read_link_info(Bytes info, LinkFacts& facts) noexcept {
  Bytes data;
  for_each_attribute(info, [&](unsigned type, Bytes payload) {
    if (type == IFLA_INFO_DATA) data = payload;
    if (type != IFLA_INFO_KIND) return;
    const std::string_view kind = text(payload).substr(0, facts.driver_kind.size() - 1);
    std::copy(kind.begin(), kind.end(), facts.driver_kind.begin());
  });
  // The numbers of the attributes mean this for real controllers alone.
  if (std::string_view(facts.driver_kind.data()) == "can") read_controller(data, facts);
}

std::optional<LinkFacts> read_link(Bytes message, std::string_view name) noexcept {
  const auto link = front<ifinfomsg>(message);
  if (!link) return std::nullopt;
  LinkFacts facts;
  facts.present = true;
  facts.index = static_cast<std::uint32_t>(link->ifi_index);
  facts.is_can = link->ifi_type == ARPHRD_CAN;
  facts.up = (link->ifi_flags & IFF_UP) != 0;
  facts.echoes = (link->ifi_flags & IFF_ECHO) != 0;
  bool named = false;
  for_each_attribute(after(message, aligned(sizeof(ifinfomsg))), [&](unsigned type, Bytes payload) {
    if (type == IFLA_IFNAME) named = text(payload) == name;
    if (type == IFLA_TXQLEN) facts.queue_length = front<std::uint32_t>(payload).value_or(0);
    if (type == IFLA_LINKINFO) read_link_info(payload, facts);
  });
  return named ? std::optional(facts) : std::nullopt;
}

}  // namespace

std::optional<LinkFacts> read_link_message(Bytes bytes, std::string_view name) noexcept {
  while (const auto header = front<nlmsghdr>(bytes)) {
    if (header->nlmsg_len < sizeof(nlmsghdr) || header->nlmsg_len > bytes.size()) return std::nullopt;
    if (header->nlmsg_type == RTM_NEWLINK) {
      const auto facts =
          read_link(bytes.subspan(sizeof(nlmsghdr), header->nlmsg_len - sizeof(nlmsghdr)), name);
      if (facts) return facts;
    }
    bytes = after(bytes, aligned(header->nlmsg_len));
  }
  return std::nullopt;
}

}  // namespace can
