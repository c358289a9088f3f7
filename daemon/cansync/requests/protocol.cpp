#include "daemon/cansync/requests/protocol.h"

#include <fmt/format.h>

#include <algorithm>
#include <variant>

#include "cansync/dds/convert.h"
#include "cansync/telegram/telegram.h"
#include "daemon/cansync/requests/audit_text.h"
#include "daemon/cansync/requests/gateway_requests.h"
#include "daemon/cansync/requests/kinds.h"
#include "daemon/cansync/texts/profile_rules.h"
#include "daemon/cansync/texts/refusal_text.h"
#include "daemon/desk/job_desk_answers.h"
#include "daemon/desk/job_desk_oversight.h"
#include "daemon/desk/job_desk_requests.h"
#include "text/counts.h"

namespace cansyncd {
namespace {

namespace dds = cansync::dds;
using cansync::SlaveMask;

/// The control word in a request, to one slave or to many.
std::optional<cansync::ActionCommand> action_of(const Request& request) {
  if (const auto* word = std::get_if<cansync::ControlWordRequest>(&request)) {
    return cansync::ActionCommand{SlaveMask::of(word->slave), cansync::kCommandControlWord, 0,
                                  word->control_word};
  }
  const auto* broadcast = std::get_if<cansync::BroadcastRequest>(&request);
  if (broadcast == nullptr || broadcast->action.command != cansync::kCommandControlWord) return std::nullopt;
  return broadcast->action;
}

std::optional<Change> with_name(std::optional<Change> change, const Config& config) {
  if (change && change->slave >= 0 && static_cast<std::size_t>(change->slave) < config.slaves.size())
    change->slave_name = config.slaves[static_cast<std::size_t>(change->slave)].name;
  return change;
}

bool is_word(const Request& request) noexcept {
  return std::holds_alternative<cansync::ControlWordRequest>(request);
}

}  // namespace

template class JobDesk<CansyncRequests>;

std::optional<Change> CansyncRequests::change_of(const cansync_Command& sample, const JobContext& context) {
  return with_name(cansyncd::change_of(sample), context.config);
}

std::optional<Change> CansyncRequests::change_of(const cansync_ParameterRequest& sample,
                                                 const JobContext& context) {
  auto change = cansyncd::change_of(sample);
  if (change) change->what = parameter_text(context.config, sample);
  return with_name(std::move(change), context.config);
}

std::optional<Change> CansyncRequests::change_of(const cansync_TransferRequest& sample,
                                                 const JobContext& context) {
  return with_name(cansyncd::change_of(sample), context.config);
}

std::optional<Request> CansyncRequests::request_of(const cansync_Command& sample, JobId id,
                                                   std::vector<std::uint8_t>& /*data*/) {
  return to_request(sample, id);
}

std::optional<Request> CansyncRequests::request_of(const cansync_ParameterRequest& sample, JobId id,
                                                   std::vector<std::uint8_t>& /*data*/) {
  return dds::to_core(sample, id);
}

std::optional<Request> CansyncRequests::request_of(const cansync_TransferRequest& sample, JobId id,
                                                   std::vector<std::uint8_t>& data) {
  data.resize(TransferTopic::bytes_of(sample));
  if (sample.direction == cansync_DIRECTION_DOWNLOAD) {
    std::copy_n(sample.data._buffer, sample.data._length, data.begin());
  }
  return dds::to_core(sample, id, data);
}

Lane CansyncRequests::lane_of(const Request& request) {
  return with_row(request, [](auto row, const auto& kind) { return row.lane(kind); });
}

std::string CansyncRequests::wrong_topic() {
  return not_on_topic_command();
}

gateway::dds::Problem CansyncRequests::objection(const Request& request, const JobContext& context) {
  return profile_refusal(request, context.config);
}

std::optional<Superseded> CansyncRequests::newer_of(const Request& request, const JobContext& context) {
  const auto action = action_of(request);
  if (!action) return std::nullopt;
  const bool enables = cansync::enables(context.config.master.startup, action->data_word);
  if (!is_word(request) && enables) return std::nullopt;
  return Superseded{is_word(request) ? action->slaves : SlaveMask{}, enables ? SlaveMask{} : action->slaves};
}

bool CansyncRequests::loses_to(const Request& request, const Superseded& newer, const JobContext& context) {
  const auto action = action_of(request);
  if (!action) return false;
  if (is_word(request) && (action->slaves.bits & newer.words.bits) != 0) return true;
  return cansync::enables(context.config.master.startup, action->data_word) &&
         (action->slaves.bits & newer.stopped.bits) != 0;
}

std::string CansyncRequests::text(const Request& request, const JobContext& context) {
  return describe(request, context.config).value_or("");
}

std::string CansyncRequests::open_text(const Request& request, const JobContext& context) {
  if (auto known = describe(request, context.config)) return *std::move(known);
  if (const auto* read = std::get_if<cansync::ParameterRequest>(&request)) {
    const std::string parameter = parameter_label(context.config, read->slave.value(), read->number.value());
    return fmt::format("read {} {}", slave_label(context.config, read->slave.value()), parameter);
  }
  if (const auto* upload = std::get_if<cansync::TransferRequest>(&request)) {
    return fmt::format("upload {} from {} address 0x{:X}", text::counted(upload->data.size(), "byte"),
                       slave_label(context.config, upload->slave.value()), upload->address);
  }
  return "a request";
}

void CansyncRequests::set_id(Request& request, JobId id) {
  std::visit(
      [id](auto& kind) {
        if constexpr (requires { kind.id; }) kind.id = id;
      },
      request);
}

JobId CansyncRequests::id_of(const Terminal& terminal) {
  return std::visit([](const auto& done) { return done.id; }, terminal);
}

gateway::dds::Problem CansyncRequests::refusal(const Terminal& terminal, const Request& request,
                                               const JobContext& context) {
  const auto* refused = std::get_if<Refused>(&terminal);
  if (refused == nullptr) return std::nullopt;
  return denial_of(refused->refusal, request, context.config, context.line);
}

void CansyncRequests::learn(const Request& request, const Terminal& terminal) {
  const auto* parameter = std::get_if<cansync::ParameterRequest>(&request);
  const auto* done = std::get_if<ParameterDone>(&terminal);
  if (parameter != nullptr && done != nullptr) audit_.learn(*parameter, done->result);
}

}  // namespace cansyncd
