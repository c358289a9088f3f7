#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "cansync/settings/settings.h"
#include "cansync/settings/timing.h"
#include "cansync/telegram/telegram.h"
#include "daemon/cansync/exchange.h"
#include "daemon/cansync/realtime/realtime_loop.h"
#include "scripted_bus.h"

namespace cansyncd::test {

inline cansync::SlaveNumber slave(unsigned n) {
  return *cansync::SlaveNumber::from(n);
}

/// Settings for slaves 0..count-1.
inline cansync::MasterSettings master_settings(unsigned count) {
  cansync::MasterSettings settings;
  settings.process.maximum_slave = slave(count - 1);
  settings.startup.census = false;  // which_drive_test has this switched on
  for (unsigned i = 0; i < count; ++i) settings.slaves[i].configured = true;
  return settings;
}

/// Read of `number` from `target`, as job `id`.
inline cansync::ParameterRequest read_request(cansync::JobId id, unsigned target, unsigned number) {
  cansync::ParameterRequest request;
  request.id = id;
  request.slave = slave(target);
  request.number = *cansync::ParameterNumber::from(number);
  return request;
}

/// Reference values for many intervals, so that WRC1 goes out in each.
inline cansync::ReferenceUpdate references(cansync::Channel channel, std::uint32_t intervals = 1000) {
  cansync::ReferenceUpdate update;
  update.channel = channel;
  update.valid_mask = 1;
  update.release_intervals = intervals;
  return update;
}

/// A loop that reads no clock but the bus's.
inline LoopSettings virtual_time(StartTarget target = StartTarget::active) {
  LoopSettings settings;
  settings.target = target;
  settings.wall_clock = nullptr;
  return settings;
}

/// The settings with the wire of a scripted bus.
inline LoopSettings wired(LoopSettings settings, ScriptedBus& bus) {
  settings.sync_wire = &bus;
  return settings;
}

/// A realtime loop on a scripted bus, in virtual time on the test's own thread. The slaves are synchronized,
/// answer every parameter read with its number, and send their own number as actual value.
class LoopRig {
 public:
  explicit LoopRig(const LoopSettings& loop_settings = virtual_time(),
                   const cansync::MasterSettings& settings = master_settings(3),
                   const ExchangeSizes& sizes = {})
      : interval(cansync::slot_times(settings.bit_rate).interval),
        bus(cansync::slot_times(settings.bit_rate).bits_per_second),
        exchange(sizes),
        loop(settings, wired(loop_settings, bus), bus, exchange) {
    bus.answer = [this](const can::Frame& frame) { return answer_as_slaves(frame); };
    bus.on_sleep = [this](can::Time now) { play(now); };
  }

  const can::Time interval;
  ScriptedBus bus;
  Exchange exchange;
  RealtimeLoop loop;
  bool slaves_synchronized = true;
  bool gateway_reads = true;  ///< false: the gateway thread hangs

  std::multimap<cansync::JobId, Terminal> terminals;
  std::vector<Report> reports;

  /// Does something at SYNC number `n` + `after`, as seen from the gateway.
  void at(unsigned n, can::Time after, std::function<void()> action) {
    script_.emplace(first_sync() + n * interval + after, std::move(action));
  }
  /// Pushes a request at SYNC number `n`.
  void push_at(unsigned n, const Request& request) {
    at(n, can::Time{0}, [this, request] { EXPECT_TRUE(exchange.requests.try_push(request)); });
  }
  /// Runs the loop until SYNC number `n`.
  void run_until(unsigned n) {
    at(n, can::Time{0}, [this] { loop.request_stop(); });
    loop.run();
    collect();
  }
  can::Time began() const { return began_; }
  can::Time first_sync() const { return began_ + interval; }

  template <class T>
  std::vector<T> reported() const {
    std::vector<T> found;
    for (const Report& report : reports) {
      if (const T* typed = std::get_if<T>(&report)) found.push_back(*typed);
    }
    return found;
  }
  /// The only answer to a job.
  template <class T>
  T answer_to(cansync::JobId id) const {
    EXPECT_EQ(terminals.count(id), 1U) << "job " << id;
    const auto found = terminals.find(id);
    const T* typed = found == terminals.end() ? nullptr : std::get_if<T>(&found->second);
    EXPECT_NE(typed, nullptr) << "job " << id << " has another kind of answer";
    return typed == nullptr ? T{} : *typed;
  }
  MasterSnapshot snapshot() {
    MasterSnapshot latest;
    EXPECT_TRUE(exchange.master.read(latest));
    return latest;
  }
  /// Times after the first SYNC at which frames of this identifier channel (upper four bits) were handed
  /// over.
  std::vector<can::Time> sent_on(std::uint32_t channel) const {
    std::vector<can::Time> times;
    for (const auto& sent : bus.sent) {
      if ((sent.frame.id & 0x780U) == channel) times.push_back(sent.at - first_sync());
    }
    return times;
  }

  void collect() {
    Terminal terminal;
    while (exchange.terminals.try_pop(terminal)) {
      terminals.emplace(std::visit([](const auto& typed) { return typed.id; }, terminal), terminal);
    }
    Report report;
    while (exchange.reports.try_pop(report)) reports.push_back(report);
  }

 private:
  void play(can::Time now) {
    if (gateway_reads) collect();
    while (!script_.empty() && script_.begin()->first <= now) {
      const auto action = script_.begin()->second;
      script_.erase(script_.begin());
      action();
    }
  }

  std::optional<can::Frame> answer_as_slaves(const can::Frame& frame) const {
    const auto decoded = cansync::decode(frame);
    const auto* telegram = std::get_if<cansync::Telegram>(&decoded);
    if (telegram == nullptr) return std::nullopt;
    if (const auto* reference = std::get_if<cansync::ReferenceTelegram>(telegram)) {
      const auto asked = cansync::SlaveNumber::from(reference->polled);
      if (!asked) return std::nullopt;
      return cansync::encode(
          cansync::ActualTelegram{reference->channel, *asked, 4, {asked->value(), 0, 0, 0}});
    }
    const auto* command = std::get_if<cansync::ParameterCommand>(telegram);
    if (command == nullptr || command->kind != cansync::ParameterCommand::Kind::read) return std::nullopt;
    const bool status = command->number.value() == 301;
    const unsigned word = status ? (slaves_synchronized ? 0x8000U : 0U) : command->number.value();
    cansync::ParameterReply reply{command->slave, command->number, false, false, 4, {}};
    cansync::store_word(reply.payload.data(), static_cast<std::uint16_t>(word));
    return cansync::encode(reply);
  }

  std::multimap<can::Time, std::function<void()>> script_;
  const can::Time began_ = bus.now();
};

}  // namespace cansyncd::test
