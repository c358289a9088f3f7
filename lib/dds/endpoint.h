#pragma once

#include <dds/dds.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "dds/entity.h"
#include "dds/guard/topic_guard.h"
#include "dds/participant.h"
#include "dds/signal.h"
#include "dds/topic.h"

namespace gateway::dds {

/// Partitions of an endpoint that is not in that of its participant's bus.
using Partitions = std::vector<std::string>;

/// A topic and its reader or writer, without the type. When its participant moves, it is made anew there: its
/// handle changes.
class EndpointBase {
 public:
  dds_entity_t handle() const noexcept { return made_->entities.endpoint.get(); }

  /// How many readers (of a writer) or writers (of a reader) are matched now, as DDS told last. Never waits:
  /// asking DDS would wait for a write in progress.
  std::uint32_t matched() const noexcept { return made_->matches.count; }

 protected:
  /// What the listener of an endpoint knows.
  struct Matches {
    DataSignal* signal = nullptr;
    std::atomic<std::uint32_t> count{0};
    void raise() const noexcept {
      if (signal != nullptr) signal->raise();
    }
  };

  /// What it is for DDS.
  struct Entities {
    Entity topic;  // declared first: the endpoint goes before its topic
    Entity group;  // publisher or subscriber of an endpoint with partitions of its own
    Entity endpoint;
  };

  /// How it is made at a participant; throws SetupError.
  using Make = std::function<Entities(const Participant& participant, Matches& matches)>;

  /// Throws SetupError.
  EndpointBase(const Participant& participant, DataSignal* signal, Make make);

 private:
  /// Keeps its place while the endpoint moves.
  class Made final : public Movable {
   public:
    Made(const Participant& participant, DataSignal* signal, Make make);
    ~Made() override;
    Made(const Made&) = delete;
    Made& operator=(const Made&) = delete;
    void move_to(const Participant& participant, std::list<Entity>& left) override;

    Matches matches;  // declared before what its listener writes to it
    Entities entities;

   private:
    const Make make_;
    const std::shared_ptr<Movables> movables_;
  };

  std::unique_ptr<Made> made_;
};

/// Reader without the type.
class ReaderBase : public EndpointBase {
 public:
  /// Samples taken at a time, and places of every array that samples are lent to: Cyclone fills as many as
  /// the reader's largest loan so far had, whatever is asked. More than a reader of requests keeps of one
  /// client, so that the next call gets to another.
  static constexpr dds_return_t kBatch = 128;

 protected:
  /// Throws SetupError. `signal` is raised when data arrives or a writer comes, goes or dies. `guard`, if
  /// there is one, bounds the keys and must outlive the reader.
  ReaderBase(const Participant& participant, const TopicInfo& info, DataSignal* signal, TopicGuard* guard,
             const Partitions& partitions);

 private:
  static Entities make_reader(const Participant& participant, const TopicInfo& info, TopicGuard* guard,
                              const Partitions& partitions, Matches& matches);
};

/// Reads one topic. Entities are thread safe in Cyclone; take from one thread at a time.
template <class T>
class Reader : public ReaderBase {
 public:
  /// Creates the topic and a reader with the table's QoS. `signal` and `guard` (nullptr: none) must outlive
  /// the reader. Throws SetupError.
  explicit Reader(const Participant& participant, DataSignal* signal = nullptr, TopicGuard* guard = nullptr)
      : ReaderBase(participant, topic_info<T>, signal, guard, {}) {}
  /// In other partitions than that of the bus.
  Reader(const Participant& participant, const Partitions& partitions, DataSignal* signal)
      : ReaderBase(participant, topic_info<T>, signal, nullptr, partitions) {}
  /// Of another topic of the same type.
  Reader(const Participant& participant, const TopicInfo& topic, DataSignal* signal,
         TopicGuard* guard = nullptr)
      : ReaderBase(participant, topic, signal, guard, {}) {}

  /// Takes the oldest samples in order with their information (who wrote it, when, and whether it is data or
  /// tells that the key's last writer is gone): `on_sample(const T&, const dds_sample_info_t&)`. Samples are
  /// Cyclone's own (no copy) and valid during the call only. Returns their number, `kBatch` at most, because
  /// a writer that never rests must not hold up the rest (so many: there may be more), or a negative DDS
  /// return code.
  template <class OnSample>
  dds_return_t take_batch(OnSample&& on_sample) {
    return take_loan([&](const T& sample, const dds_sample_info_t& info, bool /*is_last_of_key*/) {
      on_sample(sample, info);
    });
  }

  /// Takes every sample there is, in order: `on_data(const T&)` for data, `on_gone(const T&)` (its key fields
  /// alone mean something) when a key's last writer is dead, has left or has disposed of it. Samples are valid
  /// during the call only. Returns the number of samples, or a negative DDS return code.
  template <class OnData, class OnGone>
  dds_return_t take(OnData&& on_data, OnGone&& on_gone) {
    dds_return_t total = 0;
    for (;;) {
      const dds_return_t count =
          take_loan([&](const T& sample, const dds_sample_info_t& info, bool is_last_of_key) {
            if (info.valid_data) on_data(sample);
            // Cyclone has no sample for it while data of the key waits: the state of that data tells.
            if (is_last_of_key && info.instance_state != DDS_IST_ALIVE) on_gone(sample);
          });
      if (count < 0) return count;
      if (count == 0) return total;
      total += count;
    }
  }
  template <class OnData>
  dds_return_t take(OnData&& on_data) {
    return take(std::forward<OnData>(on_data), [](const T&) {});
  }

 private:
  /// Returns the loan also when a callback throws.
  struct Loan {
    dds_entity_t reader;
    void** samples;
    std::int32_t count;
    ~Loan() { (void)dds_return_loan(reader, samples, count); }
  };

  /// As `take_batch`; `on_sample` is told, too, whether it is the last sample of its key in the batch.
  template <class OnSample>
  dds_return_t take_loan(OnSample&& on_sample) {
    std::array<void*, kBatch> samples = {};
    std::array<dds_sample_info_t, kBatch> infos;
    const dds_return_t taken = dds_take(handle(), samples.data(), infos.data(), kBatch, kBatch);
    if (taken <= 0) return taken;
    const Loan loan{handle(), samples.data(), taken};
    const auto count = static_cast<std::size_t>(taken);
    for (std::size_t i = 0; i < count; ++i) {
      const bool is_last_of_key = i + 1 == count || infos[i + 1].instance_handle != infos[i].instance_handle;
      on_sample(*static_cast<const T*>(samples[i]), infos[i], is_last_of_key);
    }
    return taken;
  }
};

/// Writer without the type.
class WriterBase : public EndpointBase {
 public:
  /// False: with DDS Security on, the identity has no right to write the topic; every write fails with
  /// DDS_RETCODE_NOT_ALLOWED_BY_SECURITY.
  bool permitted() const noexcept { return static_cast<bool>(handle() > 0); }

 protected:
  /// Throws SetupError. `signal` is raised when a reader comes or goes.
  WriterBase(const Participant& participant, const TopicInfo& info, std::int32_t strength, DataSignal* signal,
             std::string_view name, const Partitions& partitions);

 private:
  static Entities make_writer(const Participant& participant, const TopicInfo& info, std::int32_t strength,
                              const std::string& name, const Partitions& partitions, Matches& matches);
};

/// Writes one topic. Any thread may write.
template <class T>
class Writer : public WriterBase {
 public:
  /// Creates the topic and a writer with the table's QoS. `strength`: where one writer has
  /// the topic, a stronger one takes it over. `signal` (nullptr: none) is raised when a reader comes or goes. `name`:
  /// what readers are told of who writes; may be empty. Throws SetupError.
  explicit Writer(const Participant& participant, std::int32_t strength = 0, DataSignal* signal = nullptr,
                  std::string_view name = {})
      : WriterBase(participant, topic_info<T>, strength, signal, name, {}) {}
  /// In other partitions than that of the bus.
  Writer(const Participant& participant, const Partitions& partitions, DataSignal* signal)
      : WriterBase(participant, topic_info<T>, 0, signal, {}, partitions) {}
  /// Of another topic of the same type.
  Writer(const Participant& participant, const TopicInfo& topic, DataSignal* signal)
      : WriterBase(participant, topic, 0, signal, {}, {}) {}

  /// Writes one sample. DDS_RETCODE_OK, or DDS_RETCODE_TIMEOUT when a reliable reader did not take earlier
  /// samples within the topic's blocking time (nothing was written; try again), or another negative code. May
  /// block for that time.
  dds_return_t write(const T& sample) noexcept {
    return permitted() ? dds_write(handle(), &sample) : DDS_RETCODE_NOT_ALLOWED_BY_SECURITY;
  }

  /// Says that this writer no longer writes the sample's key; readers see it gone when it was the last
  /// writer.
  dds_return_t unregister(const T& sample) noexcept { return dds_unregister_instance(handle(), &sample); }

  /// Removes the sample's key: late readers no longer get it.
  dds_return_t dispose(const T& sample) noexcept { return dds_dispose(handle(), &sample); }
};

}  // namespace gateway::dds
