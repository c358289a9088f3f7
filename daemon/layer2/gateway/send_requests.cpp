#include "daemon/layer2/gateway/send_requests.h"

#include <fmt/format.h>

#include <array>

#include "can/candump.h"
#include "daemon/desk/job_desk_answers.h"
#include "daemon/desk/job_desk_requests.h"

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
  change.new_value = check(sample) ? fmt::format("identifier 0x{:X}, {} bytes", sample.content.identifier,
                                                 sample.content.length)
                                   : frame_text(layer2::dds::to_core(sample.content));
  return change;
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
