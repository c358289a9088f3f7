#pragma once

#include <memory>
#include <optional>
#include <string>

#include "command_slot.h"

namespace cansync::client::detail {
struct SettingState;
}

namespace cansync::client::function_blocks {

/// A setting of the line: entered once, and again by itself when the daemon was started anew, which has lost
/// it, and every 500 ms while it is refused for what passes.
class CANSYNC_PUBLIC SettingSlot {
 public:
  using Submit = CommandSlot::Submit;

  /// `block`: its name, for messages.
  SettingSlot(Client& client, std::string block);

  /// Enters a setting; it leaves with this or a later `poll`. `reference_mapping`: what it maps, if it does.
  void enter(Submit submit, std::optional<MappingBytes> reference_mapping = std::nullopt);
  /// What was not even entered, because an input is wrong.
  void refuse(RefusalCause cause, std::string reason);
  /// What was refused because an input was wrong does not count any more; what was entered before it does.
  void withdraw();
  /// Takes the reply when it is there, and hands on what was entered. Never waits for an answer.
  void poll();

  bool sent() const noexcept { return slot_.sent(); }        ///< the setting entered last is in effect
  bool refused() const noexcept { return slot_.refused(); }  ///< the setting entered last failed
  const std::string& error() const noexcept { return slot_.error(); }  ///< who refused and why, or empty
  RefusalCause cause() const noexcept { return slot_.cause(); }        ///< why it was refused; none otherwise
  /// None is under way, and what was handed on last is 500 ms old: it may be entered again without a flood.
  bool may_repeat() const;

  /// Which setting of this client's blocks is not in effect in the daemon; empty: none.
  static std::string missing(const Client& client);
  /// What holds now, when its reference mapping is one that a block of this client has entered.
  static std::optional<Validity> with_own_mapping(const Client& client);

 private:
  void note();

  Client* client_;
  CommandSlot slot_;
  Submit entered_;
  std::shared_ptr<detail::SettingState> state_;
};

}  // namespace cansync::client::function_blocks
