#include <dds/dds.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <functional>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "cansync/dds/topics.h"
#include "dds/daemon_identity.h"
#include "dds/denial.h"
#include "dds/endpoint.h"
#include "dds/reply_partition.h"
#include "gateway.h"

/// Asks a running daemon what the client library never asks, over bare DDS, and prints the cause of the first
/// refusal, a word. Usage: raw_asker DOMAIN BUS WHAT, WHAT being one of the names of kWays.
namespace {

using Identity = std::array<std::uint8_t, 16>;
using Way = std::function<gateway_RefusalCause(class Asker&)>;
constexpr std::chrono::minutes kPatience(2);

template <class Condition>
auto wait(const char* what, Condition&& condition) {
  const auto end = std::chrono::steady_clock::now() + kPatience;
  while (std::chrono::steady_clock::now() < end) {
    if (auto found = condition()) return found;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  throw std::runtime_error(std::string("waited in vain for ") + what);
}

/// Some clients of one program, each with a partition for its replies.
class Asker {
 public:
  explicit Asker(const gateway::dds::ParticipantOptions& options)
      : participant_(options), bus_(options.partition) {
    for (std::uint8_t i = 0; i < clients_.size(); ++i) {
      clients_[i].fill(static_cast<std::uint8_t>(0xA0 + i));
      partitions_.push_back(gateway::dds::reply_partition(bus_, clients_[i]));
    }
    parameter_replies_.emplace(participant_, partitions_, nullptr);
    transfer_replies_.emplace(participant_, partitions_, nullptr);
    wait("a daemon", [&] {
      (void)status_.take(
          [&](const gateway_GatewayStatus& status) { daemon_ = gateway::dds::daemon_of(status); });
      return daemon_ != gateway::dds::DaemonIdentity{} && parameters_.matched() != 0 &&
             transfers_.matched() != 0;
    });
  }

  cansync_ParameterRequest read(std::uint64_t number) const {
    cansync_ParameterRequest request = {};
    std::copy(clients_[0].begin(), clients_[0].end(), std::begin(request.client));
    request.request = number;
    request.number = 100;
    request.element = 7;
    request.format = cansync_FORMAT_AS_SLAVE_SAYS;
    gateway::dds::set_daemon(daemon_, request);
    return request;
  }
  cansync_TransferRequest upload(std::size_t client, std::uint64_t number) const {
    cansync_TransferRequest request = {};
    std::copy(clients_[client].begin(), clients_[client].end(), std::begin(request.client));
    request.request = number;
    request.direction = cansync_DIRECTION_UPLOAD;
    request.address = 4096;
    request.length = 16u << 20;
    gateway::dds::set_daemon(daemon_, request);
    return request;
  }

  void send(const cansync_ParameterRequest& request) { written(parameters_.write(request)); }
  void send(const cansync_TransferRequest& request) { written(transfers_.write(request)); }
  /// As if it had been written at that time.
  void send(const cansync_ParameterRequest& request, std::chrono::system_clock::time_point when) {
    using std::chrono::nanoseconds;
    written(dds_write_ts(parameters_.handle(), &request,
                         std::chrono::duration_cast<nanoseconds>(when.time_since_epoch()).count()));
  }

  /// The cause of the first refusal among the replies that come.
  gateway_RefusalCause refusal() {
    return *wait("a refusal", [&] {
      std::optional<gateway_RefusalCause> found;
      const auto look = [&](const auto& reply) {
        if (!found && reply.code == gateway_REPLY_REFUSED) found = reply.cause;
      };
      (void)parameter_replies_->take(look);
      (void)transfer_replies_->take(look);
      return found;
    });
  }

 private:
  static void written(dds_return_t code) {
    if (code != DDS_RETCODE_OK) throw std::runtime_error(std::string("write: ") + dds_strretcode(-code));
  }

  gateway::dds::Participant participant_;
  std::string bus_;
  std::array<Identity, 5> clients_ = {};
  gateway::dds::Partitions partitions_;
  gateway::dds::DaemonIdentity daemon_ = {};
  gateway::dds::Reader<gateway_GatewayStatus> status_{participant_};
  gateway::dds::Writer<cansync_ParameterRequest> parameters_{participant_};
  gateway::dds::Writer<cansync_TransferRequest> transfers_{participant_};
  std::optional<gateway::dds::Reader<cansync_ParameterReply>> parameter_replies_;
  std::optional<gateway::dds::Reader<cansync_TransferReply>> transfer_replies_;
};

gateway_RefusalCause names_no_daemon(Asker& asker) {
  cansync_ParameterRequest request = asker.read(1);
  gateway::dds::set_daemon({}, request);
  asker.send(request);
  return asker.refusal();
}

gateway_RefusalCause an_hour_ago(Asker& asker) {
  asker.send(asker.read(1), std::chrono::system_clock::now() - std::chrono::hours(1));
  return asker.refusal();
}

gateway_RefusalCause one_number_twice(Asker& asker) {
  asker.send(asker.read(1));
  asker.send(asker.read(1));
  return asker.refusal();
}

/// More than 64 at once; each takes an interval of the line at least.
gateway_RefusalCause a_thousand_at_once(Asker& asker) {
  for (std::uint64_t number = 1; number <= 1000; ++number) asker.send(asker.read(number));
  return asker.refusal();
}

/// 16 MiB each, two of a client: the ninth is over 128 MiB.
gateway_RefusalCause nine_long_uploads(Asker& asker) {
  for (std::uint64_t number = 1; number <= 9; ++number) asker.send(asker.upload((number - 1) / 2, number));
  return asker.refusal();
}

const std::map<std::string, Way> kWays = {
    {"names_no_daemon", names_no_daemon},     {"an_hour_ago", an_hour_ago},
    {"one_number_twice", one_number_twice},   {"a_thousand_at_once", a_thousand_at_once},
    {"nine_long_uploads", nine_long_uploads},
};

}  // namespace

int main(int argc, char** argv) {
  try {
    if (argc != 4) throw std::runtime_error("usage: raw_asker DOMAIN BUS WHAT");
    gateway::dds::ParticipantOptions options;
    options.domain = static_cast<std::uint32_t>(std::strtoul(argv[1], nullptr, 10));
    options.partition = argv[2];
    Asker asker(options);
    std::puts(gateway::dds::name(kWays.at(argv[3])(asker)).data());
    return EXIT_SUCCESS;
  } catch (const std::exception& error) {
    std::printf("%s\n", error.what());
    return EXIT_FAILURE;
  }
}
