#include "cli/cansync/transfer_turn.h"

#include <fmt/format.h>

#include "cli/connect/bus_connection.h"

namespace cansync::cli {
namespace {

constexpr std::chrono::milliseconds kFirstSample{500};

}  // namespace

client::TransferJob TransferTurn::begin(client::TransferJob job) {
  job_ = job;
  begun_ = Clock::now();
  waited_for_.clear();
  given_up_ = false;
  return job;
}

void TransferTurn::look(std::uint32_t done) {
  if (!job_ || done != 0) return;
  try {
    if (!desk_) {
      desk_ = std::make_unique<gateway::dds::DeskClient>(bus_options(session_));
      (void)desk_->open(kFirstSample);
    }
  } catch (const gateway::dds::NoDaemon&) {
    return;  // the transfer itself says so
  } catch (const gateway::dds::SetupError&) {
    return;  // it goes on without words
  }
  waited_for_ = desk_->waits_behind(job_->request());
  if (waited_for_.empty()) return;
  tell(waited_for_);
  const auto timeout = session_.globals().timeout;
  if (!timeout || given_up_ || Clock::now() - begun_ < std::chrono::duration<double>(*timeout)) return;
  given_up_ = true;
  (void)job_->cancel();
}

void TransferTurn::tell(const std::string& what) {
  constexpr std::chrono::seconds kAgain{10};
  const std::string job = what.substr(0, what.find(','));
  if (job == told_job_ && Clock::now() - told_ < kAgain) return;
  told_job_ = job;
  told_ = Clock::now();
  session_.output().remark_now(
      fmt::format("waiting for {}; `cansync cancel{}` would end it", what, job.substr(job.find(' '))));
}

void TransferTurn::settle(client::TransferReply& reply) const {
  if (!given_up_ || reply.code != client::ReplyCode::cancelled) return;
  reply.code = client::ReplyCode::timeout;
  reply.reason =
      fmt::format("its turn did not come within {:g} s (--timeout); nothing was sent: it waited for {}",
                  *session_.globals().timeout, waited_for_);
}

}  // namespace cansync::cli
