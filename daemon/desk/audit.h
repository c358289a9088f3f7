#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "daemon/desk/gateway_events.h"
#include "daemon/service/journal.h"
#include "dds/denial.h"

namespace cansyncd {

/// A change that a client asked for, in words. Its fields may be out of range: refused requests are recorded
/// too.
struct Change {
  std::string_view action;      ///< stable word; a literal
  int slave = -1;               ///< number, whatever a client gave; -1: none
  std::string what;             ///< which parameter, address or slaves; may be empty
  std::string new_value;        ///< what was asked for
  int parameter = -1;           ///< number, whatever a client gave; -1: none
  bool hashed = false;          ///< the SHA-256 of the request's data is recorded behind `new_value`
  std::string slave_name = {};  ///< its configured name; empty: none

  /// "slave 3 'winder'"; empty without a slave.
  std::string slave_text() const;
};

/// "SHA-256 0123…": which data a request had; empty when the cryptographic library fails.
std::string hash_text(const std::uint8_t* data, std::size_t size);

/// Who gave a request.
struct Requester {
  std::string name;         ///< what the client calls itself
  std::string label;        ///< the same with the beginning of its identity, for people
  std::string participant;  ///< DDS participant, 32 hexadecimal digits; empty: not known. With DDS Security
                            ///< its first 12 come from the certificate and cannot be chosen
  std::uint64_t request = 0;
};

/// Records every request that would change a drive, the line or the master: who, what, old and new value,
/// result; one entry in the journal for each, and an event. Gateway thread only.
///
/// What is accepted is bounded by the bus (one telegram an interval), so each has its entry. Of what is
/// refused at most `kRefused` a second have one, the rest is counted and told in one entry a second, because
/// a client can send without limit.
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

  /// A request that had been accepted ended. `before`: the value it replaced, or would have.
  void ended(const Requester& who, const Change& change, const std::string& before, const End& end,
             SteadyTime now);

  /// A request was refused: the entry has the word of the cause, then the reason.
  void refused(const Requester& who, const Change& change, const std::string& before,
               const gateway::dds::Denial& denial, SteadyTime now);

  /// Tells what was counted. Returns when to call again; nothing: no need.
  std::optional<SteadyTime> tick(SteadyTime now);

 private:
  struct Entry {
    const Requester& who;
    const Change& change;
    const std::string& before;
    std::string result;
    EventCode code;
  };
  void write(const Entry& entry, SteadyTime now);
  bool may_record_refusal(SteadyTime now);

  JournalSink& journal_;
  EventSink& events_;
  std::string bus_;
  int slaves_;
  SteadyTime window_;
  unsigned recorded_ = 0;  ///< refusals of this window
  std::uint64_t not_recorded_ = 0;
};

}  // namespace cansyncd
