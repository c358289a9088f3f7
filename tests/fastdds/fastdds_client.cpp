// A program of Fast DDS that uses the gateway, with nothing but what fastddsgen makes of the IDL. For
// fastdds_test.py, which says what must come of it.
//   fastdds_client DOMAIN BUS use                      state, parameters, transfers, a cancel; then it ends
//   fastdds_client DOMAIN BUS lead STRENGTH VALUE      gives reference value 0 until it is killed
//   fastdds_client DOMAIN BUS look                     says when a daemon comes and goes

#include <sys/random.h>

#include <algorithm>
#include <array>
#include <iostream>
#include <optional>
#include <thread>
#include <vector>

#include "cansyncPubSubTypes.h"
#include "fastdds_bus.h"
#include "gatewayPubSubTypes.h"

namespace fastdds_client {
namespace {

using Identity = std::array<std::uint8_t, 16>;
using GatewayReader = Reader<gateway::GatewayStatus, gateway::GatewayStatusPubSubType>;
using MasterReader = Reader<cansync::MasterStatus, cansync::MasterStatusPubSubType>;

constexpr unsigned kSlaves = 32;
constexpr std::uint8_t kSlave = 3;
constexpr std::uint32_t kParameter = 1000;
constexpr std::uint32_t kAddress = 0x1000;
constexpr std::uint32_t kBytes = 65536;

Identity random_identity() {
  Identity identity;
  if (getrandom(identity.data(), identity.size(), 0) != static_cast<ssize_t>(identity.size()))
    throw std::runtime_error("no random numbers");
  return identity;
}

/// Partition of the replies to one client.
std::string replies_of(const std::string& bus, const Identity& identity) {
  constexpr const char* kDigits = "0123456789abcdef";
  std::string out = bus + "/";
  for (const std::uint8_t byte : identity) {
    out += kDigits[byte >> 4];
    out += kDigits[byte & 15];
  }
  return out;
}

void expect(bool holds, const std::string& what) {
  if (!holds) throw std::runtime_error("wrong: " + what);
}

/// Everything that requests take.
class Client {
 public:
  Client(std::uint32_t domain, const std::string& bus)
      : identity_(random_identity()), bus_(domain, bus, replies_of(bus, identity_)) {
    News& news = bus_.news();
    news.wait("the daemon hears every request, and its replies come here", [&] {
      return parameter_writer_.matched() && transfer_writer_.matched() && cancel_writer_.matched() &&
             parameter_reader_.matched() && transfer_reader_.matched() && progress_.matched();
    });
    // Its own reader is the last: when the status is here, the daemon knows the readers of replies, too.
    GatewayReader status(bus_, "GatewayStatus", state_reader());
    gateway::GatewayStatus gateway;
    news.wait("the daemon's status", [&] { return status.take(gateway); });
    daemon_ = gateway.daemon();
  }

  void see_every_slave() {
    Reader<cansync::ActualValues, cansync::ActualValuesPubSubType> actual(bus_, "ActualValues",
                                                                          state_reader());
    std::array<unsigned, kSlaves> seen = {};
    bus_.news().wait("actual values of every slave, again and again", [&] {
      cansync::ActualValues sample;
      while (actual.take(sample)) {
        expect(sample.slave() < kSlaves && sample.ever() != 0, "actual values");
        ++seen.at(sample.slave());
      }
      return std::all_of(seen.begin(), seen.end(), [](unsigned count) { return count >= 3; });
    });
  }

  void use_parameters() {
    expect(parameter(true, kSlave, 4711).code() == gateway::REPLY_DONE, "a write is done");
    const cansync::ParameterReply read = parameter(false, kSlave, 0);
    expect(read.code() == gateway::REPLY_DONE && read.value() == 4711, "what was written is read");
    const cansync::ParameterReply refused = parameter(false, 40, 0);
    expect(refused.code() == gateway::REPLY_REFUSED && refused.cause() == gateway::CAUSE_FIELD,
           "slave 40 is refused: " + refused.reason().to_string());
  }

  void use_transfers() {
    std::vector<std::uint8_t> data(kBytes);
    for (std::size_t i = 0; i < data.size(); ++i) data[i] = static_cast<std::uint8_t>(i * 7 + i / 256);
    const std::uint64_t down = transfer(cansync::DIRECTION_DOWNLOAD, data);
    const cansync::TransferReply stored = transfer_reply(down);
    expect(stored.code() == gateway::REPLY_DONE && stored.done() == kBytes,
           "a download: " + stored.reason().to_string());
    const cansync::TransferReply loaded = transfer_reply(transfer(cansync::DIRECTION_UPLOAD, {}));
    expect(loaded.code() == gateway::REPLY_DONE && loaded.data() == data,
           "an upload of the same bytes: " + loaded.reason().to_string());
  }

  void cancel() {
    const std::uint64_t request = transfer(cansync::DIRECTION_UPLOAD, {});
    cansync::TransferProgress progress;
    bus_.news().wait("the upload has begun", [&] {
      return progress_.take(progress) && progress.request() == request && progress.done() > 0;
    });
    gateway::JobCancel cancel;
    cancel.client(identity_);
    cancel.request(request);
    cancel.daemon(daemon_);
    cancel_writer_.write(cancel);
    const cansync::TransferReply reply = transfer_reply(request);
    expect(reply.code() == gateway::REPLY_CANCELLED && reply.done() < kBytes,
           "cancelled: " + reply.reason().to_string());
  }

 private:
  cansync::ParameterReply parameter(bool write, std::uint32_t slave, std::uint32_t value) {
    cansync::ParameterRequest request;
    request.client(identity_);
    request.request(++number_);
    request.client_name("fastdds");
    request.write(write);
    request.slave(slave);
    request.number(kParameter);
    request.element(7);
    request.format(cansync::FORMAT_AS_SLAVE_SAYS);
    request.value(value);
    request.daemon(daemon_);
    parameter_writer_.write(request);
    cansync::ParameterReply reply;
    bus_.news().wait("the reply of a parameter", [&] {
      while (parameter_reader_.take(reply)) {
        if (reply.client() == identity_ && reply.request() == number_) return true;
      }
      return false;
    });
    return reply;
  }

  std::uint64_t transfer(cansync::TransferDirection direction, const std::vector<std::uint8_t>& data) {
    cansync::TransferRequest request;
    request.client(identity_);
    request.request(++number_);
    request.client_name("fastdds");
    request.direction(direction);
    request.slave(kSlave);
    request.address(kAddress);
    request.length(kBytes);
    request.data(data);
    request.daemon(daemon_);
    transfer_writer_.write(request);
    return number_;
  }

  cansync::TransferReply transfer_reply(std::uint64_t request) {
    cansync::TransferReply reply;
    bus_.news().wait("the reply of a transfer", [&] {
      while (transfer_reader_.take(reply)) {
        if (reply.client() == identity_ && reply.request() == request) return true;
      }
      return false;
    });
    return reply;
  }

  Identity identity_;
  Bus bus_;
  Identity daemon_ = {};
  std::uint64_t number_ = 0;
  Reader<cansync::ParameterReply, cansync::ParameterReplyPubSubType> parameter_reader_{bus_, "ParameterReply",
                                                                                       reply_reader()};
  Reader<cansync::TransferReply, cansync::TransferReplyPubSubType> transfer_reader_{bus_, "TransferReply",
                                                                                    reply_reader()};
  Reader<cansync::TransferProgress, cansync::TransferProgressPubSubType> progress_{bus_, "TransferProgress",
                                                                                   latest_reader()};
  Writer<cansync::ParameterRequest, cansync::ParameterRequestPubSubType> parameter_writer_{
      bus_, "ParameterRequest", request_writer()};
  Writer<cansync::TransferRequest, cansync::TransferRequestPubSubType> transfer_writer_{
      bus_, "TransferRequest", request_writer()};
  Writer<gateway::JobCancel, gateway::JobCancelPubSubType> cancel_writer_{bus_, "JobCancel",
                                                                          request_writer()};
};

void step(const std::string& name, const std::function<void()>& run) {
  const auto began = std::chrono::steady_clock::now();
  run();
  std::cout << name << ": " << std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count()
            << " s" << std::endl;
}

void use(std::uint32_t domain, const std::string& bus) {
  std::optional<Client> client;
  step("connected", [&] { client.emplace(domain, bus); });
  step("actual values", [&] { client->see_every_slave(); });
  step("parameters", [&] { client->use_parameters(); });
  step("transfers", [&] { client->use_transfers(); });
  step("cancel", [&] { client->cancel(); });
}

/// Writes reference value 0 every 10 ms; each is good for so many intervals that a busy machine does not
/// matter.
[[noreturn]] void lead(std::uint32_t domain, const std::string& name, std::uint32_t strength,
                       std::int32_t value) {
  Bus bus(domain, name, name);
  GatewayReader status(bus, "GatewayStatus", state_reader());
  MasterReader line(bus, "MasterStatus", state_reader());
  Writer<cansync::ReferenceValues, cansync::ReferenceValuesPubSubType> writer(
      bus, "ReferenceValues", reference_writer(strength, "fastdds-" + std::to_string(strength)));
  gateway::GatewayStatus gateway;
  cansync::MasterStatus master;
  bool known = false;
  bool mapped = false;
  bus.news().wait("the master's status, and a daemon that hears reference values", [&] {
    known = status.take(gateway) || known;
    mapped = line.take(master) || mapped;
    return known && mapped && writer.matched();
  });
  std::cout << "leads" << std::endl;
  while (true) {
    (void)line.take(master);
    cansync::ReferenceValues values;
    values.telegram(1);
    values.value({value, 0, 0, 0});
    values.valid(1);
    values.release_intervals(1000);
    values.daemon(gateway.daemon());
    values.mapping_number(master.mapping_number());
    values.writer(writer.guid());
    writer.write(values);
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
}

void look(std::uint32_t domain, const std::string& name) {
  Bus bus(domain, name, name);
  const GatewayReader status(bus, "GatewayStatus", state_reader());
  bus.news().wait("a daemon", [&] { return status.matched(); });
  std::cout << "there" << std::endl;
  bus.news().wait("it goes", [&] { return !status.matched(); });
  std::cout << "gone" << std::endl;
}

int run(const std::vector<std::string>& words) {
  const auto domain = static_cast<std::uint32_t>(std::stoul(words.at(1)));
  if (words.at(3) == "use") use(domain, words.at(2));
  if (words.at(3) == "look") look(domain, words.at(2));
  if (words.at(3) == "lead")
    lead(domain, words.at(2), static_cast<std::uint32_t>(std::stoul(words.at(4))), std::stoi(words.at(5)));
  return 0;
}

}  // namespace
}  // namespace fastdds_client

int main(int argc, char** argv) {
  try {
    return fastdds_client::run({argv, argv + argc});
  } catch (const std::exception& error) {
    std::cerr << "fastdds_client: " << error.what() << std::endl;
    return 1;
  }
}
