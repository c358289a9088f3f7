#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "daemon/desk/gateway_events.h"
#include "daemon/desk/request_series.h"
#include "daemon/service/journal.h"
#include "dds/denial.h"

namespace cansyncd {

/// "SHA-256 0123…": which data a request had; empty when the cryptographic library fails.
std::string hash_text(const std::uint8_t* data, std::size_t size);

/// Records every request that would change a drive, the line or the master: who, what, old and new value,
/// result; one entry in the journal for each, and an event. Gateway thread only.
///
/// What is accepted of jobs is bounded by what they are for, so each has its entry. Of what is refused at most
/// `kRefused` a second have one, the rest is counted and told in one entry a second, because a client can ask without
/// limit. What a client sends again and again has an entry when it begins, and then some (`RequestSeries`), unless
/// each is to be recorded.
class AuditTrail {
 public:
  static constexpr unsigned kRefused = 100;
  /// The old value where nobody knows it.
  static constexpr const char* kNotKnown = "not known";

  /// How a request ended.
  struct End {
    std::string_view outcome;  ///< its name
    bool done = false;         ///< as it was asked for
  };

  /// `journal` and `events` must outlive the object. `slaves`: events name slaves below this number alone.
  AuditTrail(JournalSink& journal, EventSink& events, std::string bus, int slaves)
      : journal_(journal), events_(events), bus_(std::move(bus)), slaves_(slaves) {}

  /// Each request of a series has an entry of its own (access.record_each).
  void set_record_each(bool each) noexcept { each_ = each; }

  /// A request that had been accepted ended. `before`: the value it replaced, or would have.
  void ended(const Requester& who, const Change& change, const std::string& before, const End& end,
             SteadyTime now);

  /// A request was refused: the entry has the word of the cause, then the reason.
  void refused(const Requester& who, const Change& change, const std::string& before,
               const gateway::dds::Denial& denial, SteadyTime now);

  /// Tells what was counted. Returns when to call again; nothing: no need.
  std::optional<SteadyTime> tick(SteadyTime now);

  /// The last of the daemon: what was counted.
  void finish(SteadyTime now);

 private:
  void record(RecordedRequest request, SteadyTime now);
  void write(const RequestSeries::Sum& sum, SteadyTime now);
  bool may_record_refusal(SteadyTime now);
  void tell_not_recorded();

  JournalSink& journal_;
  EventSink& events_;
  std::string bus_;
  int slaves_;
  SteadyTime window_;
  unsigned recorded_ = 0;  ///< refusals of this window
  std::uint64_t not_recorded_ = 0;
  RequestSeries series_;
  bool each_ = false;
};

}  // namespace cansyncd
