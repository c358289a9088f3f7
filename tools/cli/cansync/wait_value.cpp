#include "cli/cansync/wait_value.h"

#include <fmt/format.h>

#include <array>
#include <chrono>
#include <condition_variable>
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

/// What was asked for; slave and value are looked up when a daemon is there.
struct Wanted {
  std::string slave;
  std::string value;
  Comparison comparison = Comparison::equal;
  double number = 0;
  bool raw = false;
};

Wanted parse_wanted(const std::vector<std::string>& words) {
  constexpr std::size_t kWords = 4;
  if (words.size() != kWords)
    throw UsageError(fmt::format(
        "value: found {} behind it; allowed: SLAVE VALUE COMPARISON NUMBER, such as winder position '>' 10",
        text::counted(words.size(), "word")));
  return {words[0], words[1], parse_comparison(words[2]), parse_real(words[3], "NUMBER"),
          looks_like_number(words[1])};
}

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

/// One run of the verb.
class ValueWait {
 public:
  ValueWait(Session& session, Wanted wanted) : session_(session), wanted_(std::move(wanted)) {
    if (const auto seconds = session.globals().timeout)
      end_ = start_ + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(*seconds));
  }

  ExitCode run() {
    constexpr std::chrono::milliseconds kSearch(2000);
    bool reached = false;
    do {
      client::Client* client = session_.look_for_daemon(std::min(kSearch, left()));
      reached = client != nullptr && look(*client);
    } while (!reached && !over());
    const double seconds = std::chrono::duration<double>(Clock::now() - start_).count();
    client::Reply reply{client::ReplyCode::done, ""};
    if (!reached) {
      const bool stopped = interrupt_flag().load();
      reply.code = stopped ? client::ReplyCode::cancelled : client::ReplyCode::timeout;
      reply.reason = fmt::format("{} {:.1f} s; seen last: {}",
                                 stopped ? "cancelled after" : "not reached within", seconds, seen_);
    }
    JsonObject object;
    object.add("state", "value").add_null("slave_mask").add("reached", reached).add("seconds", seconds);
    return session_.finish(reply, object, "wait value", fmt::format("{} after {:.1f} s", seen_, seconds));
  }

 private:
  bool over() const { return interrupt_flag().load() || Clock::now() >= end_; }
  std::chrono::milliseconds left() const {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(end_ - Clock::now());
    return std::max(left, std::chrono::milliseconds(1));
  }

  /// Looks at the daemon until the value is as wanted, the daemon goes or the time is over.
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
        seen_ = "no daemon";
        return false;
      }
      restarts.expect_one();
      const auto sample = newest.take(std::min(end_, Clock::now() + kLook));
      if (!sample || ((sample->ever >> (value / 4)) & 1u) == 0) continue;
      const double number = number_of(*sample, value, status.actual_value[value]);
      seen_ = text_of(status.actual_value[value], number);
      // The first may be of long ago: a line that is stopped sends no more.
      const std::uint64_t interval = sample->interval[value / 4];
      if (!known) known = interval;
      if (interval != *known && holds(number, wanted_.comparison, wanted_.number)) return true;
    }
    return false;
  }

  static client::SlaveStatus status_of(client::Client& client, unsigned slave) {
    for (const client::SlaveStatus& status : client.slaves())
      if (status.slave == slave) return status;
    throw UsageError(fmt::format("SLAVE: {} not configured", slave));
  }

  double number_of(const client::ActualValues& sample, unsigned value, const cansync_ValueName& name) const {
    if (!wanted_.raw) return sample.scaled[value];
    const Width width = ((sample.words >> value) & 1u) != 0 ? Width::word : Width::doubleword;
    return static_cast<double>(raw_number(sample.raw[value], {width, raw_form(name).is_signed}));
  }

  std::string text_of(const cansync_ValueName& name, double number) const {
    const std::string_view unit = wanted_.raw ? std::string_view() : client::text(name.unit_symbol);
    return fmt::format("{} is {:.10g}{}{}", wanted_.value, number, unit.empty() ? "" : " ", unit);
  }

  Session& session_;
  Wanted wanted_;
  Clock::time_point start_ = Clock::now();
  Clock::time_point end_ = Clock::time_point::max();
  std::string seen_ = "no telegram";
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

ExitCode wait_value(Session& session, const std::vector<std::string>& words) {
  return ValueWait(session, parse_wanted(words)).run();
}

}  // namespace cansync::cli
