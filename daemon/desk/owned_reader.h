#pragma once

#include <dds/dds.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <utility>
#include <vector>

#include "daemon/desk/gateway_events.h"
#include "daemon/desk/writer_arbiter.h"
#include "daemon/desk/writer_watch.h"
#include "dds/endpoint.h"
#include "dds/guard/owner_guard.h"
#include "dds/participant.h"
#include "dds/signal.h"
#include "text/counts.h"

namespace cansyncd {

/// A sample of a writer that waits was refused; told on the change.
inline void tell_waiting(EventPublisher& events, WriterArbiter& arbiter, const TopicWriter& writer,
                         SteadyTime now) {
  std::string text = arbiter.refuse(writer);
  if (text.empty()) return;
  EventText event{gateway_SEVERITY_WARNING, "writer_waits", -1, std::move(text), std::nullopt};
  event.client = writer.identity.who;
  events.publish(event, now);
}

/// Reads a topic that one writer has at a time, and finds which writers have ended. Who has it a WriterArbiter
/// decides for each thing that can be had: the telegrams, numbered from 0, or the topic as a whole (0).
/// Gateway thread only.
template <class Sample>
class OwnedReader {
 public:
  /// Both must outlive the object. Throws gateway::dds::SetupError.
  OwnedReader(const gateway::dds::Participant& participant, gateway::dds::DataSignal& signal)
      : guard_(signal), reader_(participant, &signal, &guard_), writers_(participant, reader_) {}

  /// Takes what has come. `number(sample)`: of the thing that the sample is for. `gives_up(sample)`: its writer
  /// ends with it, which counts also when nothing of that writer lives any more. `take(sample, info)`: one that
  /// counts. True: there may be more.
  template <class Number, class GivesUp, class Take>
  bool take(Number&& number, GivesUp&& gives_up, Take&& take) {
    ended_.clear();
    const auto count = reader_.take_batch([&](const Sample& sample, const dds_sample_info_t& info) {
      const bool last = info.valid_data && gives_up(sample);
      // Also with data: what a writer has given that has gone meanwhile counts no more. Looked at after the
      // batch, because the sample that gives up may still come.
      if (info.instance_state != DDS_IST_ALIVE && !last) {
        ended_.push_back({number(sample), key_of(sample)});
      } else if (info.valid_data) {
        take(sample, info);
      }
    });
    changed_ = writers_.look();
    if (changed_) guard_.keep(writers_.living());
    return count == gateway::dds::ReaderBase::kBatch;
  }

  /// After `take`: has the owner left, died, or given its key back? Who waits and did so is forgotten.
  bool lost(unsigned number, WriterArbiter& arbiter) const {
    const TopicWriter& owner = arbiter.owner();
    bool lost = false;
    for (const Ended& ended : ended_) {
      if (ended.number != number) continue;
      lost = lost || (owner.handle != 0 && owner.key == ended.key);
      arbiter.forget_key(ended.key);
    }
    if (!changed_) return lost;
    arbiter.forget_if([&](WriterHandle writer) { return writers_.left(writer); });
    return lost || (owner.handle != 0 && writers_.gone(owner.handle, owner.key == WriterKey{}));
  }

  /// The writer of a sample.
  TopicWriter writer_of(const Sample& sample, WriterHandle writer) {
    return {writer, key_of(sample), writers_.identify(writer)};
  }
  /// Has the writer left?
  bool left(WriterHandle writer) const { return writers_.left(writer); }
  const gateway::dds::WriterIdentity& identify(WriterHandle writer) { return writers_.identify(writer); }

  static WriterKey key_of(const Sample& sample) {
    WriterKey key;
    std::copy(std::begin(sample.writer), std::end(sample.writer), key.begin());
    return key;
  }

  /// Tells of samples that were dropped unread, once for each row of them.
  void tell_dropped(EventPublisher& events, SteadyTime now) {
    const std::uint64_t dropped = guard_.take_dropped();
    (void)dropped_.take_over(now);
    if (!dropped_.add(dropped, now)) return;
    events.publish({gateway_SEVERITY_WARNING, "writer_waits", -1,
                    fmt::format("topic {}: {} dropped unread: one writer may use {} keys, all together {}",
                                gateway::dds::topic_info<Sample>.name,
                                text::counted(dropped, "sample was", "samples were"),
                                gateway::dds::OwnerGuard::kKeysPerWriter, gateway::dds::OwnerGuard::kKeys),
                    std::nullopt},
                   now);
  }

 private:
  struct Ended {
    unsigned number = 0;
    WriterKey key = {};
  };

  static constexpr std::chrono::seconds kQuiet{1};

  gateway::dds::OwnerGuard guard_;
  gateway::dds::Reader<Sample> reader_;
  WriterWatch writers_;
  std::vector<Ended> ended_;  ///< in the batch that was taken, at most as many as that has samples
  bool changed_ = false;
  FaultRow dropped_{kQuiet};
};

}  // namespace cansyncd
