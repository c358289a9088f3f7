#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/DataWriterListener.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>
#include <functional>
#include <mutex>
#include <stdexcept>
#include <string>

/// A bus of the gateway as a program of Fast DDS 2.x sees it: entities with the QoS that docs/dds-api.md asks
/// for.
namespace fastdds_client {

namespace fast = eprosima::fastdds::dds;

/// How long anything may take before the test has failed.
constexpr std::chrono::seconds kLong{120};

/// Wakes whoever waits, when any endpoint has news.
class News : public fast::DataReaderListener, public fast::DataWriterListener {
 public:
  void on_data_available(fast::DataReader* /*reader*/) override { raise(); }
  void on_subscription_matched(fast::DataReader* /*reader*/,
                               const fast::SubscriptionMatchedStatus& /*status*/) override {
    raise();
  }
  void on_publication_matched(fast::DataWriter* /*writer*/,
                              const fast::PublicationMatchedStatus& /*status*/) override {
    raise();
  }

  /// Waits until `condition` holds; throws, with `what`, when that takes too long.
  void wait(const std::string& what, const std::function<bool()>& condition) {
    const auto end = std::chrono::steady_clock::now() + kLong;
    std::unique_lock lock(mutex_);
    while (true) {
      const std::uint64_t seen = raised_;
      lock.unlock();
      const bool holds = condition();
      lock.lock();
      if (holds) return;
      if (!changed_.wait_until(lock, end, [&] { return raised_ != seen; }))
        throw std::runtime_error("not in time: " + what);
    }
  }

 private:
  void raise() {
    {
      const std::lock_guard lock(mutex_);
      ++raised_;
    }
    changed_.notify_all();
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  std::uint64_t raised_ = 0;
};

/// Participant, publisher and subscriber in the partition of one bus. The transport is that of the profile
/// (FASTRTPS_DEFAULT_PROFILES_FILE).
class Bus {
 public:
  /// `replies`: the partition of this client's replies.
  Bus(std::uint32_t domain, const std::string& bus, const std::string& replies) {
    auto* factory = fast::DomainParticipantFactory::get_instance();
    factory->load_profiles();
    participant_ = factory->create_participant(domain, factory->get_default_participant_qos());
    if (participant_ == nullptr) throw std::runtime_error("no participant");
    fast::PublisherQos out;
    out.partition().push_back(bus.c_str());
    publisher_ = participant_->create_publisher(out);
    fast::SubscriberQos in;
    in.partition().push_back(bus.c_str());
    in.partition().push_back(replies.c_str());
    subscriber_ = participant_->create_subscriber(in);
  }
  Bus(const Bus&) = delete;
  Bus& operator=(const Bus&) = delete;
  ~Bus() {
    participant_->delete_contained_entities();
    fast::DomainParticipantFactory::get_instance()->delete_participant(participant_);
  }

  News& news() { return news_; }
  fast::Publisher* publisher() { return publisher_; }
  fast::Subscriber* subscriber() { return subscriber_; }

  /// The topic of that name, of the type that fastddsgen generated.
  template <class Type>
  fast::Topic* topic(const std::string& name) {
    const fast::TypeSupport type(new Type());
    type.register_type(participant_);
    return participant_->create_topic(name, type.get_type_name(), fast::TOPIC_QOS_DEFAULT);
  }

 private:
  News news_;
  fast::DomainParticipant* participant_ = nullptr;
  fast::Publisher* publisher_ = nullptr;
  fast::Subscriber* subscriber_ = nullptr;
};

/// What is: the last sample of each key.
inline fast::DataReaderQos state_reader() {
  fast::DataReaderQos qos;
  qos.reliability().kind = fast::RELIABLE_RELIABILITY_QOS;
  qos.durability().kind = fast::TRANSIENT_LOCAL_DURABILITY_QOS;
  qos.history().kind = fast::KEEP_LAST_HISTORY_QOS;
  qos.history().depth = 1;
  qos.resource_limits().max_instances = 64;  // the default is 10: of 32 slaves only 10 would be seen
  qos.resource_limits().max_samples_per_instance = 1;
  qos.resource_limits().max_samples = 64;
  return qos;
}

/// Replies: every one.
inline fast::DataReaderQos reply_reader() {
  fast::DataReaderQos qos;
  qos.reliability().kind = fast::RELIABLE_RELIABILITY_QOS;
  qos.history().kind = fast::KEEP_ALL_HISTORY_QOS;
  qos.resource_limits().max_instances = 64;
  qos.resource_limits().max_samples_per_instance = 64;
  qos.resource_limits().max_samples = 64 * 64;
  qos.resource_limits().allocated_samples = 1;
  return qos;
}

/// What only counts while it is new.
inline fast::DataReaderQos latest_reader() {
  fast::DataReaderQos qos;
  qos.resource_limits().max_instances = 64;
  qos.resource_limits().max_samples_per_instance = 1;
  qos.resource_limits().max_samples = 64;
  return qos;
}

/// Requests. The acknowledgement is asked for soon, or the room for those that are not acknowledged ends.
inline fast::DataWriterQos request_writer() {
  fast::DataWriterQos qos;
  qos.reliability().kind = fast::RELIABLE_RELIABILITY_QOS;
  qos.durability().kind = fast::VOLATILE_DURABILITY_QOS;
  qos.history().kind = fast::KEEP_ALL_HISTORY_QOS;
  qos.resource_limits().allocated_samples = 1;
  qos.reliable_writer_qos().times.heartbeatPeriod = {0, 100'000'000};
  return qos;
}

/// Reference values: a telegram has one writer at a time, which a stronger one displaces.
inline fast::DataWriterQos reference_writer(std::uint32_t strength, const std::string& name) {
  fast::DataWriterQos qos;
  qos.reliability().kind = fast::RELIABLE_RELIABILITY_QOS;
  qos.durability().kind = fast::VOLATILE_DURABILITY_QOS;
  qos.history().kind = fast::KEEP_LAST_HISTORY_QOS;
  qos.history().depth = 16;
  qos.ownership_strength().value = strength;
  qos.liveliness().kind = fast::AUTOMATIC_LIVELINESS_QOS;
  qos.liveliness().lease_duration = {0, 500'000'000};
  qos.liveliness().announcement_period = {0, 200'000'000};
  qos.writer_data_lifecycle().autodispose_unregistered_instances = false;
  qos.user_data().assign(name.begin(), name.end());
  return qos;
}

template <class T, class Type>
class Reader {
 public:
  Reader(Bus& bus, const std::string& name, const fast::DataReaderQos& qos)
      : reader_(bus.subscriber()->create_datareader(bus.topic<Type>(name), qos, &bus.news())) {
    if (reader_ == nullptr) throw std::runtime_error("no reader of " + name);
  }
  /// The next sample with data; false: there is none.
  bool take(T& sample) {
    fast::SampleInfo info;
    while (reader_->take_next_sample(&sample, &info) == ReturnCode_t::RETCODE_OK) {
      if (info.valid_data) return true;
    }
    return false;
  }
  bool matched() const {
    fast::SubscriptionMatchedStatus status;
    reader_->get_subscription_matched_status(status);
    return status.current_count > 0;
  }

 private:
  fast::DataReader* reader_;
};

template <class T, class Type>
class Writer {
 public:
  Writer(Bus& bus, const std::string& name, const fast::DataWriterQos& qos)
      : writer_(bus.publisher()->create_datawriter(bus.topic<Type>(name), qos, &bus.news())), name_(name) {
    if (writer_ == nullptr) throw std::runtime_error("no writer of " + name);
  }
  void write(T& sample) {
    if (!writer_->write(&sample)) throw std::runtime_error("not written: " + name_);
  }
  bool matched() const {
    fast::PublicationMatchedStatus status;
    writer_->get_publication_matched_status(status);
    return status.current_count > 0;
  }
  std::array<std::uint8_t, 16> guid() const {
    std::array<std::uint8_t, 16> out = {};
    const auto& guid = writer_->guid();
    std::copy_n(guid.guidPrefix.value, 12, out.begin());
    std::copy_n(guid.entityId.value, 4, out.begin() + 12);
    return out;
  }

 private:
  fast::DataWriter* writer_;
  std::string name_;
};

}  // namespace fastdds_client
