#include "layer2/client/frame_client.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sys/random.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <iterator>
#include <span>
#include <utility>

#include "dds/bounded_text.h"
#include "dds/daemon_identity.h"
#include "dds/writer_identity.h"
#include "layer2/dds/convert.h"

namespace layer2::client {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

/// Waiting is looked at again so often: `stop` is seen soon.
constexpr milliseconds kLook{20};
/// From the end of a request's monitoring time to its reply, and from a cancel to it.
constexpr milliseconds kGrace{5000};
/// For the monitoring time of a daemon that has not told its own.
constexpr milliseconds kDefaultMonitoring{1000};

/// Replies to other clients come, too; they must be taken, for a full reader holds up all topics.
constexpr std::uint64_t kNobodysRequest = 0;

/// 16 random bytes: no two clients have the same.
std::array<std::uint8_t, 16> random_identity() {
  std::array<std::uint8_t, 16> identity;
  if (getrandom(identity.data(), identity.size(), 0) != static_cast<ssize_t>(identity.size()))
    throw gateway::dds::SetupError("the system gave no random numbers for the client's identity");
  return identity;
}

}  // namespace

FrameClient::FrameClient(const Options& options)
    : options_(options),
      identity_(random_identity()),
      participant_({.domain = options.domain,
                    .partition = options.bus,
                    .interface = options.interface,
                    .xml = options.xml,
                    .security = options.security,
                    .final_types = options.final_types}),
      replies_(participant_, &signal_),
      batches_(participant_, &signal_),
      status_(participant_, &signal_),
      gateway_(participant_, &signal_),
      requests_(participant_, 0, &signal_),
      cancels_(participant_, 0, &signal_) {
  using View = gateway::dds::DaemonChoice::View;
  const auto end = steady_clock::now() + options.wait;
  while (!matched() || choice_.view() != View::one) {
    if (choice_.view() == View::several) throw NoDaemon(obstacle()->reason);
    if (stopped() || steady_clock::now() >= end) {
      if (status_.matched() != 0 && !gateway_newest_) {
        throw NoDaemon(fmt::format(
            "the daemon of bus {} has data model 6 or older, this program {}: the two do not understand each other "
            "({}); update cansyncd, or use a program of its version",
            options.bus, gateway_DATA_MODEL, participant_.place()));
      }
      throw NoDaemon(
          fmt::format("no daemon of general frames found: looked for {} on {}; is cansyncd running "
                      "for bus {} with bus.protocol = \"layer2\", and with the same domain and "
                      "interface in its [dds] section?",
                      options.wait, participant_.place(), options.bus));
    }
    (void)signal_.wait(static_cast<int>(kLook.count()));
    signal_.clear();
    take_gateway_status();
  }
}

bool FrameClient::matched() const noexcept {
  return gateway_newest_ && replies_.matched() != 0 && batches_.matched() != 0 && status_.matched() != 0 &&
         (requests_.matched() != 0 || !requests_.permitted()) &&
         (cancels_.matched() != 0 || !cancels_.permitted());
}

void FrameClient::take_gateway_status() {
  gateway_.take_batch([this](const gateway_GatewayStatus& sample, const dds_sample_info_t& info) {
    if (!info.valid_data) return;
    gateway_newest_ = sample;
    choice_.heard(info.publication_handle, gateway::dds::daemon_of(sample));
  });
  std::array<dds_instance_handle_t, 64> matched = {};
  const dds_return_t count = dds_get_matched_publications(gateway_.handle(), matched.data(), matched.size());
  const auto there = std::min(static_cast<std::size_t>(std::max(count, 0)), matched.size());
  choice_.look(steady_clock::now(), std::span(matched).first(there));
}

std::string FrameClient::names_of_living() const {
  std::string names;
  for (const auto writer : choice_.living()) {
    if (!names.empty()) names += "; ";
    const auto who = gateway::dds::identify_writer(participant_, gateway_.handle(), writer);
    names += who ? who->who : "an unknown program";
  }
  return names;
}

std::optional<SendResult> FrameClient::obstacle() {
  using View = gateway::dds::DaemonChoice::View;
  const auto refused = [this](std::string reason) {
    choice_.program_told();
    return SendResult{true, gateway_REPLY_REFUSED, gateway_CAUSE_OTHER_DAEMON, std::move(reason), 0};
  };
  switch (choice_.view()) {
    case View::several:
      return refused(fmt::format(
          "several daemons serve bus {} ({}): {}; nothing was sent: stop all but one, or give each a "
          "bus.name of its own",
          options_.bus, participant_.place(), names_of_living()));
    case View::unsure:
      return refused(fmt::format(
          "the daemon was started anew, or a second one serves bus {}: {}; nothing was sent; try again "
          "later",
          options_.bus, names_of_living()));
    case View::none:
      choice_.program_told();
      return SendResult{false, gateway_REPLY_DONE, gateway_CAUSE_NONE, "the daemon has gone", 0};
    case View::one:
      break;
  }
  if (!choice_.to_be_told()) return std::nullopt;
  return refused(
      "the daemon was started anew; nothing was sent: ask again; requests from now on are for the new one");
}

SendResult FrameClient::send(const can::Frame& frame, std::uint32_t timeout_ms) {
  take_gateway_status();
  if (auto problem = obstacle()) return *std::move(problem);
  const auto daemon = choice_.place();
  layer2_SendRequest request = {};
  std::copy(identity_.begin(), identity_.end(), std::begin(request.client));
  request.request = ++number_;
  gateway::dds::copy_text(options_.client_name, request.client_name);
  gateway::dds::set_daemon(choice_.daemon(), request);
  request.content = dds::to_idl(frame);
  request.timeout = timeout_ms;
  if (const auto code = requests_.write(request); code != DDS_RETCODE_OK) {
    const bool forbidden = code == DDS_RETCODE_NOT_ALLOWED_BY_SECURITY;
    const bool full = code == DDS_RETCODE_TIMEOUT;
    return {true, gateway_REPLY_REFUSED,
            forbidden ? gateway_CAUSE_RIGHT : (full ? gateway_CAUSE_SHARED_LIMIT : gateway_CAUSE_UNKNOWN),
            forbidden ? "the identity has no right to write topic SendRequest, nothing was sent"
                      : fmt::format("the request could not be written: {}", dds_strretcode(code)),
            0};
  }
  const auto monitoring = timeout_ms != 0 ? milliseconds(timeout_ms)
                          : newest_       ? milliseconds(newest_->send_timeout)
                                          : kDefaultMonitoring;
  auto end = steady_clock::now() + monitoring + kGrace;
  bool cancelled = false;
  while (!cancelled || steady_clock::now() < end) {
    if (auto result = take_reply(request.request)) return *result;
    if (!choice_.may_answer(daemon)) {
      choice_.program_told();
      return {false, gateway_REPLY_DONE, gateway_CAUSE_NONE, "the daemon has gone", 0};
    }
    if (!cancelled && (stopped() || steady_clock::now() >= end)) {
      cancelled = true;
      cancel(request);
      end = steady_clock::now() + kGrace;
    }
    (void)signal_.wait(static_cast<int>(kLook.count()));
    signal_.clear();
  }
  return {false, gateway_REPLY_DONE, gateway_CAUSE_NONE, "the daemon did not answer", 0};
}

std::optional<SendResult> FrameClient::take_reply(std::uint64_t request) {
  take_gateway_status();
  std::optional<SendResult> result;
  replies_.take([&](const layer2_SendReply& reply) {
    if (reply.request != request || !std::equal(identity_.begin(), identity_.end(), reply.client)) return;
    result = {true, reply.code, reply.cause, std::string(gateway::dds::text(reply.reason)), reply.sent_time};
  });
  return result;
}

void FrameClient::cancel(const layer2_SendRequest& request) {
  gateway_JobCancel sample = {};
  std::copy(identity_.begin(), identity_.end(), std::begin(sample.client));
  sample.request = request.request;
  gateway::dds::set_daemon(gateway::dds::daemon_of(request), sample);
  (void)cancels_.write(sample);
}

bool FrameClient::receive(milliseconds time, const std::function<void(const layer2_FrameBatch&)>& on_batch) {
  const auto end = steady_clock::now() + time;
  while (true) {
    signal_.clear();
    (void)take_reply(kNobodysRequest);
    if (batches_.take(on_batch) > 0) return true;
    if (!daemon_present()) return false;
    const auto left = std::chrono::ceil<milliseconds>(end - steady_clock::now());
    if (left <= milliseconds{0} || stopped()) return true;
    (void)signal_.wait(static_cast<int>(std::min(left, kLook).count()));
  }
}

std::optional<layer2_FrameStatus> FrameClient::status(milliseconds time) {
  const auto end = steady_clock::now() + time;
  while (true) {
    signal_.clear();
    (void)take_reply(kNobodysRequest);
    status_.take([this](const layer2_FrameStatus& sample) { newest_ = sample; });
    if (newest_ || stopped() || !daemon_present() || steady_clock::now() >= end) return newest_;
    (void)signal_.wait(static_cast<int>(kLook.count()));
  }
}

}  // namespace layer2::client
