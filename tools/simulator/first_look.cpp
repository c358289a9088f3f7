#include "simulator/first_look.h"

#include <fmt/format.h>

#include <string_view>
#include <variant>

#include "cansync/telegram/telegram.h"
#include "sync/software_sync.h"

namespace cansync_sim {
namespace {

/// The slave that has sent a telegram.
cansync::SlaveNumber sender_of(const cansync::Telegram& telegram, bool& found) noexcept {
  found = true;
  if (const auto* actual = std::get_if<cansync::ActualTelegram>(&telegram)) return actual->slave;
  if (const auto* reply = std::get_if<cansync::ParameterReply>(&telegram)) return reply->slave;
  if (const auto* reply = std::get_if<cansync::TransferReply>(&telegram)) return reply->slave;
  found = false;
  return {};
}

}  // namespace

std::string list_of(cansync::SlaveMask slaves) {
  std::string text;
  for (const cansync::SlaveNumber slave : slaves)
    text += fmt::format("{}{}", text.empty() ? "" : ", ", slave.value());
  return text;
}

bool is_virtual(const can::LinkFacts& facts) noexcept {
  const std::string_view kind(facts.driver_kind.data());
  return kind == "vcan" || kind == "vxcan";
}

void hear(const can::Frame& frame, std::uint32_t sync_identifier, Heard& heard) noexcept {
  if (sync_line::is_software_sync(frame, sync_identifier)) heard.master = frame.id;
  const cansync::Decoded decoded = cansync::decode(frame);
  const auto* telegram = std::get_if<cansync::Telegram>(&decoded);
  if (telegram == nullptr) return;
  bool from_slave = false;
  const cansync::SlaveNumber sender = sender_of(*telegram, from_slave);
  if (from_slave) {
    heard.slaves.set(sender);
  } else {
    heard.master = frame.id;
  }
}

std::optional<Heard> listen(Port& port, std::uint32_t sync_identifier) {
  Heard heard;
  can::Time until = port.now() + kListen;
  while (port.now() < until) {
    if (port.link() != Link::up) until = port.now() + kListen;
    can::ReceivedFrame received;
    while (port.receive(received)) hear(received.frame, sync_identifier, heard);
    if (!port.wait(until)) return std::nullopt;
  }
  return heard;
}

std::string conflict(const Setup& setup, const Heard& heard) {
  if (setup.master && heard.master)
    return fmt::format(
        "{}: a master sends on this bus (identifier 0x{:03X}); a second one would move its drives. Switch "
        "that master off",
        setup.interface, *heard.master);
  cansync::SlaveMask twice;
  for (const sim::DriveSettings& drive : setup.drives)
    if (heard.slaves.has(drive.slave.number)) twice.set(drive.slave.number);
  if (twice.empty()) return {};
  return fmt::format(
      "{}: slave {} responds on this bus; a simulated drive of the same number would collide with it. Choose "
      "other numbers with --slaves",
      setup.interface, list_of(twice));
}

}  // namespace cansync_sim
