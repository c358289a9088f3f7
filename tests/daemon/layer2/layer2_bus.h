#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "can/flagged_frames.h"
#include "daemon/layer2/segment/layer2_segment.h"
#include "layer2/client/frame_client.h"
#include "layer2/dds/convert.h"
#include "support/dds_places.h"
#include "support/kept_journal.h"
#include "support/long_wait.h"

namespace cansyncd {

/// Two nodes: one answers remote frames, one sends by itself; and one that no range takes.
inline Layer2File file_for(const TwoPlaces& places) {
  using can::test::data_frame;
  using can::test::extended;
  using std::chrono::milliseconds;
  Layer2File file;
  Layer2Config& config = file.config;
  config.bus.name = places.here.partition;
  config.bus.bits_per_second = 500'000;
  config.dds.domain = places.here.domain;
  config.dds.partition = places.here.partition;
  config.dds.request_max_age = milliseconds(0);  // the computer may be slow
  config.realtime.priority = 0;
  config.realtime.lock_memory = false;
  config.recorder.folder = "";
  // The monitoring time is the simulated bus's, which runs in real time, on a computer that may be slow.
  config.send.timeout = std::chrono::seconds(20);
  config.receive = {{0x100, 0x1FF, false, layer2::FrameKinds::data_and_remote},
                    {0, 0x1FFFFFFF, true, layer2::FrameKinds::data}};
  config.nodes = {{0, extended(data_frame(0x18DAF110, {1, 2, 3})), milliseconds(0)},
                  {1, data_frame(0x150, {0, 9}), milliseconds(20)},
                  {2, data_frame(0x250, {0}), milliseconds(5)}};
  return file;
}

inline layer2::client::Options options_for(const TwoPlaces& places) {
  layer2::client::Options options;
  options.domain = places.there.domain;
  options.bus = places.there.partition;
  options.xml = places.there.xml;
  options.client_name = "tester";
  options.wait = gateway::kLongWait;
  return options;
}

/// A bus of general frames with a client.
class Layer2BusTest : public testing::Test {
 protected:
  void start(Layer2File file) {
    segment_.emplace(std::move(file), journal_, gateway::dds::Participant(places_.here));
    segment_->start();
    client_.emplace(options_for(places_));
  }
  void start() { start(file_for(places_)); }
  /// Asks again and again, at most `kLongWait`.
  template <class Check>
  static bool comes_true(const Check& check) {
    const auto end = std::chrono::steady_clock::now() + gateway::kLongWait;
    while (!check()) {
      if (std::chrono::steady_clock::now() >= end) return false;
    }
    return true;
  }
  /// Takes frames until one fits.
  template <class Fits>
  bool comes(const Fits& fits) {
    bool found = false;
    return comes_true([&] {
      client_->receive(std::chrono::milliseconds(100), [&](const layer2_FrameBatch& batch) {
        EXPECT_GT(batch.number, number_);
        number_ = batch.number;
        for (std::uint32_t i = 0; i < batch.frames._length; ++i) {
          seen_.push_back(batch.frames._buffer[i]);
          found = found || fits(layer2::dds::to_core(seen_.back().received), seen_.back());
        }
      });
      return found;
    });
  }

  TwoPlaces places_{"layer2bus"};
  KeptJournal journal_;
  std::optional<Layer2Segment> segment_;
  std::optional<layer2::client::FrameClient> client_;
  std::uint64_t number_ = 0;
  std::vector<layer2_ReceivedFrame> seen_;
};

}  // namespace cansyncd
