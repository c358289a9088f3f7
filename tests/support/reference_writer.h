#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <iterator>
#include <optional>
#include <string_view>

#include "cansync.h"
#include "cansync/dds/topics.h"
#include "dds/endpoint.h"
#include "dds/owner_seen.h"
#include "gateway_rig.h"
#include "support/dds_places.h"

namespace cansyncd {

inline cansync_ReferenceValues values(std::uint8_t telegram, std::int32_t first) {
  cansync_ReferenceValues sample = {};
  sample.telegram = telegram;
  sample.value[0] = first;
  sample.value[3] = -4;
  sample.valid = 0b1001;
  sample.release_intervals = 20;
  std::copy(kTestDaemon.begin(), kTestDaemon.end(), std::begin(sample.daemon));
  sample.mapping_number = 1;
  return sample;
}

/// A writer of reference values in a process of its own, as far as DDS can tell, or on a participant that others
/// share.
class ReferenceWriter {
 public:
  ReferenceWriter(TwoPlaces& places, std::int32_t strength, std::string_view name = {})
      : participant_(std::in_place, places.there), writer_(*participant_, strength, &signal_, name) {
    EXPECT_TRUE(eventually(signal_, [this] { return writer_.matched() > 0; }));
  }
  ReferenceWriter(const gateway::dds::Participant& participant, std::int32_t strength)
      : writer_(participant, strength, &signal_) {
    EXPECT_TRUE(eventually(signal_, [this] { return writer_.matched() > 0; }));
  }
  ReferenceWriter(GatewayRig& rig, std::int32_t strength) : ReferenceWriter(rig.places(), strength) {}

  void write(cansync_ReferenceValues sample) {
    gateway::dds::set_writer(writer_, sample);
    ASSERT_EQ(writer_.write(sample), DDS_RETCODE_OK);
  }
  /// As if it had been on its way, or its reader suspended, for so long.
  void write_late(cansync_ReferenceValues sample, dds_duration_t age) {
    gateway::dds::set_writer(writer_, sample);
    ASSERT_EQ(dds_write_ts(writer_.handle(), &sample, dds_time() - age), DDS_RETCODE_OK);
  }
  /// Writes, and waits until the gateway's reader has it.
  void deliver(const cansync_ReferenceValues& sample) {
    write(sample);
    ASSERT_EQ(dds_wait_for_acks(writer_.handle(), DDS_SECS(20)), DDS_RETCODE_OK);
  }
  /// Says that the telegram is given up and no longer writes it; waits until the gateway's reader knows.
  void give_up(std::uint8_t telegram) {
    cansync_ReferenceValues sample = {};
    sample.telegram = telegram;
    sample.given_up = true;
    write(sample);
    unregister(sample);
    ASSERT_EQ(dds_wait_for_acks(writer_.handle(), DDS_SECS(20)), DDS_RETCODE_OK);
  }
  void unregister(cansync_ReferenceValues sample) {
    gateway::dds::set_writer(writer_, sample);
    ASSERT_EQ(writer_.unregister(sample), DDS_RETCODE_OK);
  }

  std::array<std::uint8_t, 16> guid() const { return gateway::dds::guid_of(writer_); }

 private:
  std::optional<gateway::dds::Participant> participant_;
  gateway::dds::DataSignal signal_;
  gateway::dds::Writer<cansync_ReferenceValues> writer_;
};

/// The first event with this code; nothing when none comes.
inline std::optional<gateway_Event> event(GatewayRig& rig, std::string_view code) {
  return rig.client.wait_for<gateway_Event>(
      [&](const auto& e) { return gateway::dds::text(e.code) == code; });
}

}  // namespace cansyncd
