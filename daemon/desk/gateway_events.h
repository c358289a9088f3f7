#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "daemon/desk/event_text.h"
#include "daemon/service/journal.h"
#include "dds/endpoint.h"
#include "dds/gateway_topics.h"
#include "dds/participant.h"
#include "gateway.h"

namespace cansyncd {

/// Clock of everything on the gateway thread that waits or is limited in rate.
using SteadyTime = std::chrono::steady_clock::time_point;

/// CLOCK_REALTIME, ns since 1970.
std::int64_t wall_clock_now() noexcept;

/// Holds back what repeats too fast or for too long: of one kind of event at most `kBurst` are reported in `kWindow`, and
/// after `kMost` one in `kRefill`; the rest is counted and summed up in the next one that is reported. What stays away
/// has its `kMost` back, one in `kRefill`. Not thread safe.
class FloodGuard {
 public:
  static constexpr unsigned kBurst = 5;
  static constexpr std::chrono::seconds kWindow{1};
  /// Not for requests of clients, which write to the journal by themselves.
  static constexpr unsigned kMost = 60;
  static constexpr std::chrono::seconds kRefill{60};

  /// True: tell it now, behind what `held_of` its slave. False: it was counted.
  bool pass(const EventText& event, SteadyTime now);

  /// The next summary of what is held back of a slave (-1: of the bus), due or not, in the order in which it happened:
  /// the last report of a slave is the newest. Nothing when there is none.
  std::optional<EventText> held_of(int slave, SteadyTime now);

  /// The next summary that is due, newest text of its kind with the count added; nothing when there is none. One that
  /// is due brings what is held back of the same slave along.
  std::optional<EventText> due(SteadyTime now);

  /// The next summary of whatever is held back: for the end.
  std::optional<EventText> left(SteadyTime now);

  /// When `due` has something at the earliest; nothing: it has nothing to wait for.
  std::optional<SteadyTime> next() const;

 private:
  struct Window {
    SteadyTime begin;
    unsigned told = 0;      ///< since `begin`
    unsigned left = kMost;  ///< that may be told
    SteadyTime refilled;    ///< `left` rose last
    std::uint64_t held_back = 0;
    SteadyTime held_since;            ///< when something is held back
    SteadyTime held_last;             ///< likewise
    std::optional<EventText> newest;  ///< likewise

    void refill(SteadyTime now);
    void count_told(const EventText& event);
    bool is_due(SteadyTime now);
    EventText summary(SteadyTime now);
  };
  std::map<std::pair<std::string_view, int>, Window> windows_;  ///< by code and slave
};

/// A fault that comes again and again: its first is told, the others are counted until it has stayed away for
/// `quiet`. Not thread safe.
class FaultRow {
 public:
  explicit FaultRow(std::chrono::seconds quiet) : quiet_(quiet) {}

  /// `count` faults happened. True: they begin a row, and are to be told.
  bool add(std::uint64_t count, SteadyTime now) {
    if (count == 0) return false;  // no fault: the row is not prolonged
    const bool first = count_ == 0;
    count_ += count;
    last_ = now;
    return first;
  }

  /// Faults of the row that is over, and forgets them; 0: none is over.
  std::uint64_t take_over(SteadyTime now) {
    return count_ != 0 && now - last_ >= quiet_ ? std::exchange(count_, 0) : 0;
  }

  /// When the row is over at the earliest; nothing: there is none.
  std::optional<SteadyTime> next() const {
    return count_ != 0 ? std::optional(last_ + quiet_) : std::nullopt;
  }

  std::chrono::seconds quiet() const noexcept { return quiet_; }

 private:
  std::chrono::seconds quiet_;
  std::uint64_t count_ = 0;
  SteadyTime last_;
};

/// Takes events, to tell them. Gateway thread only.
class EventSink {
 public:
  EventSink() = default;
  EventSink(const EventSink&) = delete;
  EventSink& operator=(const EventSink&) = delete;
  virtual ~EventSink() = default;
  /// Tells `event`. False: it is told in a sum, later.
  virtual bool publish(const EventText& event, SteadyTime now) = 0;
};

/// Numbers events, publishes them and writes each to the journal. Gateway thread only.
class EventPublisher final : public EventSink {
 public:
  /// `journal` must outlive the publisher; `bus` is the field BUS. Throws gateway::dds::SetupError.
  EventPublisher(const gateway::dds::Participant& participant, JournalSink& journal, std::string bus)
      : writers_{Writer(participant), Writer(participant), Writer(participant)},
        journal_(journal),
        bus_(std::move(bus)) {}

  /// Number of the running interval, for events that carry no moment of their own.
  void set_interval(std::uint64_t interval) noexcept { interval_ = interval; }

  /// Publishes `event` unless events of its kind come too fast. False: it is told in a sum, later.
  bool publish(const EventText& event, SteadyTime now) override;

  /// Writes `event` to the journal alone, unbounded: for what clients are told in sums.
  void record(const EventText& event);

  /// Publishes the summaries that are due. Returns when to call again; nothing: no need.
  std::optional<SteadyTime> tick(SteadyTime now);

  /// Publishes all that is still held back. For the end.
  void finish(SteadyTime now);

 private:
  void write(const EventText& event);
  std::vector<JournalField> fields_of(const EventText& event) const;

  using Writer = gateway::dds::Writer<gateway_Event>;

  /// By severity: what is frequent and harmless does not push faults out of what late readers get.
  std::array<Writer, 3> writers_;
  JournalSink& journal_;
  const std::string bus_;
  FloodGuard guard_;
  std::uint64_t number_ = 0;
  std::uint64_t interval_ = 0;
};

}  // namespace cansyncd
