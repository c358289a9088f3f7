#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "../slave_connection.h"

struct cansync_slave_SlaveCommand;

namespace cansync::client::function_blocks {

/// The transmission range of a block that sets the slave: one command on its way. One thread.
class CANSYNC_PUBLIC SlaveCommandSlot {
 public:
  /// `connection` must outlive the slot.
  explicit SlaveCommandSlot(SlaveConnection& connection) : connection_(&connection) {}

  /// Sets the mode. The command entered last counts: what became of one before is not looked at.
  void mode(Mode mode);
  /// Sets this slave's own mapping.
  void mapping(const MappingBytes& references, const MappingBytes& actual_values);
  /// Listens to another slave so; all 0: not any more.
  void listen(std::uint8_t other, const MappingBytes& actual_values);

  /// Takes the reply when it is there. Never waits.
  void poll();
  /// What was not even entered, because an input is wrong.
  void refuse(RefusalCause cause, std::string reason);

  /// Forgets what was refused.
  void clear() noexcept { error_.clear(); }

  bool open() const noexcept { return request_ != 0; }          ///< a command is on its way
  bool sent() const noexcept { return sent_; }                  ///< the command entered last is done
  bool refused() const noexcept { return !error_.empty(); }     ///< it failed
  const std::string& error() const noexcept { return error_; }  ///< who refused and why; empty without one
  RefusalCause cause() const noexcept { return cause_; }        ///< why it was refused; none otherwise
  /// It failed for what passes soon: giving it again may help.
  bool passes() const noexcept;
  /// Another start of the daemon is there than the one that the command entered last was for.
  bool other_daemon() const;

 private:
  void enter(const ::cansync_slave_SlaveCommand& wanted);

  SlaveConnection* connection_;
  std::array<std::uint8_t, 16> daemon_ = {};  ///< of the command entered last
  std::uint64_t request_ = 0;
  bool sent_ = false;
  ReplyCode code_ = ReplyCode::done;
  RefusalCause cause_ = RefusalCause::none;
  std::string error_;
};

}  // namespace cansync::client::function_blocks
