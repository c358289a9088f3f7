// The clients: what they ask for, and that they leave.
#include <algorithm>
#include <iterator>

#include "player.h"

namespace cansyncd::campaign {

using cansync::SlaveNumber;

namespace {

/// Numbers that clients read and try to write in vain.
constexpr std::uint16_t kReadOnly[] = {sim::parameter::device_type,      sim::parameter::firmware_version,
                                       sim::parameter::slave_number,     sim::parameter::status_word,
                                       sim::parameter::position,         sim::parameter::not_available,
                                       sim::parameter::position_setpoint};

/// The realtime thread takes so many requests before a slot.
constexpr std::size_t kTakenAtOnce = 30;

std::string slave_text(SlaveNumber slave) {
  return " slave " + std::to_string(slave.value());
}

}  // namespace

Job Player::new_job(Job::Kind kind) {
  Job job;
  job.id = stage_.ledger.next_id();
  job.kind = kind;
  job.client = static_cast<unsigned>(dice_.below(kClients));
  job.pushed = stage_.line.intervals();
  return job;
}

/// Nearly always one that is there.
SlaveNumber Player::any_slave() {
  if (dice_.chance(20)) return *SlaveNumber::from(dice_.below(cansync::kSlaves));
  return stage_.plan.drives[dice_.below(stage_.plan.drives.size())].slave.number;
}

void Player::ask(std::uint64_t /*tick*/) {
  const Mix& mix = stage_.plan.mix;
  if (dice_.chance(mix.parameters)) ask_parameter();
  if (dice_.chance(mix.transfers)) ask_transfer();
  if (dice_.chance(mix.control_words)) ask_control_word();
  if (dice_.chance(mix.broadcasts)) ask_broadcast();
  if (dice_.chance(mix.settings)) ask_setting();
  if (dice_.chance(mix.modes)) ask_mode();
  if (dice_.chance(mix.cancels)) cancel_one();
  if (dice_.chance(mix.departures)) depart();
  if (dice_.chance(mix.bursts)) burst();
  if (mix.stop_words != 0 && dice_.chance(mix.stop_words)) ask_stop_word();
}

void Player::ask_parameter() {
  constexpr cansync::ParameterFormat kFormats[] = {cansync::ParameterFormat::as_slave_says,
                                                   cansync::ParameterFormat::word,
                                                   cansync::ParameterFormat::doubleword};
  Job job = new_job(Job::Kind::parameter);
  cansync::ParameterRequest& request = job.parameter;
  request.id = job.id;
  request.slave = any_slave();
  request.write = dice_.chance(500);
  const std::uint16_t number =
      dice_.chance(700) ? dice_.one_of(ParameterTruth::kWritten) : dice_.one_of(kReadOnly);
  request.number = *cansync::ParameterNumber::from(number);
  request.format = dice_.one_of(kFormats);
  request.value = static_cast<std::uint32_t>(dice_.next());
  if (dice_.chance(600)) request.value &= 0xFFFF;
  if (!request.write && dice_.chance(50)) request.element = *cansync::Element::from(dice_.below(8));
  if (dice_.chance(20)) request.sub_slave.value = 7;
  if (dice_.chance(100)) request.monitoring_time = dice_.between(1, 40) * stage_.plan.interval();
  const bool pushed = push(request, &job,
                           (request.write ? "write " + std::to_string(request.value) + " to " : "read ") +
                               std::to_string(number) + slave_text(request.slave));
  if (pushed) stage_.parameters.pushed(request);
}

void Player::ask_transfer() {
  Job job = new_job(Job::Kind::transfer);
  job.slave = any_slave();
  if (drive_of(job.slave) == nullptr) return;
  job.download = dice_.chance(500);
  const std::uint8_t step = stage_.plan.settings.command_channel.address_step;
  job.bytes = static_cast<std::uint32_t>(dice_.chance(800) ? dice_.between(1, 200)
                                                           : dice_.between(1, MemoryTruth::kPlaceBytes));
  const auto request = stage_.memories.draw(job.id, job.slave, job.download, job.bytes, step, dice_);
  if (!request) return;
  const bool pushed = push(*request, &job,
                           (job.download ? "download of " : "upload of ") + std::to_string(job.bytes) +
                               " bytes at " + std::to_string(request->address) + slave_text(job.slave));
  if (!pushed) {
    stage_.memories.answered(job.id, {}, true, *drive_of(job.slave), stage_.line.intervals());
  }
}

void Player::command(const Job& job, const Request& request, const std::string& text) {
  push(request, &job, text);
}

/// Nothing can stand before a request that is pushed now, and its answer has room.
bool Player::taken_soon() const noexcept {
  return stage_.exchange.requests.size() < kTakenAtOnce &&
         stage_.exchange.terminals.room() > stage_.ledger.open().size() + 1;
}

void Player::ask_control_word() {
  constexpr std::uint16_t kWords[] = {0x0007, 0x0007, 0x0000, 0x0006, 0x0087};
  const Job job = new_job(Job::Kind::command);
  const cansync::ControlWordRequest request{job.id, any_slave(), dice_.one_of(kWords)};
  const bool soon = taken_soon();
  if (!push(request, &job, "control word" + slave_text(request.slave))) return;
  // None of them has all enabling bits: each is one that stops.
  stage_.witness.stops.pushed(job.id, request.slave, request.control_word, soon);
}

void Player::ask_stop_word() {
  constexpr std::uint16_t kWords[] = {0x0000, 0x0006};
  const Job job = new_job(Job::Kind::command);
  const cansync::ControlWordRequest request{job.id, any_slave(), dice_.one_of(kWords)};
  const bool soon = taken_soon();
  if (stage_.exchange.requests.size() == stage_.exchange.requests.capacity()) return;
  stage_.witness.stops.pushed(job.id, request.slave, request.control_word, soon);
  const std::uint64_t later = stage_.tamper != nullptr ? stage_.tamper->held_back(request) : 0;
  if (later != 0) {
    stage_.ledger.opened(job);
    stage_.words.pushed(job.id, request);
    held_back_.emplace_back(stage_.line.intervals() + later, request);
    return;
  }
  command(job, request, "control word that stops" + slave_text(request.slave));
}

void Player::hand_on_held_back() {
  while (!held_back_.empty() && held_back_.front().first <= stage_.line.intervals()) {
    if (!push(held_back_.front().second, nullptr, "control word held back")) return;
    held_back_.erase(held_back_.begin());
  }
}

void Player::ask_broadcast() {
  const Job job = new_job(Job::Kind::command);
  cansync::BroadcastRequest request;
  request.id = job.id;
  request.priority = static_cast<std::uint8_t>(dice_.chance(20) ? 3 : dice_.below(3));
  request.action.slaves.bits = static_cast<std::uint32_t>(dice_.next());
  request.action.command = static_cast<std::uint8_t>(dice_.chance(500) ? 1 : dice_.between(128, 255));
  request.action.data_word = 7;
  command(job, request, "broadcast " + std::to_string(request.priority));
}

void Player::ask_setting() {
  const Job job = new_job(Job::Kind::setting);
  const cansync::Cursor automatic;
  const cansync::Cursor fixed{cansync::Cursor::Kind::fixed, any_slave()};
  switch (dice_.below(4)) {
    case 0:
      command(job, SetPolling{job.id, {dice_.chance(500) ? automatic : fixed, automatic}, {}}, "polling");
      break;
    case 1:
      command(job, SetCursors{job.id, automatic, dice_.chance(500) ? automatic : fixed, automatic},
              "cursors");
      break;
    case 2:
      command(job, SetReferenceMapping{job.id, draw_reference_mapping(dice_)}, "reference mapping");
      break;
    default: {
      const SlaveNumber slave = any_slave();
      command(job, SetActualMapping{job.id, slave, draw_mapping(dice_)},
              "actual mapping" + slave_text(slave));
      break;
    }
  }
}

void Player::ask_mode() {
  constexpr Mode kModes[] = {Mode::set_up, Mode::run, Mode::stop, Mode::reset_can, Mode::restart};
  ask_for_mode(dice_.one_of(kModes), dice_.chance(500));
}

void Player::cancel_one() {
  const auto& open = stage_.ledger.open();
  cansync::JobId id = dice_.below(1000) + 1;
  if (!open.empty() && dice_.chance(950)) {
    id = std::next(open.begin(), static_cast<std::ptrdiff_t>(dice_.below(open.size())))->first;
  }
  push(Cancel{id}, nullptr, "cancel " + std::to_string(id));
}

void Player::depart() {
  const auto client = static_cast<unsigned>(dice_.below(kClients));
  std::vector<cansync::JobId> left;
  for (const auto& [id, job] : stage_.ledger.open()) {
    if (job.client == client) left.push_back(id);
  }
  for (const cansync::JobId id : left) push(Cancel{id}, nullptr, "cancel " + std::to_string(id));
  if (client != writer_ || writers_) return;
  withdraw();
  writer_ = static_cast<unsigned>(dice_.below(kClients));
  writer_back_ = stage_.line.intervals() + dice_.below(60);
}

void Player::burst() {
  for (std::uint64_t left = dice_.between(1, 300); left > 0; --left) ask_parameter();
}

}  // namespace cansyncd::campaign
