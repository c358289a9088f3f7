#include "cli/cansync/wait_value.h"

#include <fmt/format.h>

#include <array>
#include <chrono>
#include <condition_variable>
#include <cstdlib>
#include <mutex>
#include <optional>
#include <utility>

#include "cli/base/interrupt.h"
#include "cli/base/restarts.h"
#include "cli/text/values.h"
#include "text/counts.h"

namespace cansync::cli {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::array<std::pair<std::string_view, Comparison>, 7> kComparisons = {
    {{"<", Comparison::less},
     {"<=", Comparison::at_most},
     {"=", Comparison::equal},
     {"==", Comparison::equal},
     {"!=", Comparison::not_equal},
     {">=", Comparison::at_least},
     {">", Comparison::more}}};

/// The newest sample of one slave, on its way from the client's thread to this one.
class Newest {
 public:
  Newest(client::Client& client, unsigned slave)
      : subscription_(client.on_actual_values([this, slave](const client::ActualValues& sample) {
          if (sample.slave != slave) return;
          {
            const std::lock_guard lock(mutex_);
            sample_ = sample;
          }
          changed_.notify_one();
        })) {}

  std::optional<client::ActualValues> take(Clock::time_point until) {
    std::unique_lock lock(mutex_);
    changed_.wait_until(lock, until, [this] { return sample_.has_value(); });
    return std::exchange(sample_, std::nullopt);
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<client::ActualValues> sample_;
  client::Subscription subscription_;  // ends before what its callback needs
};

/// One search for a value.
class ValueLook {
 public:
  ValueLook(Session& session, const Wanted& wanted, Clock::time_point end, bool once)
      : session_(session), wanted_(wanted), end_(end), once_(once) {}

  ValueSeen run() {
    constexpr std::chrono::milliseconds kSearch(2000);
    bool decided = false;
    do {
      client::Client* client = session_.look_for_daemon(std::min(kSearch, left()));
      decided = client != nullptr && look(*client);
    } while (!decided && !over());
    return seen_;
  }

 private:
  bool over() const { return interrupt_flag().load() || Clock::now() >= end_; }
  std::chrono::milliseconds left() const {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(end_ - Clock::now());
    return std::max(left, std::chrono::milliseconds(1));
  }

  /// Looks at the daemon until it is decided; false when the daemon goes or the time is over.
  bool look(client::Client& client) {
    constexpr auto kLook = std::chrono::milliseconds(20);  // for Ctrl-C
    const unsigned slave = session_.slave(wanted_.slave);
    const client::SlaveStatus status = status_of(client, slave);
    const unsigned value = parse_value_number(wanted_.value, value_lookup(status.actual_value));
    if (((mapped_values(status.actual_mapping) >> value) & 1u) == 0)
      throw UsageError(
          fmt::format("VALUE: '{}' of slave {} is not mapped, and never comes", wanted_.value, slave));
    Newest newest(client, slave);
    Restarts restarts(client);
    std::optional<std::uint64_t> known;  // interval of what was there before
    while (!over()) {
      if (restarts.gone()) {
        seen_.text = "no daemon";
        return false;
      }
      restarts.expect_one();
      if (restarts.take()) session_.output().remark(kStartedAnew);
      const auto sample = newest.take(std::min(end_, Clock::now() + kLook));
      // Name, number and unit are looked up again: they may mean another value now.
      if (const auto now = told_of(client, slave); now && !same_values(*now, status)) return false;
      if (!sample || ((sample->ever >> (value / 4)) & 1u) == 0) continue;
      const double number = number_of(*sample, value, status.actual_value[value]);
      seen_.text = text_of(status.actual_value[value], number);
      // The first may be of long ago: a line that is stopped sends no more.
      const std::uint64_t interval = sample->interval[value / 4];
      if (!known) known = interval;
      if (interval == *known) continue;
      seen_.fresh = true;
      seen_.reached = holds(number, wanted_.comparison, wanted_.number);
      if (seen_.reached || once_) return true;
    }
    return false;
  }

  static client::SlaveStatus status_of(client::Client& client, unsigned slave) {
    for (const client::SlaveStatus& status : client.slaves())
      if (status.slave == slave) return status;
    throw UsageError(fmt::format("SLAVE: {} not configured", slave));
  }

  /// As it is known now, without waiting; nothing: the daemon has just gone, or does not have it any more.
  static std::optional<client::SlaveStatus> told_of(client::Client& client, unsigned slave) {
    try {
      for (const client::SlaveStatus& status : client.slaves(std::chrono::milliseconds(0)))
        if (status.slave == slave) return status;
    } catch (const client::OtherProtocol&) {
      throw;
    } catch (const client::NoDaemon&) {  // said by `gone`
    }
    return std::nullopt;
  }

  double number_of(const client::ActualValues& sample, unsigned value, const cansync_ValueName& name) const {
    // Compared is what is shown: the last bits of a factor such as 0.1 would make `=` never hold.
    if (!wanted_.raw) return std::strtod(fmt::format("{:.10g}", sample.scaled[value]).c_str(), nullptr);
    const Width width = ((sample.words >> value) & 1u) != 0 ? Width::word : Width::doubleword;
    return static_cast<double>(raw_number(sample.raw[value], {width, raw_form(name).is_signed}));
  }

  std::string text_of(const cansync_ValueName& name, double number) const {
    const std::string_view unit = wanted_.raw ? std::string_view() : client::text(name.unit_symbol);
    return fmt::format("{} is {:.10g}{}{}", wanted_.value, number, unit.empty() ? "" : " ", unit);
  }

  Session& session_;
  const Wanted& wanted_;
  Clock::time_point end_;
  bool once_;
  ValueSeen seen_{false, false, "no telegram"};
};

}  // namespace

Comparison parse_comparison(std::string_view text) {
  for (const auto& [word, comparison] : kComparisons)
    if (word == text) return comparison;
  throw UsageError(
      fmt::format("COMPARISON: found '{}'; allowed: < <= = != >= > (in quotes at the shell)", text));
}

bool holds(double value, Comparison comparison, double wanted) noexcept {
  switch (comparison) {
    case Comparison::less:
      return value < wanted;
    case Comparison::at_most:
      return value <= wanted;
    case Comparison::equal:
      return value == wanted;
    case Comparison::not_equal:
      return value != wanted;
    case Comparison::at_least:
      return value >= wanted;
    case Comparison::more:
      break;
  }
  return value > wanted;
}

Wanted parse_wanted(const std::vector<std::string>& words, std::string_view what) {
  constexpr std::size_t kWords = 4;
  if (words.size() != kWords)
    throw UsageError(
        fmt::format("{}: found {} behind it; allowed: SLAVE {} COMPARISON NUMBER, such as winder "
                    "position '>' 10",
                    what, text::counted(words.size(), "word"), what == "read" ? "PARAMETER" : "VALUE"));
  return {words[0],
          words[1],
          words[2],
          parse_comparison(words[2]),
          parse_real(words[3], "NUMBER"),
          looks_like_number(words[1])};
}

ValueSeen look_at_value(Session& session, const Wanted& wanted, Clock::time_point end, bool once) {
  return ValueLook(session, wanted, end, once).run();
}

ExitCode wait_value(Session& session, const std::vector<std::string>& words) {
  const Wanted wanted = parse_wanted(words, "value");
  const auto start = Clock::now();
  auto end = Clock::time_point::max();
  if (const auto seconds = session.globals().timeout)
    end = start + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(*seconds));
  const ValueSeen seen = look_at_value(session, wanted, end, false);
  const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
  client::Reply reply{client::ReplyCode::done, ""};
  if (!seen.reached) {
    const bool stopped = interrupt_flag().load();
    reply.code = stopped ? client::ReplyCode::cancelled : client::ReplyCode::timeout;
    reply.reason = fmt::format("{} {:.1f} s; seen last: {}",
                               stopped ? "cancelled after" : "not reached within", seconds, seen.text);
  }
  JsonObject object;
  object.add("state", "value").add_null("slave_mask").add("reached", seen.reached).add("seconds", seconds);
  return session.finish(reply, object, "wait value", fmt::format("{} after {:.1f} s", seen.text, seconds));
}

}  // namespace cansync::cli
