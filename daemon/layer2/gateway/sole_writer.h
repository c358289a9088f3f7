#pragma once

#include <dds/dds.h>

#include <string>
#include <utility>

#include "daemon/desk/writer_watch.h"
#include "dds/endpoint.h"
#include "dds/participant.h"
#include "dds/signal.h"

namespace cansyncd {

/// Reads a topic of exclusive ownership without a key, and knows whose samples count: the strongest living
/// writer's. Gateway thread only.
template <class Sample>
class SoleWriter {
 public:
  using Writer = dds_instance_handle_t;

  /// Both must outlive the object. Throws gateway::dds::SetupError.
  SoleWriter(const gateway::dds::Participant& participant, gateway::dds::DataSignal& signal)
      : reader_(participant, &signal), writers_(participant, reader_.handle()) {}

  /// Takes what has come: `take(sample, writer)`. True: there may be more.
  template <class Take>
  bool take(Take&& take) {
    bool without_writer = false;
    const auto count = reader_.take_batch([&](const Sample& sample, const dds_sample_info_t& info) {
      without_writer = without_writer || info.instance_state != DDS_IST_ALIVE;
      if (info.valid_data) take(sample, info.publication_handle);
    });
    const bool changed = writers_.look();
    gone_ = owner_ != 0 && (without_writer || (changed && writers_.gone(owner_)));
    return count == gateway::dds::ReaderBase::kBatch;
  }

  /// The owner has gone, as the last `take` has found.
  bool gone() const noexcept { return gone_ && owner_ != 0; }
  /// The writer whose samples count; 0: none.
  Writer owner() const noexcept { return owner_; }
  /// As it names itself; empty: none.
  const std::string& name() const noexcept { return name_; }
  /// From now on this one's samples count; 0: nobody's.
  void own(Writer writer) {
    owner_ = writer;
    gone_ = false;
    name_ = writer == 0 ? std::string() : writers_.identify(writer).who;
  }

 private:
  gateway::dds::Reader<Sample> reader_;
  WriterWatch writers_;
  Writer owner_ = 0;
  std::string name_;
  bool gone_ = false;
};

}  // namespace cansyncd
