#pragma once

#include <dds/dds.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "daemon/desk/client_table.h"
#include "daemon/desk/fair_lanes.h"
#include "daemon/desk/gateway_events.h"
#include "daemon/desk/gateway_replies.h"
#include "dds/daemon_identity.h"
#include "dds/endpoint.h"
#include "dds/overview/overview_topics.h"
#include "dds/participant.h"
#include "dds/process_facts.h"
#include "dds/request_key.h"

namespace cansyncd {

/// A request that is open, as others are told of it.
struct OpenRequest {
  JobId id = 0;
  gateway::dds::RequestKey key;
  Place place = {};
  std::string name;       ///< of its client
  std::string text;       ///< what was asked for
  std::int64_t time = 0;  ///< when it was taken, CLOCK_REALTIME in ns
  LaneTurn turn;
  std::uint32_t done = 0;  ///< bytes of a transfer
  std::size_t total = 0;   ///< 0: no transfer
};

/// Publishes who is connected and what is open (topic OpenRequests), at most every `kPeriod`, when something
/// has changed. Gateway thread only.
class OpenRequestsTopic {
 public:
  static constexpr std::chrono::milliseconds kPeriod{250};
  /// Most that one sample tells of each; what is more is counted.
  static constexpr std::size_t kPrograms = 128;
  static constexpr std::size_t kRequests = 64;

  /// Throws gateway::dds::SetupError. `participant` must outlive the object.
  OpenRequestsTopic(const gateway::dds::Participant& participant, const gateway::dds::DaemonIdentity& daemon)
      : participant_(participant), daemon_(daemon), writer_(participant) {}

  /// Programs that read what this writer writes are connected, too, though they ask for nothing.
  /// Must outlive the object.
  void set_read_by_all(const gateway::dds::WriterBase& writer) noexcept { read_by_all_ = &writer; }

  /// There is news.
  void touch() noexcept { changed_ = true; }

  /// May it be told now?
  bool due(SteadyTime now) const noexcept { return has_news() && now >= told_ + kPeriod; }
  /// When it may be at the earliest; nothing: there is no news.
  std::optional<SteadyTime> next() const noexcept {
    return has_news() ? std::optional(told_ + kPeriod) : std::nullopt;
  }

  /// Tells it. `requests`: the oldest of `open`, by rising number, at most `kRequests`.
  void tell(const std::vector<OpenRequest>& requests, std::size_t open, const ClientTable& clients,
            const LivingPlaces& living, SteadyTime now);

 private:
  struct Program {
    std::string name;
    unsigned open = 0;
  };

  bool has_news() const noexcept {
    return changed_ || (read_by_all_ != nullptr && read_by_all_->matched() != readers_told_);
  }
  std::map<Place, Program> programs(const ClientTable& clients, const LivingPlaces& living);
  void add_readers(std::map<Place, Program>& programs) const;
  gateway_ConnectedProgram row(const Place& place, const Program& program);

  const gateway::dds::Participant& participant_;
  const gateway::dds::DaemonIdentity daemon_;
  gateway::dds::Writer<gateway_OpenRequests> writer_;
  const gateway::dds::WriterBase* read_by_all_ = nullptr;
  std::uint32_t readers_told_ = 0;                     ///< of it, when that was told last
  std::map<Place, gateway::dds::ProcessFacts> facts_;  ///< of those told of last
  bool changed_ = true;
  SteadyTime told_;
};

}  // namespace cansyncd
