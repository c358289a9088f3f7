#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <iterator>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <typeindex>
#include <vector>

#include "dds/bounded_text.h"
#include "dds/daemon_identity.h"
#include "dds/endpoint.h"
#include "dds/gateway_topics.h"
#include "dds/owner_seen.h"
#include "dds/participant.h"
#include "dds/reply_partition.h"

namespace given {

/// A program beside the daemon, in the daemon's own domain: what it writes is in the daemon's readers when the call
/// returns. It dies without a farewell when it is destroyed.
class Program {
 public:
  /// `number`: over 0, of this program alone. `strength`: of its writers, where one writer has a topic.
  Program(const gateway::dds::ParticipantOptions& place, std::uint8_t number, std::int32_t strength)
      : number_(number), strength_(strength), participant_(place) {}

  /// The start of the daemon that it writes to from now on.
  void address(const gateway::dds::DaemonIdentity& daemon) { daemon_ = daemon; }

  /// Writes a sample that one writer alone may write.
  template <class Sample>
  void give(Sample sample) {
    gateway::dds::set_daemon(daemon_, sample);
    std::fill(std::begin(sample.writer), std::end(sample.writer), number_);
    (void)writer<Sample>().write(sample);
  }
  /// As DDS knows its writer of a topic.
  template <class Sample>
  std::array<std::uint8_t, 16> guid() {
    return gateway::dds::guid_of(writer<Sample>());
  }
  /// Asks for something; returns the number of the request. `Reply`: the topic of its one answer.
  template <class Reply, class Request>
  std::uint64_t ask(Request request) {
    (void)reader<Reply>();  // before the request, as every program has it
    gateway::dds::set_daemon(daemon_, request);
    std::fill(std::begin(request.client), std::end(request.client), number_);
    gateway::dds::copy_text("program " + std::to_string(number_), request.client_name);
    request.request = ++requests_;
    // It may find the daemon's reader full.
    constexpr int kTries = 100;
    for (int i = 0; i < kTries && writer<Request>().write(request) != DDS_RETCODE_OK; ++i) {
    }
    return requests_;
  }
  /// Takes a request back.
  void cancel(std::uint64_t request) {
    gateway_JobCancel sample = {};
    gateway::dds::set_daemon(daemon_, sample);
    std::fill(std::begin(sample.client), std::end(sample.client), number_);
    sample.request = request;
    (void)writer<gateway_JobCancel>().write(sample);
  }
  /// The answers that have come since the last call: `take(const Reply&)`.
  template <class Reply, class Take>
  void take_answers(Take&& take) {
    reader<Reply>().take(take);
  }
  /// The samples of a topic of the bus that have come since the last call: `take(const Sample&)`.
  template <class Sample, class Take>
  void take_samples(Take&& take) {
    using Made = gateway::dds::Reader<Sample>;
    made<Made>(ends_, [&] { return std::make_shared<Made>(participant_); }).take(take);
  }
  /// The newest sample of a topic of the bus; all 0 when there is none.
  template <class Sample>
  const Sample& newest() {
    using Made = Newest<Sample>;
    Made& one = made<Made>(ends_, [&] { return std::make_shared<Made>(participant_); });
    one.reader.take([&](const Sample& sample) { one.sample = sample; });
    return one.sample;
  }

  /// So many requests so far.
  std::uint64_t requests() const { return requests_; }

 private:
  template <class Sample>
  struct Newest {
    explicit Newest(const gateway::dds::Participant& participant) : reader(participant) {}
    gateway::dds::Reader<Sample> reader;
    Sample sample = {};  ///< without sequences, which are DDS's own
  };
  template <class Made, class Make>
  Made& made(std::map<std::type_index, std::shared_ptr<void>>& all, Make&& make) {
    std::shared_ptr<void>& one = all[std::type_index(typeid(Made))];
    if (!one) one = make();
    return *static_cast<Made*>(one.get());
  }
  template <class Sample>
  gateway::dds::Writer<Sample>& writer() {
    using Made = gateway::dds::Writer<Sample>;
    return made<Made>(ends_, [&] { return std::make_shared<Made>(participant_, strength_); });
  }
  template <class Reply>
  gateway::dds::Reader<Reply>& reader() {
    using Made = gateway::dds::Reader<Reply>;
    std::array<std::uint8_t, 16> identity;
    identity.fill(number_);
    const std::string& bus = participant_.options().partition;
    return made<Made>(ends_, [&] {
      return std::make_shared<Made>(
          participant_, gateway::dds::Partitions{gateway::dds::reply_partition(bus, identity), bus + "/all"},
          nullptr);
    });
  }

  const std::uint8_t number_;
  const std::int32_t strength_;
  gateway::dds::Participant participant_;
  gateway::dds::DaemonIdentity daemon_ = {};
  std::map<std::type_index, std::shared_ptr<void>> ends_;
  std::uint64_t requests_ = 0;
};

}  // namespace given
