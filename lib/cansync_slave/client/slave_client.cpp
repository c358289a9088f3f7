#include "cansync_slave/client/slave_client.h"

namespace cansync_slave::client {
namespace {

using std::chrono::milliseconds;

/// The topic as a reader asks for it that wants nothing of before.
template <class T>
gateway::dds::TopicInfo reader_topic(bool only_new) noexcept {
  gateway::dds::TopicInfo info = gateway::dds::topic_info<T>;
  if (only_new) info.qos.transient_local = false;
  return info;
}

}  // namespace

SlaveClient::SlaveClient(const Options& options, bool only_new)
    : RequestClient(options),
      references_(participant(), reader_topic<cansync_slave_ReferencesReceived>(only_new), &signal()),
      monitored_(participant(), &signal()),
      actions_(participant(), reader_topic<cansync_slave_ActionReceived>(only_new), &signal()),
      parameter_jobs_(participant(), &signal()),
      block_jobs_(participant(), &signal()),
      status_(participant(), &signal()),
      command_replies_(participant(), reply_partitions(), &signal()),
      commands_(participant(), 0, &signal()) {
  connect(
      "cansync-slave", &status_, {.requests = {&commands_}, .replies = {&command_replies_}},
      [this] { return matched(); }, [this] { return status_.matched() != 0; });
}

bool SlaveClient::matched() const noexcept {
  return references_.matched() != 0 && monitored_.matched() != 0 && actions_.matched() != 0 &&
         parameter_jobs_.matched() != 0 && block_jobs_.matched() != 0 && status_.matched() != 0;
}

bool SlaveClient::receives_jobs() const {
  return sight().sees_several() || (sight().is_written(parameter_jobs_) && sight().is_written(block_jobs_));
}

int SlaveClient::take(const Listener& listener) {
  sight().look();
  int count = 0;
  const auto pass = [&count](const auto& function, const auto& sample) {
    ++count;
    if (function) function(sample);
  };
  actions_.take([&](const cansync_slave_ActionReceived& sample) { pass(listener.action, sample); });
  parameter_jobs_.take(
      [&](const cansync_slave_ParameterJob& sample) { pass(listener.parameter_job, sample); });
  block_jobs_.take([&](const cansync_slave_BlockJob& sample) { pass(listener.block_job, sample); });
  references_.take(
      [&](const cansync_slave_ReferencesReceived& sample) { pass(listener.references, sample); });
  monitored_.take([&](const cansync_slave_MonitoredValues& sample) { pass(listener.monitored, sample); });
  (void)take_status();
  command_replies_.take([&](const cansync_slave_SlaveCommandReply& reply) {
    if (is_mine(reply)) pass(listener.command_reply, reply);
  });
  return count;
}

gateway::dds::Begun SlaveClient::command(cansync_slave_SlaveCommand wanted) {
  sight().look();
  return begin(commands_, wanted, "engineer");
}

bool SlaveClient::receive(milliseconds time, const Listener& listener) {
  return wait_until(time, [&] { return take(listener) > 0; });
}

const std::optional<cansync_slave_SlaveSideStatus>& SlaveClient::take_status() {
  return newest_.take(status_);
}

std::optional<cansync_slave_SlaveSideStatus> SlaveClient::status(milliseconds time) {
  (void)wait_until(time, [this] {
    sight().look();
    return take_status().has_value();
  });
  return newest_.told();
}

}  // namespace cansync_slave::client
