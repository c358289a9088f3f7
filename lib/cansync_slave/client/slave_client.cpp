#include "cansync_slave/client/slave_client.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "dds/bounded_text.h"
#include "dds/daemon_identity.h"
#include "dds/reply_partition.h"
#include "dds/security.h"

namespace cansync_slave::client {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

/// The topic as a reader asks for it that wants nothing of before.
template <class T>
gateway::dds::TopicInfo reader_topic(bool only_new) noexcept {
  gateway::dds::TopicInfo info = gateway::dds::topic_info<T>;
  if (only_new) info.qos.transient_local = false;
  return info;
}

}  // namespace

SlaveClient::SlaveClient(const Options& options, bool only_new)
    : options_(options),
      identity_(gateway::dds::random_client_identity()),
      participant_(options.participant()),
      references_(participant_, reader_topic<cansync_slave_ReferencesReceived>(only_new), &signal_),
      monitored_(participant_, &signal_),
      actions_(participant_, reader_topic<cansync_slave_ActionReceived>(only_new), &signal_),
      parameter_jobs_(participant_, &signal_),
      block_jobs_(participant_, &signal_),
      status_(participant_, &signal_),
      command_replies_(participant_,
                       gateway::dds::Partitions{gateway::dds::reply_partition(options.bus, identity_)},
                       &signal_),
      commands_(participant_, 0, &signal_),
      sight_(participant_, signal_, options.bus) {
  sight_.find(
      options, signal_, "cansync-slave", {}, [this] { return matched(); },
      [this] { return status_.matched() != 0; });
}

bool SlaveClient::matched() const noexcept {
  return references_.matched() != 0 && monitored_.matched() != 0 && actions_.matched() != 0 &&
         parameter_jobs_.matched() != 0 && block_jobs_.matched() != 0 && status_.matched() != 0;
}

int SlaveClient::take(const Listener& listener) {
  sight_.look();
  int count = 0;
  const auto hand_on = [&count](const auto& function, const auto& sample) {
    ++count;
    if (function) function(sample);
  };
  actions_.take([&](const cansync_slave_ActionReceived& sample) { hand_on(listener.action, sample); });
  parameter_jobs_.take(
      [&](const cansync_slave_ParameterJob& sample) { hand_on(listener.parameter_job, sample); });
  block_jobs_.take([&](const cansync_slave_BlockJob& sample) { hand_on(listener.block_job, sample); });
  references_.take(
      [&](const cansync_slave_ReferencesReceived& sample) { hand_on(listener.references, sample); });
  monitored_.take([&](const cansync_slave_MonitoredValues& sample) { hand_on(listener.monitored, sample); });
  status_.take([&](const cansync_slave_SlaveSideStatus& sample) { newest_ = sample; });
  command_replies_.take([&](const cansync_slave_SlaveCommandReply& reply) {
    if (std::equal(identity_.begin(), identity_.end(), reply.client)) hand_on(listener.command_reply, reply);
  });
  return count;
}

SlaveClient::Commanded SlaveClient::command(cansync_slave_SlaveCommand wanted) {
  sight_.look();
  if (const auto found = sight_.obstacle()) return {0, found->reason, gateway_CAUSE_OTHER_DAEMON};
  if (!commands_.permitted())
    return {0, gateway::dds::no_right(gateway::dds::topic_info<cansync_slave_SlaveCommand>.name, "engineer"),
            gateway_CAUSE_RIGHT};
  if (!sight_.is_read(commands_) || !sight_.is_written(command_replies_))
    return {0, "the daemon takes no commands; it may have just come, or is older than this program",
            gateway_CAUSE_OTHER_DAEMON};
  std::copy(identity_.begin(), identity_.end(), std::begin(wanted.client));
  wanted.request = ++request_;
  gateway::dds::copy_text(options_.client_name, wanted.client_name);
  gateway::dds::set_daemon(sight_.choice().daemon(), wanted);
  const auto code = commands_.write(wanted);
  if (code == DDS_RETCODE_OK) return {wanted.request, {}, gateway_CAUSE_NONE};
  return {0, fmt::format("the command could not be written: {}", dds_strretcode(code)),
          code == DDS_RETCODE_TIMEOUT ? gateway_CAUSE_SHARED_LIMIT : gateway_CAUSE_UNKNOWN};
}

bool SlaveClient::receive(milliseconds time, const Listener& listener) {
  const auto end = steady_clock::now() + time;
  while (true) {
    signal_.clear();
    if (take(listener) > 0) return true;
    if (!daemon_present()) return false;
    const auto left = std::chrono::ceil<milliseconds>(end - steady_clock::now());
    if (left <= milliseconds{0} || options_.stopped()) return true;
    (void)signal_.wait(std::min(static_cast<int>(left.count()), gateway::dds::DaemonSight::kLookMs));
  }
}

std::optional<cansync_slave_SlaveSideStatus> SlaveClient::status(milliseconds time) {
  const auto end = steady_clock::now() + time;
  while (true) {
    signal_.clear();
    sight_.look();
    status_.take([this](const cansync_slave_SlaveSideStatus& sample) { newest_ = sample; });
    if (newest_ || options_.stopped() || !daemon_present() || steady_clock::now() >= end) return newest_;
    (void)signal_.wait(gateway::dds::DaemonSight::kLookMs);
  }
}

}  // namespace cansync_slave::client
