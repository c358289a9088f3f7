// One interval of the master core, and the telegram codec. docs/performance.md has the figures and the
// command.
#include <benchmark/benchmark.h>

#include <array>
#include <chrono>

#include "cansync/master.h"
#include "cansync/settings/timing.h"
#include "cansync/telegram/telegram.h"

namespace {

using namespace cansync;

struct Deaf : MasterListener {
  void actual_values(SlaveNumber, const ActualValues& values) noexcept override {
    benchmark::DoNotOptimize(values.value[0]);
  }
  void slave_status(SlaveNumber, const SlaveStatus&) noexcept override {}
  void state_changed(State, State, ControlCommand) noexcept override {}
  void parameter_done(JobId id, const ParameterResult&) noexcept override { benchmark::DoNotOptimize(id); }
  void transfer_progress(JobId, std::uint32_t) noexcept override {}
  void transfer_done(JobId, const TransferResult&) noexcept override {}
  void command_done(JobId, Outcome) noexcept override {}
  void event(const MasterEvent&) noexcept override {}
};

/// The answer of a well-behaved slave, already encoded; nothing for telegrams that ask none.
std::optional<can::Frame> answer(const can::Frame& frame) {
  const std::uint32_t number = frame.id & 0x1F;
  const std::uint32_t channel = frame.id & 0x780;
  if (channel == identifier::reference_one)
    return can::Frame{.id = identifier::actual_one + number, .dlc = 8, .data = {1, 2, 3, 4}};
  if (channel == identifier::reference_two)
    return can::Frame{.id = identifier::actual_two + number, .dlc = 8, .data = {5, 6, 7, 8}};
  if (channel != identifier::command) return std::nullopt;
  return can::Frame{.id = identifier::response + number,
                    .dlc = 6,
                    .data = {static_cast<std::uint8_t>(frame.data[0] & 0x0F), frame.data[1], 0, 0x80}};
}

/// Active operation with 32 slaves: both reference telegrams, both actual value telegrams, one parameter read
/// with its answer in every interval. The slaves' answers are ready-made, so that the time is the master's.
void master_interval(benchmark::State& state) {
  MasterSettings settings;
  settings.process.maximum_slave = *SlaveNumber::from(31);
  for (auto& slave : settings.slaves) slave.configured = true;
  settings.startup.enable = EnableRule::any;
  Deaf deaf;
  Master master(settings, deaf);
  for (const auto command : {ControlCommand::handshake, ControlCommand::take_over_initialisation,
                             ControlCommand::start_synchronous, ControlCommand::enable_active}) {
    if (master.control(command) != Refusal::none) state.SkipWithError("the master did not start");
  }
  IntervalNumber n = 0;
  JobId id = 0;
  std::optional<can::Frame> response;
  for (auto _ : state) {
    master.begin_interval(n++);
    if (response) master.receive(*response, std::chrono::microseconds(150));
    response.reset();
    ReferenceUpdate update{.value = {static_cast<std::uint32_t>(n), 2, 3, 4}, .valid_mask = 15};
    benchmark::DoNotOptimize(master.submit(update));
    update.channel = Channel::two;
    benchmark::DoNotOptimize(master.submit(update));
    const ParameterRequest request{
        .id = ++id, .slave = *SlaveNumber::from(n % 32), .number = *ParameterNumber::from(7)};
    benchmark::DoNotOptimize(master.submit(request));
    for (const Slot slot : {Slot::reference_one, Slot::reference_two, Slot::command}) {
      const auto frame = master.take(slot);
      if (!frame) continue;
      master.sent(slot);
      master.transmitted(*frame, master.planned_start(slot) + std::chrono::microseconds(100));
      const auto reply = answer(*frame);
      if (slot == Slot::command) {
        response = reply;
      } else if (reply) {
        master.receive(*reply, std::chrono::microseconds(500));
      }
    }
  }
  state.counters["telegrams/interval"] =
      benchmark::Counter(static_cast<double>(master.counters().telegrams_sent) / static_cast<double>(n));
}
BENCHMARK(master_interval);

const std::array<Telegram, 4>& telegrams() {
  static const std::array<Telegram, 4> list = {
      ReferenceTelegram{Channel::one, 5, 4, {1, 2, 3, 4}},
      ActualTelegram{Channel::two, *SlaveNumber::from(5), 4, {1, 2, 3, 4}},
      ParameterCommand{*SlaveNumber::from(5),
                       ParameterCommand::Kind::write_doubleword,
                       *ParameterNumber::from(300),
                       kValueElement,
                       77,
                       {}},
      TransferReply{*SlaveNumber::from(5), *BlockOffset::from(600), false, false, 6, {1, 2, 3, 4, 5, 6}}};
  return list;
}

void telegram_encode(benchmark::State& state) {
  std::size_t i = 0;
  for (auto _ : state) {
    can::Frame frame = encode(telegrams()[i++ % 4]);
    benchmark::DoNotOptimize(frame);
  }
}
BENCHMARK(telegram_encode);

void telegram_decode(benchmark::State& state) {
  std::array<can::Frame, 4> frames;
  for (std::size_t i = 0; i < 4; ++i) frames[i] = encode(telegrams()[i]);
  std::size_t i = 0;
  for (auto _ : state) {
    Decoded decoded = decode(frames[i++ % 4]);
    benchmark::DoNotOptimize(decoded);
  }
}
BENCHMARK(telegram_decode);

}  // namespace
