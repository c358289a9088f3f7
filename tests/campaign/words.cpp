#include "words.h"

#include <algorithm>
#include <charconv>
#include <optional>
#include <type_traits>
#include <variant>

#include "cli/base/exit_codes.h"
#include "cli/connect/gateway_reply.h"
#include "daemon/cansync/requests/protocol.h"

namespace cansyncd::campaign {
namespace {

namespace dds = cansync::dds;

/// What the client has written, as far as the audit trail looks at it.
cansync_ParameterRequest sample_of(const cansync::ParameterRequest& request) {
  cansync_ParameterRequest sample = {};
  sample.write = request.write;
  sample.slave = request.slave.value();
  sample.sub_slave = request.sub_slave.value;
  sample.number = request.number.value();
  sample.element = request.element.value();
  sample.value = request.value;
  return sample;
}

cansync_TransferRequest sample_of(const cansync::TransferRequest& request) {
  cansync_TransferRequest sample = {};
  const bool upload = request.direction == cansync::TransferRequest::Direction::upload;
  sample.direction = upload ? cansync_DIRECTION_UPLOAD : cansync_DIRECTION_DOWNLOAD;
  sample.slave = request.slave.value();
  sample.address = request.address;
  sample.length = static_cast<std::uint32_t>(request.data.size());
  sample.data._length = sample.length;
  return sample;
}

cansync_Command sample_of(const cansync::ControlWordRequest& request) {
  cansync_Command sample = {};
  sample.kind = cansync_COMMAND_CONTROL_WORD;
  sample.slave = request.slave.value();
  sample.control_word = request.control_word;
  return sample;
}

cansync_Command sample_of(const cansync::BroadcastRequest& request) {
  cansync_Command sample = {};
  sample.kind = cansync_COMMAND_BROADCAST;
  sample.priority = request.priority;
  sample.slave_mask = request.action.slaves.bits;
  sample.action = request.action.command;
  sample.data_byte = request.action.data_byte;
  sample.data_word = request.action.data_word;
  return sample;
}

cansync_Command sample_of(const ModeRequest& request) {
  cansync_Command sample = {};
  sample.kind = cansync_COMMAND_MODE;
  sample.mode = static_cast<cansync_Mode>(request.mode);
  sample.force = request.force;
  return sample;
}

/// Settings: the trail has the kind and the words, and nothing of them is a drive's.
template <class Setting>
cansync_Command sample_of(const Setting& /*request*/) {
  cansync_Command sample = {};
  sample.kind = cansync_COMMAND_POLLING;
  return sample;
}

std::optional<Change> change_of(const Request& request, const JobContext& context) {
  return std::visit([&](const auto& kind) { return CansyncRequests::change_of(sample_of(kind), context); },
                    request);
}

Requester requester_of(const Terminal& terminal) {
  const std::uint64_t id = CansyncRequests::id_of(terminal);
  return {"client", "client", "", id};
}

template <class Topic>
typename Topic::Reply reply_of(const Request& request, const Terminal& terminal, std::span<std::uint8_t> data,
                               const JobContext& context) {
  const gateway::dds::RequestKey key;
  if (const auto refused = CansyncRequests::refusal(terminal, request, context))
    return Topic::refused(key, *refused);
  return Topic::answer(key, terminal, request, data, context);
}

}  // namespace

std::string_view JournalEntry::field(std::string_view name) const {
  const auto found =
      std::find_if(fields.begin(), fields.end(), [&](const auto& f) { return f.name == name; });
  return found == fields.end() ? std::string_view() : std::string_view(found->value);
}

Words::Words(const Plan& plan, Exchange& exchange)
    : exchange_(exchange),
      config_([&] {
        Config config;
        config.master = plan.settings;
        return config;
      }()),
      trail_(*this, *this, "bus", cansync::kSlaves),
      audit_(trail_, config_) {}

Said Words::ended(const Request& request, const Terminal& terminal, cansync::State state, bool remembers,
                  SteadyTime now) {
  said_ = {};
  JobContext context{exchange_, config_, {}, now, {}};
  context.line.state = state;
  record(request, terminal, context, remembers);
  reply(request, terminal, context);
  const gateway::dds::Ended ended{true, said_.code, said_.cause, said_.reason};
  said_.exit_status = static_cast<unsigned>(cansync::cli::exit_code(cansync::cli::reply_of(ended).code));
  return std::move(said_);
}

void Words::record(const Request& request, const Terminal& terminal, const JobContext& context,
                   bool remembers) {
  const std::optional<Change> change = change_of(request, context);
  const Requester who = requester_of(terminal);
  if (const auto refused = CansyncRequests::refusal(terminal, request, context)) {
    if (change) audit_.refused(who, *change, request, context.line.state, *refused, context.now);
    return;
  }
  const cansync::Outcome outcome = outcome_of(terminal);
  if (change) {
    audit_.ended(who, *change, request, context.line.state, outcome, context.now);
  } else if (remembers) {
    audit_.remember(request, outcome);
  }
  const auto* parameter = std::get_if<cansync::ParameterRequest>(&request);
  const auto* done = std::get_if<ParameterDone>(&terminal);
  if (parameter != nullptr && done != nullptr && remembers) audit_.learn(*parameter, done->result);
}

void Words::reply(const Request& request, const Terminal& terminal, const JobContext& context) {
  const auto say = [&](const auto& reply) {
    said_.code = reply.code;
    said_.cause = reply.cause;
    said_.reason = reply.reason;
  };
  if (const auto* transfer = std::get_if<cansync::TransferRequest>(&request)) {
    say(reply_of<TransferTopic>(request, terminal, transfer->data, context));
  } else if (std::holds_alternative<cansync::ParameterRequest>(request)) {
    say(reply_of<ParameterTopic>(request, terminal, {}, context));
  } else {
    say(reply_of<CommandTopic>(request, terminal, {}, context));
  }
}

std::uint64_t Words::summed_up(SteadyTime now) {
  static_cast<void>(trail_.tick(now));
  return summed_up_;
}

void Words::write(LogPriority /*priority*/, EventCode event, const std::string& /*message*/,
                  const std::vector<JournalField>& fields) {
  JournalEntry entry{std::string(event.word()), fields};
  if (entry.event != "requests_not_recorded") return said_.entries.push_back(std::move(entry));
  const std::string_view number = entry.field("CANSYNC_REFUSED");
  std::uint64_t more = 0;
  std::from_chars(number.data(), number.data() + number.size(), more);
  summed_up_ += more;
}

bool Words::publish(const EventText& event, SteadyTime /*now*/) {
  if (event.request) said_.events.push_back(event);
  return true;
}

}  // namespace cansyncd::campaign
