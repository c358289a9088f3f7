#include "daemon/cansync/requests/topics.h"

#include <algorithm>
#include <string>
#include <variant>

namespace cansyncd {
namespace {

namespace dds = cansync::dds;
using dds::RequestKey;

/// Puts the slave's name into the reason, where it matters.
template <class Reply>
Reply with_slave(Reply reply, cansync::Outcome outcome, const Request& request, const JobContext& context) {
  if (const std::string text = outcome_text(outcome, request, context.config); !text.empty()) {
    dds::copy_text(text, reply.reason);
  }
  return reply;
}

struct OutcomeOf {
  cansync::Outcome operator()(const CommandDone& done) const noexcept { return done.outcome; }
  cansync::Outcome operator()(const Refused& /*done*/) const noexcept { return cansync::Outcome::cancelled; }
  template <class Done>
  cansync::Outcome operator()(const Done& done) const noexcept {
    return done.result.outcome;
  }
};

}  // namespace

cansync::Outcome outcome_of(const Terminal& terminal) {
  return std::visit(OutcomeOf{}, terminal);
}

cansync_CommandReply CommandTopic::answer(const RequestKey& key, const Terminal& terminal,
                                          const Request& request, std::span<std::uint8_t> /*data*/,
                                          const JobContext& context) {
  const cansync::Outcome outcome = outcome_of(terminal);
  return with_slave(ended(key, outcome), outcome, request, context);
}

cansync_ParameterReply ParameterTopic::ended(const RequestKey& key, cansync::Outcome outcome) {
  cansync::ParameterResult result;
  result.outcome = outcome;
  return dds::parameter_reply(key, result);
}

cansync_ParameterReply ParameterTopic::answer(const RequestKey& key, const Terminal& terminal,
                                              const Request& request, std::span<std::uint8_t> /*data*/,
                                              const JobContext& context) {
  const auto* done = std::get_if<ParameterDone>(&terminal);
  const cansync::Outcome outcome = outcome_of(terminal);
  const Reply reply = done != nullptr ? dds::parameter_reply(key, done->result) : ended(key, outcome);
  return with_slave(reply, outcome, request, context);
}

cansync_TransferReply TransferTopic::ended(const RequestKey& key, cansync::Outcome outcome) {
  cansync::TransferResult result;
  result.outcome = outcome;
  return dds::transfer_reply(key, result, {});
}

cansync_TransferReply TransferTopic::answer(const RequestKey& key, const Terminal& terminal,
                                            const Request& request, std::span<std::uint8_t> data,
                                            const JobContext& context) {
  const auto* done = std::get_if<TransferDone>(&terminal);
  const auto* transfer = std::get_if<cansync::TransferRequest>(&request);
  const cansync::Outcome outcome = outcome_of(terminal);
  if (done == nullptr || transfer == nullptr) return ended(key, outcome);
  std::span<std::uint8_t> got;
  if (transfer->direction == cansync::TransferRequest::Direction::upload) {
    got = data.first(std::min<std::size_t>(data.size(), done->result.bytes));
  }
  return with_slave(dds::transfer_reply(key, done->result, got), outcome, request, context);
}

}  // namespace cansyncd
