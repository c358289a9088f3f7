#include "cli/learn/learn_points.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>

#include "cli/learn/evidence_text.h"
#include "cli/text/values.h"
#include "text/counts.h"

namespace cansync::cli {
namespace {

using observe::Certainty;
using observe::Found;
using observe::Learned;
using observe::Observation;

/// Control words beyond these are only counted.
constexpr std::size_t kMostWordsShown = 4;

class PointList {
 public:
  void fact(std::string name, std::string found, Certainty certainty, std::uint64_t count,
            std::uint32_t slaves = 0) {
    if (certainty == Certainty::not_seen) found = "-";
    points_.push_back({std::move(name), std::move(found), certainty, count, slaves});
  }
  template <class T>
  void setting(std::string name, const Found<T>& found, const std::function<std::string(const T&)>& text) {
    fact(std::move(name), text(found.value), found.certainty, found.count);
  }
  void flag(std::string name, const Found<bool>& found) {
    fact(std::move(name), found.value ? "true" : "false", found.certainty, found.count);
  }
  template <class T>
  void number(std::string name, const Found<T>& found) {
    fact(std::move(name), fmt::format("{}", found.value), found.certainty, found.count);
  }
  std::vector<LearnedPoint> take() { return std::move(points_); }

 private:
  std::vector<LearnedPoint> points_;
};

/// A setting of slaves: one point for each value of it.
void points_of_slaves(PointList& out, const std::string& name, const Learned& learned,
                      const Found<std::uint16_t> observe::LearnedSlave::*member) {
  struct Group {
    std::uint16_t value = 0;
    Certainty certainty = Certainty::not_seen;
    std::uint64_t count = 0;
    std::uint32_t slaves = 0;
  };
  std::vector<Group> groups;
  for (const SlaveNumber slave : learned.slaves.value) {
    const Found<std::uint16_t>& found = learned.slave[slave.value()].*member;
    const std::uint16_t value = found.known() ? found.value : std::uint16_t{0};
    auto at = std::find_if(groups.begin(), groups.end(), [&](const Group& group) {
      return group.value == value && group.certainty == found.certainty;
    });
    if (at == groups.end()) at = groups.insert(groups.end(), {value, found.certainty, 0, 0});
    at->count += found.count;
    at->slaves |= SlaveMask::of(slave).bits;
  }
  if (groups.empty()) out.fact(name, "", Certainty::not_seen, 0);
  for (const Group& group : groups)
    out.fact(group.certainty == Certainty::not_seen
                 ? fmt::format("{} ({})", name, format_slave_set(group.slaves))
                 : name,
             fmt::format("{} (slaves {})", group.value, format_slave_set(group.slaves)), group.certainty,
             group.count, group.slaves);
}

void line_points(PointList& out, const Observation& observation, const Learned& learned) {
  const auto& evidence = observation.evidence;
  out.fact("protocol", protocol_text(evidence),
           evidence.frames == 0 ? Certainty::not_seen : Certainty::inferred, evidence.telegrams);
  const auto& stamps = observation.stamps;
  out.fact("time stamps", stamps_text(stamps), stamps.frames == 0 ? Certainty::not_seen : Certainty::seen,
           stamps.frames);
  out.setting<Duration>("interval", learned.interval,
                        [](const Duration& time) { return fmt::format("{} us", microseconds_of(time)); });
  out.setting<BitRate>("bus.bit_rate", learned.bit_rate, [](const BitRate& rate) {
    return fmt::format("{} bit/s", slot_times(rate).bits_per_second);
  });
  out.setting<Duration>("bus.send_margin_us", learned.send_margin,
                        [](const Duration& time) { return fmt::format("{} us", microseconds_of(time)); });
  const auto mask = [](const SlaveMask& slaves) { return format_slave_set(slaves.bits); };
  out.setting<SlaveMask>("slaves", learned.slaves, mask);
  out.setting<SlaveMask>("slaves that answer", learned.answered, mask);
}

void process_points(PointList& out, const Observation& observation, const Learned& learned) {
  for (unsigned c = 0; c < kChannels; ++c) {
    out.setting<Cursor>(fmt::format("process.polling_{}", c + 1), learned.polling[c], polled_text);
    out.setting<TelegramMapping>(fmt::format("process.reference_values_{}", c + 1),
                                 learned.reference_mapping[c], mapping_numbers);
  }
  out.setting<SlaveNumber>("process.maximum_slave", learned.maximum_slave,
                           [](const SlaveNumber& slave) { return fmt::format("{}", slave.value()); });
  out.flag("process.polling_apart", learned.polling_apart);
  out.number("process.poll_nobody", learned.poll_nobody);
  out.flag("process.full_length", learned.full_length);
  out.flag("process.poll_without_reference", learned.poll_without_reference);
  for (unsigned c = 0; c < kChannels; ++c) {
    std::string sizes;
    std::uint64_t count = 0;
    for (unsigned words = 0; words <= kWords; ++words) {
      const std::uint64_t telegrams = observation.reference[c].by_words[words];
      count += telegrams;
      if (telegrams > 0) sizes += fmt::format("{}{}", sizes.empty() ? "" : ", ", 2 * words);
    }
    out.fact(fmt::format("bytes of WRC{}", c + 1), sizes, count == 0 ? Certainty::not_seen : Certainty::seen,
             count);
  }
}

void start_points(PointList& out, const Observation& observation, const Learned& learned) {
  const auto& activation = learned.activation;
  out.fact("startup.activate_command", fmt::format("{}", activation.value.command), activation.certainty,
           activation.count);
  out.fact("startup.activate_data", fmt::format("{}", activation.value.data), activation.certainty,
           activation.count);
  points_of_slaves(out, "slave.status_parameter", learned, &observe::LearnedSlave::status_parameter);
  out.setting<Duration>("startup.status_period_ms", learned.status_period, [](const Duration& time) {
    return time == Duration{0} ? std::string("0, never read")
                               : fmt::format("{} ms", microseconds_of(time) / 1000);
  });
  out.setting<EnableRule>("startup.enable", learned.enable,
                          [](const EnableRule& rule) { return std::string(enable_text(rule)); });
  // Which of them enable is the drive's affair.
  out.fact("startup.enabling_control_bits", "", Certainty::not_seen, 0);
  std::vector<std::uint16_t> words;
  std::uint64_t count = 0;
  for (const observe::Step& step : observation.steps) {
    const auto* action = std::get_if<observe::ActionStep>(&step.what);
    if (action == nullptr || action->action.command != kCommandControlWord) continue;
    count += step.count;
    if (std::find(words.begin(), words.end(), action->action.data_word) == words.end())
      words.push_back(action->action.data_word);
  }
  std::string text;
  for (std::size_t i = 0; i < words.size() && i < kMostWordsShown; ++i)
    text += fmt::format("{}0x{:04X}", text.empty() ? "" : " ", words[i]);
  if (words.size() > kMostWordsShown) text += fmt::format(" and {} more", words.size() - kMostWordsShown);
  out.fact("control words", text, count == 0 ? Certainty::not_seen : Certainty::seen, count);
}

void command_points(PointList& out, const Observation& observation, const Learned& learned) {
  out.setting<Serving>("command_channel.serving", learned.serving, [](const Serving& serving) {
    return std::string(serving == Serving::scan ? "scan" : "work_conserving");
  });
  points_of_slaves(out, "slave.block_limit", learned, &observe::LearnedSlave::block_limit);
  out.number("command_channel.address_step", learned.address_step);
  out.flag("command_channel.cancel_at_start", learned.cancel_at_start);
  std::uint64_t taken = 0;
  std::uint64_t refused = 0;
  std::uint64_t cancels = 0;
  TransferError error = TransferError::none;
  for (const observe::SlaveUse& slave : observation.slave) {
    cancels += slave.cancels;
    taken += slave.cancels_taken;
    refused += slave.cancels_refused;
    if (slave.cancels_refused > 0) error = slave.cancel_error;
  }
  const std::string answers = fmt::format("taken {}, refused {}", taken, refused);
  out.fact("answers to a cancel", answers, cancels == 0 ? Certainty::not_seen : Certainty::seen, cancels);
  if (refused > 0)
    out.fact("error of a refused cancel", fmt::format("0x{:04X}", static_cast<std::uint16_t>(error)),
             Certainty::seen, refused);
  out.flag("command_channel.repeat_unanswered_writes", learned.repeat_unanswered_writes);
  const auto& low = learned.allow_reserved_addresses;
  out.fact(
      "command_channel.allow_reserved_addresses",
      fmt::format("taken {}, refused {}", observation.low_addresses_taken, observation.low_addresses_refused),
      low.certainty, low.count);
}

}  // namespace

std::vector<LearnedPoint> learned_points(const Observation& observation, const Learned& learned) {
  PointList out;
  line_points(out, observation, learned);
  start_points(out, observation, learned);
  process_points(out, observation, learned);
  command_points(out, observation, learned);
  return out.take();
}

std::string certainty_text(Certainty certainty, std::uint64_t count) {
  if (certainty == Certainty::not_seen) return "not seen";
  if (certainty == Certainty::inferred) return "inferred";
  return count == 1 ? "seen once" : fmt::format("seen {}", text::counted(count, "time"));
}

std::string_view certainty_word(Certainty certainty) noexcept {
  if (certainty == Certainty::not_seen) return "not_seen";
  return certainty == Certainty::inferred ? "inferred" : "seen";
}

std::string polled_text(const Cursor& cursor) {
  if (cursor.kind == Cursor::Kind::automatic) return "automatic";
  if (cursor.kind == Cursor::Kind::nobody) return "nobody";
  return fmt::format("{}", cursor.slave.value());
}

std::string mapping_numbers(const TelegramMapping& mapping) {
  std::string text = "[";
  for (const WordMapping& word : mapping.word)
    text += fmt::format("{}{}", text.size() == 1 ? "" : ", ", word.assigned ? int{word.value} : -1);
  return text + "]";
}

std::string mapping_flags(const TelegramMapping& mapping) {
  std::string text = "[";
  for (const WordMapping& word : mapping.word)
    text += fmt::format("{}{}", text.size() == 1 ? "" : ", ", word.high);
  return text + "]";
}

std::string_view enable_text(EnableRule rule) noexcept {
  if (rule == EnableRule::all_synchronized) return "all_synchronized";
  return rule == EnableRule::all_responding ? "all_responding" : "any";
}

std::int64_t microseconds_of(Duration time) noexcept {
  return std::chrono::duration_cast<std::chrono::microseconds>(time).count();
}

std::vector<Table::Column> learned_columns() {
  constexpr auto left = Table::Align::left;
  return {{"POINT", left, "an option of the configuration by its name, or a fact"},
          {"FOUND", left, "its value; - = the recording tells nothing of it"},
          {"HOW", left,
           "seen = it stood on the bus, so often; inferred = it fits all that was seen, and another reading "
           "might, too; not seen = nothing tells it, and the configuration has its default"}};
}

}  // namespace cansync::cli
