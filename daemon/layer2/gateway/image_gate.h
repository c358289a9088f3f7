#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "daemon/desk/gateway_events.h"
#include "daemon/desk/owned_reader.h"
#include "daemon/desk/writer_arbiter.h"
#include "daemon/layer2/exchange.h"
#include "daemon/service/daemon_identity.h"
#include "dds/denial.h"
#include "layer2.h"
#include "layer2/config/config.h"

namespace cansyncd {

/// The process image that is sent: who owns it, what is in it, and what becomes of it when its owner has gone.
/// Gateway thread only.
///
/// The owner is the writer of ImageOutputs that has it (WriterArbiter); while there is one, nobody else writes. It begins
/// with bytes that are all 0. Nothing is sent until somebody has written, also after another table was taken. Owner or
/// not, the realtime thread has all of a change or nothing of it between two telegrams.
class ImageGate {
 public:
  /// A row of refused samples is over when none was refused for so long.
  static constexpr std::chrono::seconds kQuiet{1};

  /// `daemon`: this start, which samples must name. All must outlive the gate. Throws
  /// gateway::dds::SetupError.
  ImageGate(const gateway::dds::Participant& participant, gateway::dds::DataSignal& signal,
            EventPublisher& events, const DaemonIdentity& daemon, Layer2Exchange& exchange);

  /// What of the configuration counts.
  struct Rules {
    bool mapped = false;     ///< there is an image
    bool read_only = false;  ///< nobody writes it
    WriterLost lost = WriterLost::hold;
  };
  /// Whoever has given the image counts as gone while it is read-only.
  void set_rules(const Rules& rules, SteadyTime now);
  /// Another table was taken: the image begins anew, and whoever owns it has to write it anew, which is told.
  void begin_anew(SteadyTime now);
  /// Tables taken so far.
  std::uint32_t table() const noexcept { return image_.table; }

  /// Takes what has come, and looks whether the owner is gone. True: there may be more.
  bool take_samples(SteadyTime now);
  /// Tells of refusals that are over. Returns when to call again; nothing: no need.
  std::optional<SteadyTime> tick(SteadyTime now);

  /// A request writes; while nothing is sent, it begins with bytes that are all 0. Returned is the table of the image;
  /// nothing: there is no image, it is read-only or has an owner, and nothing has changed.
  std::optional<std::uint32_t> write(std::uint16_t address, std::span<const std::uint8_t> bytes);

  /// The owner, as it names itself; empty: none.
  const std::string& owner() const noexcept { return arbiter_.owner().identity.who; }
  /// Who has the image, and who waits for it.
  const WriterArbiter& arbiter() const noexcept { return arbiter_; }
  /// The image is sent.
  bool sending() const noexcept { return image_.sending; }

 private:
  void take(const layer2_ImageOutputs& sample, WriterHandle writer, SteadyTime now);
  gateway::dds::Problem problem_of(const layer2_ImageOutputs& sample) const;
  void give_to(const TopicWriter& writer, SteadyTime now);
  void gone(gateway_EventSeverity severity, EventCode code, std::string_view how, SteadyTime now);

  OwnedReader<layer2_ImageOutputs> reader_;
  WriterArbiter arbiter_{"the image that is sent"};
  EventPublisher& events_;
  const DaemonIdentity daemon_;
  Layer2Exchange& exchange_;
  Rules rules_;
  OutputImage image_;
  bool changed_ = false;  ///< since it was handed on
  FaultRow refusals_{kQuiet};
};

}  // namespace cansyncd
