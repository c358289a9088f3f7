#include "client/function_blocks/command_slot.h"

#include <utility>

namespace cansync::client::function_blocks {

void CommandSlot::enter(Submit submit) {
  waiting_ = std::move(submit);
  sent_ = false;
  error_.clear();
}

void CommandSlot::refuse(std::string reason) {
  waiting_ = nullptr;
  sent_ = false;
  error_ = std::move(reason);
}

void CommandSlot::poll() {
  if (job_) {
    const std::optional<CommandReply> reply = job_->wait_for(std::chrono::milliseconds(0));
    if (!reply) return;
    job_.reset();
    // What was entered meanwhile counts, not what it has replaced.
    if (!waiting_ && error_.empty()) {
      sent_ = reply->ok();
      error_ = describe(*reply);
    }
  }
  if (!waiting_) return;
  job_.emplace(std::exchange(waiting_, nullptr)(*client_));
}

}  // namespace cansync::client::function_blocks
