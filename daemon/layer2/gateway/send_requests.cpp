#include "daemon/layer2/gateway/send_requests.h"

#include <fmt/format.h>

#include <array>
#include <variant>

#include "can/candump.h"
#include "daemon/desk/job_desk_answers.h"
#include "daemon/desk/job_desk_oversight.h"
#include "daemon/desk/job_desk_requests.h"
#include "text/counts.h"

namespace cansyncd {

template class JobDesk<SendRequests>;

std::string frame_text(const can::Frame& frame) {
  std::array<char, can::kCandumpLineLimit> line;
  const std::size_t size = can::write_candump_line({}, "x", frame, line);
  const std::string text(line.data(), size == 0 ? 0 : size - 1);  // without its line feed
  return text.substr(text.rfind(' ') + 1);
}

std::optional<Change> SendRequests::change_of(const layer2_SendRequest& sample, const SendContext&) {
  Change change;
  change.action = "send_frame";
  change.new_value = check(sample) ? fmt::format("identifier 0x{:X}, {}", sample.content.identifier,
                                                 text::counted(sample.content.length, "byte"))
                                   : frame_text(layer2::dds::to_core(sample.content));
  return change;
}

std::optional<Change> SendRequests::change_of(const layer2_ControlRequest& sample, const SendContext&) {
  static constexpr std::array<const char*, layer2_CONTROL_WRITE_IMAGE + 1> kActions = {
      "run",          "stop",           "start_timer", "stop_timer", "set_timer", "reset_controller",
      "clear_queues", "reset_overflow", "write_image"};
  Change change;
  const auto kind = static_cast<std::size_t>(sample.kind);
  change.action = kind < kActions.size() ? kActions[kind] : "control";
  if (sample.kind == layer2_CONTROL_START_TIMER || sample.kind == layer2_CONTROL_STOP_TIMER)
    change.new_value = fmt::format("timer {}", sample.number);
  if (sample.kind == layer2_CONTROL_SET_TIMER) {
    change.new_value = fmt::format("timer {}: {} every {} us from {} us on{}", sample.number,
                                   frame_text(layer2::dds::to_core(sample.content)), sample.period,
                                   sample.phase, sample.cyclic ? "" : ", once");
  }
  if (sample.kind == layer2_CONTROL_WRITE_IMAGE)
    change.new_value = fmt::format("{} from byte {} on", text::counted(sample.size, "byte"), sample.address);
  return change;
}

LaneLimits SendRequests::lane_limits() const {
  // A queue that refuses is never asked for more than it has room for.
  constexpr unsigned kRoom = layer2::Station::kMostQueue;
  const bool deletes = config_.overflow == layer2::Overflow::delete_oldest;
  const unsigned normal = deletes ? kRoom : config_.queue;
  const unsigned high = deletes ? kRoom : config_.high_queue;
  return {{normal, normal}, {high, high}, {16, 16}};
}

Lane SendRequests::lane_of(const Request& request) noexcept {
  const auto* order = std::get_if<layer2::SendOrder>(&request);
  if (order == nullptr) return {FrameLane::control, 0};
  return {order->priority == layer2::Priority::high ? FrameLane::high : FrameLane::normal, 0};
}

bool SendRequests::hand_on(const Request& request, const SendContext& context) {
  return std::visit([&](const auto& order) { return context.exchange.requests.try_push(order); }, request);
}

gateway::dds::Problem SendRequests::refusal(const SendDone& done, const Request&, const SendContext&) const {
  return layer2::dds::explain(done.refusal, config_.queue);
}

std::string_view SendRequests::name(Outcome outcome) noexcept {
  switch (outcome) {
    case Outcome::done:
      return "done";
    case Outcome::no_answer:
      return "no_answer";
    case Outcome::timeout:
      return "timeout";
    case Outcome::cancelled:
      return "cancelled";
    case Outcome::displaced:
      return "displaced";
    case Outcome::deleted:
      return "deleted";
    case Outcome::stopped:
      break;
  }
  return "stopped";
}

}  // namespace cansyncd
