#include <cansync/function_blocks/command_slot.h>

#include <utility>

namespace cansync::client::function_blocks {

void CommandSlot::enter(Submit submit) {
  waiting_ = std::move(submit);
  sent_ = false;
  code_ = ReplyCode::done;
  cause_ = RefusalCause::none;
  error_.clear();
}

// With an error and this code it waits for the reply.
void CommandSlot::repeat(Submit submit) {
  waiting_ = std::move(submit);
  code_ = ReplyCode::done;
}

bool CommandSlot::passes() const noexcept {
  const Retry again = retry(code_, cause_);
  return refused() && again != Retry::never && again != Retry::after_change;
}

void CommandSlot::refuse(RefusalCause cause, std::string reason) {
  waiting_ = nullptr;
  sent_ = false;
  code_ = ReplyCode::refused;
  cause_ = cause;
  error_ = std::move(reason);
}

void CommandSlot::poll() {
  constexpr std::chrono::milliseconds kNow{0};
  if (older_ && older_->wait_for(kNow)) older_.reset();
  if (job_) {
    const std::optional<CommandReply> reply = job_->wait_for(kNow);
    if (!reply) {
      if (!newest_at_once_ || !waiting_ || older_) return;
      older_ = job_;
    } else if (!waiting_ && (error_.empty() || code_ == ReplyCode::done)) {
      // What was entered meanwhile counts, not what it has replaced.
      sent_ = reply->ok();
      code_ = reply->code;
      cause_ = reply->cause;
      error_ = describe(*reply);
    }
    job_.reset();
  }
  if (!waiting_) return;
  job_.emplace(std::exchange(waiting_, nullptr)(*client_));
}

}  // namespace cansync::client::function_blocks
