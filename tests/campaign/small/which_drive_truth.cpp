#include "small/which_drive_truth.h"

#include <algorithm>
#include <variant>

#include "cansync/telegram/reply_payload.h"

namespace cansyncd::campaign {
namespace {

constexpr const char* kReleased = "nothing_is_released_to_a_drive_that_is_not_the_one_expected";
constexpr const char* kEnabled = "no_word_that_enables_to_a_drive_that_is_not_the_one_expected";
constexpr const char* kTwice = "nothing_begins_with_two_drives_of_one_number";

std::string who(const DriveSeen& drive) {
  return "the drive with serial number " + std::to_string(drive.unit->serial) + " as slave " +
         std::to_string(drive.unit->number);
}

template <class T>
const T* as(const std::optional<cansync::Telegram>& telegram) noexcept {
  return telegram ? std::get_if<T>(&*telegram) : nullptr;
}

std::optional<cansync::Telegram> telegram_of(const can::Frame& frame) {
  const cansync::Decoded decoded = cansync::decode(frame);
  const auto* telegram = std::get_if<cansync::Telegram>(&decoded);
  return telegram != nullptr ? std::optional(*telegram) : std::nullopt;
}

}  // namespace

WhichDriveTruth::WhichDriveTruth(const WhichDrivePlan& plan)
    : plan_(plan), last_reference_(-std::chrono::hours(1)) {
  activated_.fill(-std::chrono::hours(1));
  left_.fill(-std::chrono::hours(1));
  for (const Unit& unit : plan.units) {
    DriveSeen drive;
    drive.unit = &unit;
    drive.expected = plan.expected(unit);
    drives.push_back(drive);
  }
  const auto& slaves = plan.line.settings.slaves;
  expects_ =
      std::any_of(slaves.begin(), slaves.end(), [](const auto& slave) { return slave.expect_count != 0; });
}

void WhichDriveTruth::violated(const char* invariant, const std::string& what, can::Time now) {
  if (violation_) return;
  violation_ = Violation{invariant, what, static_cast<std::uint64_t>(now / plan_.line.interval())};
}

void WhichDriveTruth::sent(std::size_t drive, const can::Frame& frame, can::Time end) noexcept {
  drives[drive].last_sent = frame;
  drives[drive].last_end = end;
}

void WhichDriveTruth::received(const can::Frame& frame, can::Time end) noexcept {
  const auto telegram = telegram_of(frame);
  const auto* reply = as<cansync::ParameterReply>(telegram);
  if (reply == nullptr) return;
  ++answers_[reply->slave.value()];
  if (reply->number.value() != sim::parameter::status_word || reply->busy || reply->error) return;
  for (DriveSeen& drive : drives) {
    if (!drive.plugged || drive.last_end != end || drive.last_sent != frame) continue;
    drive.told = std::min(drive.told, end);
    const auto word = cansync::read_answer(*reply);
    drive.told_synchronized = word && (word->value & sim::status_bit::synchronized) != 0;
  }
}

unsigned WhichDriveTruth::plugged(unsigned number) const noexcept {
  return static_cast<unsigned>(std::count_if(drives.begin(), drives.end(), [number](const DriveSeen& drive) {
    return drive.plugged && drive.unit->number == number;
  }));
}

bool WhichDriveTruth::twin(const DriveSeen& drive) const noexcept {
  return plugged(drive.unit->number) > 1;
}

bool WhichDriveTruth::judged(const DriveSeen& drive) const noexcept {
  return drive.plugged && !drive.expected;
}

void WhichDriveTruth::plugged_in(DriveSeen& drive, can::Time now) noexcept {
  drive.plugged = true;
  const can::Time absence = now - left_[drive.unit->number];
  drive.unnoticed = absence < static_cast<can::Time::rep>(kShortestAbsence) * plan_.line.interval();
  drive.hidden = twin(drive) && now - activated_[drive.unit->number] < 2 * plan_.line.interval();
}

void WhichDriveTruth::unplugged(DriveSeen& drive, can::Time now) noexcept {
  const unsigned number = drive.unit->number;
  drive.plugged = false;
  if (!drive.told_synchronized) left_[number] = now;
  for (DriveSeen& other : drives) {
    if (!other.plugged || other.unit->number != number) continue;
    // What it said beside the other one is not known to be its own.
    other.told = can::Time::max();
    other.unnoticed = !drive.told_synchronized && doubles_[number] < kHidden;
  }
}

void WhichDriveTruth::question(unsigned number) noexcept {
  if (plugged(number) < 2) {
    doubles_[number] = 0;
  } else if (answers_[number] == 0) {
    doubles_[number] = 0;  // neither is heard: they may be gone
  } else if (answers_[number] > 1) {
    ++doubles_[number];
  }
  answers_[number] = 0;
}

void WhichDriveTruth::handed_over(const can::Frame& frame, can::Time now) {
  const auto telegram = telegram_of(frame);
  if (const auto* command = as<cansync::ParameterCommand>(telegram)) return question(command->slave.value());
  if (as<cansync::ReferenceTelegram>(telegram) != nullptr) return references(now);
  const auto* action = as<cansync::ActionCommand>(telegram);
  if (action == nullptr) return;
  const cansync::StartupSettings& startup = plan_.line.settings.startup;
  if (action->command == startup.activate_command) activation(*action, now);
  if (action->command == cansync::kCommandControlWord && cansync::enables(startup, action->data_word))
    enabling(*action, now);
}

void WhichDriveTruth::activation(const cansync::ActionCommand& action, can::Time now) {
  ++met["activations"];
  if (expects_ && (action.slaves.bits & ~plan_.line.settings.configured().bits) != 0)
    violated(kReleased, "a number that is not configured is activated", now);
  for (DriveSeen& drive : drives) {
    const unsigned number = drive.unit->number;
    if (action.slaves.has(*cansync::SlaveNumber::from(number))) activated_[number] = now;
    if (!judged(drive) || !action.slaves.has(*cansync::SlaveNumber::from(number))) continue;
    drive.hidden = twin(drive) && doubles_[number] + (answers_[number] > 1 ? 1 : 0) < kHidden;
    if (!drive.hidden) violated(kReleased, who(drive) + " is activated", now);
  }
}

void WhichDriveTruth::enabling(const cansync::ActionCommand& action, can::Time now) {
  ++met["words_that_enable"];
  for (const DriveSeen& drive : drives) {
    if (!drive.plugged || !action.slaves.has(*cansync::SlaveNumber::from(drive.unit->number))) continue;
    if (doubles_[drive.unit->number] >= kDoubles)
      violated(kTwice, "a word that enables, to " + who(drive), now);
    if (!judged(drive) || twin(drive) || drive.unnoticed || drive.hidden) continue;
    ++met["words_that_enable_before_a_status_word"];
    if (drive.told < now) violated(kEnabled, who(drive), now);
  }
}

void WhichDriveTruth::references(can::Time now) {
  const bool begins = now - last_reference_ > 10 * plan_.line.interval();
  last_reference_ = now;
  if (begins) ++met["run_begun"];
  for (const DriveSeen& drive : drives) {
    if (!drive.plugged) continue;
    // One that did not answer last may be lost, and run begins without it.
    if (begins && answers_[drive.unit->number] != 0 && doubles_[drive.unit->number] >= kDoubles)
      violated(kTwice, "run begins with " + who(drive), now);
    if (judged(drive) && !drive.synchronized) ++met["reference_values_beside_a_drive_that_is_not_expected"];
    if (judged(drive) && drive.synchronized && !drive.hidden)
      violated(kReleased, who(drive) + " takes reference values", now);
  }
}

}  // namespace cansyncd::campaign
