#include "invariants.h"

#include <algorithm>
#include <array>
#include <cstddef>

#include "cansync/settings/timing.h"

namespace cansyncd::campaign {
namespace {

using cansync::Channel;
using Verdict = std::optional<std::string>;

Verdict complaint(const std::string& text) {
  return text.empty() ? std::nullopt : Verdict(text);
}

std::string number(std::uint64_t value) {
  return std::to_string(value);
}

std::string nanoseconds(can::Time time) {
  return std::to_string(time.count()) + " ns";
}

std::string identifier_text(const can::Frame& frame) {
  return "the telegram with identifier " + number(frame.id);
}

bool is_command(const can::Frame& frame) noexcept {
  return frame.id == cansync::identifier::action || (frame.id & 0x780u) == cansync::identifier::command;
}

bool is_reference(const can::Frame& frame, Channel channel) noexcept {
  return (frame.id & 0x780u) ==
         (channel == Channel::one ? cansync::identifier::reference_one : cansync::identifier::reference_two);
}

/// Latest start of a telegram of the master after its SYNC edge.
can::Time latest_start(const Plan& plan, const can::Frame& frame) noexcept {
  const cansync::SlotTimes& times = cansync::slot_times(plan.settings.bit_rate);
  if (is_reference(frame, Channel::one)) return times.reference_one;
  return is_reference(frame, Channel::two) ? times.reference_two : times.command;
}

// --- requests

Verdict one_terminal_reply_per_request(const Scene& scene) {
  if (!scene.ledger.complaint().empty()) return scene.ledger.complaint();
  if (!scene.ended || scene.ledger.open().empty()) return std::nullopt;
  return number(scene.ledger.open().size()) + " requests have no answer after the end, the first is " +
         number(scene.ledger.open().begin()->first);
}

Verdict a_written_parameter_holds_what_was_confirmed(const Scene& scene) {
  return complaint(scene.parameters.complaint());
}

Verdict a_transferred_block_equals_the_memory(const Scene& scene) {
  return complaint(scene.memories.complaint());
}

Verdict every_word_is_what_the_drives_have(const Scene& scene) {
  return complaint(scene.words.wrong_word());
}

Verdict every_change_has_one_entry_that_names_it(const Scene& scene) {
  return complaint(scene.words.wrong_entry());
}

Verdict the_value_before_was_there(const Scene& scene) {
  return complaint(scene.words.wrong_before());
}

Verdict queues_are_bounded(const Scene& scene) {
  const cansync::CommandChannelSettings& channel = scene.plan.settings.command_channel;
  const auto open = [&](Job::Kind kind) {
    const auto& jobs = scene.ledger.open();
    return static_cast<std::size_t>(
        std::count_if(jobs.begin(), jobs.end(), [kind](const auto& job) { return job.second.kind == kind; }));
  };
  if (scene.now.open_parameter_jobs > channel.parameter_queue) {
    return number(scene.now.open_parameter_jobs) + " parameter jobs in a queue of " +
           number(channel.parameter_queue);
  }
  if (scene.now.open_transfers > channel.transfer_queue) {
    return number(scene.now.open_transfers) + " transfers in a queue of " + number(channel.transfer_queue);
  }
  if (scene.now.open_parameter_jobs > open(Job::Kind::parameter) ||
      scene.now.open_transfers > open(Job::Kind::transfer)) {
    return "the master has more jobs open than there are requests without an answer";
  }
  return std::nullopt;
}

// --- the bus

Verdict every_telegram_is_well_formed(const Scene& scene) {
  for (const HandOver& hand_over : scene.witness.handed) {
    if (!hand_over.telegram) return identifier_text(hand_over.frame) + " cannot be decoded";
  }
  return std::nullopt;
}

Verdict no_telegram_outside_its_slot(const Scene& scene) {
  for (const HandOver& hand_over : scene.witness.handed) {
    const can::Time after = hand_over.at - hand_over.due;
    if (after >= can::Time{0} && after <= latest_start(scene.plan, hand_over.frame)) continue;
    return identifier_text(hand_over.frame) + " is handed over " + nanoseconds(after) +
           " after the last edge";
  }
  if (scene.plan.disturbed(scene.line_edges)) return std::nullopt;
  for (const MasterFrame& frame : scene.witness.frames) {
    if (frame.since_edge <= latest_start(scene.plan, frame.frame)) continue;
    return identifier_text(frame.frame) + " begins on the bus " + nanoseconds(frame.since_edge) +
           " after its edge, without a fault";
  }
  return std::nullopt;
}

Verdict silence_where_nothing_may_be_sent(const Scene& scene) {
  const bool silent =
      !cansync::is_synchronous(scene.before.state) && !cansync::is_synchronous(scene.now.state);
  if (silent && !scene.witness.edges.empty()) return "a SYNC edge is made while the master is stopped";
  if (silent && !scene.witness.handed.empty()) {
    return identifier_text(scene.witness.handed.front().frame) + " is sent while the master is stopped";
  }
  const bool active = cansync::is_active(scene.before.state) || cansync::is_active(scene.now.state);
  for (const HandOver& hand_over : scene.witness.handed) {
    if (active || is_command(hand_over.frame)) continue;
    return identifier_text(hand_over.frame) + " is sent outside active operation";
  }
  return std::nullopt;
}

Verdict never_more_than_one_command_per_interval(const Scene& scene) {
  std::array<unsigned, 1 + cansync::kChannels> sent = {};
  for (const HandOver& hand_over : scene.witness.handed) {
    if (is_command(hand_over.frame)) ++sent[0];
    if (is_reference(hand_over.frame, Channel::one)) ++sent[1];
    if (is_reference(hand_over.frame, Channel::two)) ++sent[2];
  }
  if (std::all_of(sent.begin(), sent.end(), [](unsigned n) { return n <= 1; })) return std::nullopt;
  return number(sent[0]) + " commands, " + number(sent[1]) + " WRC1 and " + number(sent[2]) +
         " WRC2 in one interval";
}

Verdict sync_comes_exactly_on_time(const Scene& scene) {
  const can::Time interval = scene.plan.interval();
  for (const Edge& edge : scene.witness.edges) {
    if (edge.due.count() % interval.count() != 0) {
      return "SYNC is due at " + nanoseconds(edge.due) + ", which is no multiple of the interval";
    }
    const can::Time late = edge.made - edge.due;
    if (late < can::Time{0} || late > interval / 2) return "SYNC is made " + nanoseconds(late) + " late";
  }
  const auto& recent = scene.witness.recent_edges;
  for (std::size_t i = 1; i < recent.size(); ++i) {
    if (recent[i].number <= recent[i - 1].number)
      return "a SYNC edge comes twice: " + number(recent[i].number);
    if (recent[i].made - recent[i - 1].made >= interval / 2) continue;
    return "two SYNC edges are " + nanoseconds(recent[i].made - recent[i - 1].made) + " apart";
  }
  // At the very end, edges may have been skipped that none followed.
  if (scene.ended || scene.now.missed_syncs == scene.skipped) return std::nullopt;
  return number(scene.skipped) + " SYNC edges were skipped, " + number(scene.now.missed_syncs) +
         " are counted";
}

// --- values

Verdict reference_values_are_released_as_often_as_allowed(const Scene& scene) {
  return complaint(scene.witness.references.complaint());
}

Verdict reference_values_are_of_who_may_give_them(const Scene& scene) {
  return complaint(scene.witness.references.giver_complaint());
}

Verdict a_writer_keeps_its_telegram_until_a_stronger_one_comes(const Scene& scene) {
  return complaint(scene.witness.references.owner_complaint());
}

Verdict no_release_begins_with_old_values(const Scene& scene) {
  return complaint(scene.witness.references.age_complaint());
}

Verdict no_released_value_is_beyond_its_limits_or_steps(const Scene& scene) {
  return complaint(scene.witness.references.limit_complaint());
}

Verdict a_word_that_stops_is_sent_in_two_intervals(const Scene& scene) {
  return complaint(scene.witness.stops.complaint());
}

/// The arrival that brought these values, if there was one.
bool brought(const Scene& scene, const ActualSeen& seen, Channel channel) {
  const cansync::ActualValues& values = seen.report.values;
  const cansync::IntervalNumber interval = values.interval[index(channel)];
  const auto edge = std::find_if(scene.witness.recent_edges.begin(), scene.witness.recent_edges.end(),
                                 [interval](const Edge& other) { return other.number == interval; });
  const auto question = std::find_if(
      scene.witness.questions.begin(), scene.witness.questions.end(), [&](const Question& other) {
        return other.interval == interval && other.channel == channel && other.polled == seen.slave.value();
      });
  if (edge == scene.witness.recent_edges.end() || question == scene.witness.questions.end()) return false;
  // Questions without reference values look all the same: one that was held up asks just as well.
  const auto asked_by = [&](const Arrival& arrival) {
    return std::any_of(
        scene.witness.questions.begin(), scene.witness.questions.end(), [&](const Question& other) {
          return other.frame == question->frame && other.start >= edge->made && other.start <= arrival.start;
        });
  };
  const auto next = edge + 1;
  const can::Time until = next != scene.witness.recent_edges.end() ? next->made : can::Time::max();
  return std::any_of(
      scene.witness.arrivals.begin(), scene.witness.arrivals.end(), [&](const Arrival& arrival) {
        if (arrival.telegram.slave != seen.slave || arrival.telegram.channel != channel) return false;
        if (!asked_by(arrival) || arrival.end < edge->made || arrival.end > until) return false;
        const auto fits = [&](const cansync::ProcessMapping& mapping) {
          cansync::Values unpacked = values.value;
          unpack(mapping[index(channel)], std::span(arrival.telegram.word).first(arrival.telegram.words),
                 unpacked);
          return unpacked == values.value;
        };
        return fits(scene.mapping_before[seen.slave.value()]) || fits(scene.mapping_now[seen.slave.value()]);
      });
}

Verdict no_value_is_fresh_that_is_not(const Scene& scene) {
  for (const ActualSeen& seen : scene.actual) {
    const cansync::ActualValues& values = seen.report.values;
    const std::string who = "slave " + number(seen.slave.value());
    if (values.arrived[0] == values.arrived[1])
      return who + " has values that no telegram, or two have brought";
    const Channel channel = values.arrived[0] ? Channel::one : Channel::two;
    for (const Channel each : {Channel::one, Channel::two}) {
      if (values.count[index(each)] > scene.witness.arrived[seen.slave.value()][index(each)]) {
        return who + " has sent fewer telegrams than the master has counted";
      }
    }
    if (values.count[index(channel)] <= scene.counted[seen.slave.value()][index(channel)]) {
      return who + " has fresh values, and no new telegram is counted";
    }
    if (!brought(scene, seen, channel)) {
      return who + " has values marked as of interval " + number(values.interval[index(channel)]) +
             " in channel " + number(index(channel) + 1) + " that no telegram asked for then has brought";
    }
  }
  return std::nullopt;
}

// --- counters, and the end of all faults

Verdict counters_are_consistent(const Scene& scene) {
  const cansync::MasterCounters& counters = scene.now.counters;
  const Witness& witness = scene.witness;
  if (counters.telegrams_sent != witness.accepted) {
    return number(witness.accepted) + " telegrams were sent, " + number(counters.telegrams_sent) +
           " are counted";
  }
  if (counters.left_out < witness.refused) {
    return "the bus refused " + number(witness.refused) + " telegrams, " + number(counters.left_out) +
           " are counted as left out";
  }
  if (counters.intervals != witness.edges_made) {
    return number(witness.edges_made) + " intervals began, " + number(counters.intervals) + " are counted";
  }
  return std::nullopt;
}

Verdict back_in_normal_operation_in_time(const Scene& scene) {
  if (scene.recovery.failed()) return "a probe job does not end as done, though everything seems to run";
  if (!scene.recovery.overdue()) return std::nullopt;
  return "still not " + number(scene.recovery.allowed()) +
         " intervals after the last fault:" + scene.recovery.missing();
}

constexpr Invariant kInvariants[] = {
    {"one_terminal_reply_per_request", &one_terminal_reply_per_request},
    {"a_written_parameter_holds_what_was_confirmed", &a_written_parameter_holds_what_was_confirmed},
    {"a_transferred_block_equals_the_memory", &a_transferred_block_equals_the_memory},
    {"every_word_is_what_the_drives_have", &every_word_is_what_the_drives_have},
    {"every_change_has_one_entry_that_names_it", &every_change_has_one_entry_that_names_it},
    {"the_value_before_was_there", &the_value_before_was_there},
    {"queues_are_bounded", &queues_are_bounded},
    {"every_telegram_is_well_formed", &every_telegram_is_well_formed},
    {"no_telegram_outside_its_slot", &no_telegram_outside_its_slot},
    {"silence_where_nothing_may_be_sent", &silence_where_nothing_may_be_sent},
    {"never_more_than_one_command_per_interval", &never_more_than_one_command_per_interval},
    {"sync_comes_exactly_on_time", &sync_comes_exactly_on_time},
    {"no_value_is_fresh_that_is_not", &no_value_is_fresh_that_is_not},
    {"reference_values_are_released_as_often_as_allowed", &reference_values_are_released_as_often_as_allowed},
    {"reference_values_are_of_who_may_give_them", &reference_values_are_of_who_may_give_them},
    {"a_writer_keeps_its_telegram_until_a_stronger_one_comes",
     &a_writer_keeps_its_telegram_until_a_stronger_one_comes},
    {"no_release_begins_with_old_values", &no_release_begins_with_old_values},
    {"no_released_value_is_beyond_its_limits_or_steps", &no_released_value_is_beyond_its_limits_or_steps},
    {"a_word_that_stops_is_sent_in_two_intervals", &a_word_that_stops_is_sent_in_two_intervals},
    {"counters_are_consistent", &counters_are_consistent},
    {"back_in_normal_operation_in_time", &back_in_normal_operation_in_time},
};

}  // namespace

std::span<const Invariant> invariants() noexcept {
  return kInvariants;
}

}  // namespace cansyncd::campaign
