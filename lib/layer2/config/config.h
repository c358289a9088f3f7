#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "can/frame.h"
#include "daemon_config/daemon_config.h"
#include "layer2/module.h"

/// The whole configuration of a bus of general frames: plain values. `file.h` reads it from a TOML file. Not
/// for the realtime thread.
namespace cansyncd {

/// Sending.
struct SendConfig {
  std::uint16_t queue = 400;      ///< requests of normal priority that may wait, 1..1024
  std::uint16_t high_queue = 20;  ///< likewise, of high priority
  layer2::Overflow overflow = layer2::Overflow::refuse_newest;
  std::chrono::milliseconds timeout{1000};  ///< monitoring time of requests that name none, 1..3'600'000
};

/// Queues of received frames.
struct QueueConfig {
  std::uint16_t receive = 400;      ///< frames that may wait, 1..1024
  std::uint16_t receive_high = 20;  ///< likewise, of high priority
  layer2::Overflow overflow = layer2::Overflow::delete_oldest;
};

/// One timer.
struct TimerConfig {
  unsigned number = 1;  ///< 1..16
  layer2::TimerSettings timer;
};

/// What becomes of the image that is sent when its writer has gone.
enum class WriterLost : std::uint8_t { hold, zero, stop_sending };

/// One message object.
struct ObjectConfig {
  std::uint8_t number = 0;  ///< 0..31
  layer2::ObjectSettings settings;
};

/// The scripts, as they stand in the file: a line each.
struct ScriptConfig {
  layer2::ScriptRules rules;
  std::vector<std::string> power_on;
  std::vector<std::string> run;
  std::vector<std::string> stop;
};

/// The lines as one text, read. Its problems say the line.
layer2::Script read_script(const std::vector<std::string>& lines, const layer2::ScriptRules& rules);

/// A simulated node; looked at only with `BusKind::simulated`.
struct SimNodeConfig {
  unsigned number = 0;                  ///< 0..31
  can::Frame frame;                     ///< a data frame
  std::chrono::milliseconds period{0};  ///< between two of them; 0: sent as the answer to remote frames
};

/// Everything.
struct Layer2Config : DaemonConfig {
  /// What no option of a file says otherwise.
  Layer2Config() {
    bus.bits_per_second = 500'000;
    bus.sample_point = 0;
    // Frames of other nodes begin at any time: in one-shot mode the weaker is lost.
    bus.one_shot = OneShot::ignore;
  }

  std::vector<layer2::ReceiveRange> receive;  ///< by number, at most RangeFilter::kMostRanges, all in order
  std::uint8_t node_filter = 0;               ///< 1..127: in place of `receive`; 0: none
  bool node_filter_extended = false;
  bool starts_in_run = true;
  std::string run_follows;  ///< name of the program whose life run and stop follow; empty: none
  SendConfig send;
  QueueConfig queues;
  std::vector<TimerConfig> timers;    ///< by number, each once
  std::vector<ObjectConfig> objects;  ///< by number, each once
  layer2::WindowSettings window;
  ScriptConfig script;
  layer2::MappingSettings mapping;
  WriterLost writer_lost = WriterLost::stop_sending;
  std::vector<layer2::MappedBytes> mapped;  ///< by number
  std::vector<SimNodeConfig> nodes;         ///< by number, each once
};

}  // namespace cansyncd
