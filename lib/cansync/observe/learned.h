#pragma once

#include <array>
#include <cstdint>

#include "cansync/observe/observation.h"
#include "cansync/settings/settings.h"

namespace cansync::observe {

/// How a point is known.
enum class Certainty : std::uint8_t {
  not_seen,  ///< the recording tells nothing of it
  inferred,  ///< it fits everything on the recording, and other readings would, too
  seen,      ///< it stood on the bus
};

/// A point, how it is known, and how often what tells it was on the recording.
template <class T>
struct Found {
  T value{};
  Certainty certainty = Certainty::not_seen;
  std::uint64_t count = 0;  ///< telegrams or edges that tell it; 0: none
  /// True when the recording tells something of it.
  bool known() const noexcept { return certainty != Certainty::not_seen; }
};

/// The action that puts slaves into SYNC mode.
struct Activation {
  std::uint8_t command = 0;  ///< 2..255
  std::uint8_t data = 0;     ///< 0..255, the data byte
  friend bool operator==(const Activation&, const Activation&) = default;
};

/// What is learned of one slave.
struct LearnedSlave {
  Found<std::uint16_t> status_parameter;
  Found<std::uint16_t> block_limit;
  std::array<Found<TelegramMapping>, kChannels> actual_mapping = {};
};

/// What a recording tells of the settings of its master.
struct Learned {
  Found<Duration> interval;
  Found<BitRate> bit_rate;
  Found<Duration> send_margin;
  Found<SlaveMask> slaves;    ///< that answered, or were sent commands
  Found<SlaveMask> answered;  ///< of those
  std::array<Found<Cursor>, kChannels> polling = {};
  Found<SlaveNumber> maximum_slave;
  Found<bool> polling_apart;
  Found<std::uint8_t> poll_nobody;
  Found<bool> full_length;
  Found<bool> poll_without_reference;
  std::array<Found<TelegramMapping>, kChannels> reference_mapping = {};
  std::array<NumberRange, kValues> reference_range = {};  ///< by this mapping; count 0: none came
  Found<Activation> activation;
  Found<Duration> status_period;
  Found<EnableRule> enable;
  Found<Serving> serving;
  Found<std::uint8_t> address_step;
  Found<bool> cancel_at_start;
  Found<bool> repeat_unanswered_writes;
  Found<bool> allow_reserved_addresses;
  std::array<LearnedSlave, kSlaves> slave = {};
};

/// What the recording tells. Pure.
Learned learn(const Observation& observation);

/// Settings of a master that does the same, our defaults where the recording tells nothing. Pure.
MasterSettings settings_of(const Learned& learned);

/// The parts of `learn`. Pure; each fills its own members.
void learn_process_data(const Observation& observation, Learned& out);
/// Activation, status words and the command channel.
void learn_commands(const Observation& observation, Learned& out);

}  // namespace cansync::observe
