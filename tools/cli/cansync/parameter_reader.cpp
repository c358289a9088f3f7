#include "cli/cansync/parameter_reader.h"

#include <deque>

namespace cansync::cli {
namespace {

/// Does the slave answer, whatever it says?
bool answered(client::ReplyCode code) noexcept {
  using client::ReplyCode;
  return code == ReplyCode::done || code == ReplyCode::slave_error;
}

}  // namespace

client::Reply read_parameters(
    Session& session, unsigned slave, const Parameters& parameters,
    const std::function<void(const profile::Parameter&, const client::ParameterReply&)>& taken) {
  std::deque<client::ParameterJob> open;
  std::size_t next = 0;
  client::Reply ended;
  ended.code = client::ReplyCode::done;
  const auto submit = [&](const profile::Parameter& parameter) {
    client::ParameterRequest request;
    request.slave = slave;
    request.number = parameter.number;
    request.timeout_ms = session.monitoring_ms();
    return session.client().submit(request);
  };
  for (const profile::Parameter* parameter : parameters) {
    while (open.size() < kOpenJobs && next < parameters.size() && !interrupt_flag().load())
      open.push_back(submit(*parameters[next++]));
    if (open.empty()) {  // Ctrl-C between two jobs
      ended.code = client::ReplyCode::cancelled;
      ended.reason = "cancelled";
      return ended;
    }
    client::ParameterReply reply =
        session.settle(session.wait(open.front()), Effect::reads, [&] { return submit(*parameter); });
    open.pop_front();
    taken(*parameter, reply);
    if (answered(reply.code)) continue;
    for (const client::ParameterJob& job : open) static_cast<void>(job.cancel());
    return reply;
  }
  return ended;
}

}  // namespace cansync::cli
