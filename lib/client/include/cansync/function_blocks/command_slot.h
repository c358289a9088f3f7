#pragma once

#include <functional>
#include <optional>
#include <string>

#include "../client.h"

namespace cansync::client::function_blocks {

/// The transmission range of a block that gives commands: one command on its way, and the newest one entered
/// meanwhile, which replaces an older one that waits, as in the option module's memory.
///
/// With `newest_at_once` the newest leaves while one before it is on its way, so that the daemon replaces
/// what waits there; two are on their way at most.
class CANSYNC_PUBLIC CommandSlot {
 public:
  using Submit = std::function<CommandJob(Client&)>;

  /// `client` must outlive the slot.
  explicit CommandSlot(Client& client, bool newest_at_once = false)
      : client_(&client), newest_at_once_(newest_at_once) {}

  /// Enters a command; it leaves with this or a later `poll`.
  void enter(Submit submit);
  /// Enters a command that was refused once more; `error` stays until its reply is there.
  void repeat(Submit submit);
  /// Takes the reply when it is there, and hands on what was entered. Never waits for an answer.
  void poll();
  /// What was not even entered, because an input is wrong.
  void refuse(RefusalCause cause, std::string reason);

  bool sent() const noexcept { return sent_; }                  ///< the command entered last is done
  bool open() const noexcept { return job_ || waiting_; }       ///< something is on its way or waits
  bool refused() const noexcept { return !error_.empty(); }     ///< the command entered last failed
  const std::string& error() const noexcept { return error_; }  ///< who refused and why; empty without one
  RefusalCause cause() const noexcept { return cause_; }        ///< why it was refused; none otherwise
  /// It failed for what passes, or may have been done (`retry`): it helps to give it again where that does no
  /// harm.
  bool passes() const noexcept;

 private:
  Client* client_;
  bool newest_at_once_;
  std::optional<CommandJob> job_;
  std::optional<CommandJob> older_;  ///< on its way before `job_`; its reply is of no interest
  Submit waiting_;
  bool sent_ = false;
  ReplyCode code_ = ReplyCode::done;  ///< of the command entered last
  RefusalCause cause_ = RefusalCause::none;
  std::string error_;
};

}  // namespace cansync::client::function_blocks
