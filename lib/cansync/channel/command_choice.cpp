#include <algorithm>
#include <bit>
#include <limits>

#include "cansync/channel/command_channel.h"

/// The command channel's choice: which one command goes out in an interval.
namespace cansync {

std::optional<SlaveNumber> CommandChannel::next_slave(const Scan& scan, SlaveMask waiting) const noexcept {
  if (waiting.empty() || scan.cursor.kind == Cursor::Kind::nobody) return std::nullopt;
  if (scan.cursor.kind == Cursor::Kind::fixed) {
    return waiting.has(scan.cursor.slave) ? std::optional(scan.cursor.slave) : std::nullopt;
  }
  if (settings_.serving == Serving::scan) {
    const SlaveNumber slave = *SlaveNumber::from(scan.rising);
    return waiting.has(slave) ? std::optional(slave) : std::nullopt;
  }
  return next_in_turn(scan, waiting);
}

/// Round robin: the first that waits after the one served last.
std::optional<SlaveNumber> CommandChannel::next_in_turn(const Scan& scan, SlaveMask waiting) const noexcept {
  if (waiting.empty()) return std::nullopt;
  const unsigned first = scan.last + 1u;
  const int steps = std::countr_zero(std::rotr(waiting.bits, static_cast<int>(first % kSlaves)));
  return SlaveNumber::from((first + static_cast<unsigned>(steps)) % kSlaves);
}

bool CommandChannel::share_due(const Scan& scan, SlaveMask waiting) const noexcept {
  return settings_.minimum_share != 0 && !waiting.empty() && scan.passed_over + 1 >= settings_.minimum_share;
}

void CommandChannel::count_share(Scan& scan, SlaveMask waiting, bool served) noexcept {
  if (served || waiting.empty()) {
    scan.passed_over = 0;
  } else if (scan.passed_over < std::numeric_limits<std::uint32_t>::max() - 1) {
    ++scan.passed_over;
  }
}

std::optional<Telegram> CommandChannel::take() noexcept {
  settle_unanswered();
  check_times();
  chosen_.kind = Kind::none;
  choose();
  if (chosen_.kind != Kind::none) return chosen_.telegram;
  count_shares(Kind::none);
  return std::nullopt;
}

void CommandChannel::count_shares(Kind served) noexcept {
  count_share(parameter_scan_, parameters_.waiting(), served == Kind::parameter);
  count_share(transfer_scan_, transfers_waiting(), served == Kind::transfer);
  count_share(check_scan_, supervision_.checking(), served == Kind::check);
  count_share(supervision_scan_, pressing(), served == Kind::supervision);
}

void CommandChannel::left_out() noexcept {
  if (chosen_.kind != Kind::none) count_shares(Kind::none);
  chosen_.kind = Kind::none;
}

SlaveMask CommandChannel::pressing() const noexcept {
  return supervision_.pressing() ? SlaveMask::all() : SlaveMask{};
}

void CommandChannel::choose() noexcept {
  if (stops_gave_way_ && choose_stop({})) return;
  if (choose_broadcast(0)) return;
  if (choose_stop(stopped_in_a_row_)) return;
  if (supervision_.urgent() && choose_supervision()) return;
  if (choose_cancel() || choose_due_share()) return;
  if (choose_broadcast(1) || choose_broadcast(2) || choose_stop({}) || choose_control_word()) return;
  if (choose_parameter() || choose_transfer() || choose_check()) return;
  if (!census_gives_way_ && choose_census()) return;
  if (!choose_supervision()) choose_census();
}

/// What has been passed over longest comes first: while words that stop are given without end, there is not
/// room for every share that is due.
bool CommandChannel::choose_due_share() noexcept {
  struct Share {
    const Scan& scan;
    SlaveMask waiting;
    bool (CommandChannel::*choose)() noexcept;
    bool tried = false;
  };
  std::array<Share, 4> shares = {{
      {supervision_scan_, pressing(), &CommandChannel::choose_supervision},
      {parameter_scan_, parameters_.waiting(), &CommandChannel::choose_parameter},
      {transfer_scan_, transfers_waiting(), &CommandChannel::choose_transfer},
      {check_scan_, supervision_.checking(), &CommandChannel::choose_check},
  }};
  for (std::size_t round = 0; round < shares.size(); ++round) {
    Share* longest = nullptr;
    for (Share& share : shares) {
      if (share.tried || !share_due(share.scan, share.waiting)) continue;
      if (longest == nullptr || share.scan.passed_over > longest->scan.passed_over) longest = &share;
    }
    if (longest == nullptr) return false;
    longest->tried = true;
    if ((this->*longest->choose)()) return true;
  }
  return false;
}

/// What a control word ends with that was taken and would be refused by now.
Outcome CommandChannel::ended_by(Refusal refused) noexcept {
  return refused == Refusal::slave_lost ? Outcome::slave_lost : Outcome::slave_held;
}

bool CommandChannel::choose_broadcast(std::uint8_t priority) noexcept {
  auto& queue = broadcasts_[priority];
  // Since it was taken a slave may have been lost or held out.
  for (; !queue.empty(); queue.pop()) {
    const Refusal refused = enabling_refused(queue.front().request.action);
    if (refused == Refusal::none) break;
    listener_.command_done(queue.front().request.id, ended_by(refused));
  }
  if (queue.empty()) return false;
  chosen_ = {Kind::broadcast, {}, priority, queue.front().request.action};
  return true;
}

/// The word that has waited longest of those that wait for no cursor, so that none given later is sent before
/// it; not when it is of one of the slaves that give way.
bool CommandChannel::choose_stop(SlaveMask giving_way) noexcept {
  for (auto slave = control_words_.oldest_passing(); slave && !giving_way.has(*slave);
       slave = control_words_.oldest_passing()) {
    if (choose_word_of(*slave)) return true;
  }
  return false;
}

bool CommandChannel::choose_control_word() noexcept {
  while (const auto slave = next_slave(control_word_scan_, control_words_.waiting())) {
    if (choose_word_of(*slave)) return true;
  }
  return false;
}

/// False: the slave must not have it any more, and it is ended.
bool CommandChannel::choose_word_of(SlaveNumber slave) noexcept {
  const ActionCommand action = action_of(control_words_.of(slave).request);
  const Refusal refused = enabling_refused(action);
  if (refused == Refusal::none) {
    chosen_ = {Kind::control_word, slave, 0, action};
    return true;
  }
  listener_.command_done(control_words_.remove(slave), ended_by(refused));
  return false;
}

bool CommandChannel::choose_parameter() noexcept {
  const SlaveMask waiting = parameters_.waiting();
  const std::uint32_t passed_over = supervision_.busy_with_checks().bits | late_answer_may_come().bits;
  const auto slave = next_slave(parameter_scan_, {waiting.bits & ~passed_over});
  if (!slave) return false;
  chosen_ = {Kind::parameter, *slave, 0, parameters_.front(*slave)->telegram()};
  return true;
}

/// An answer names its parameter and not its job: that of a write which came too late would confirm the next job
/// of the same parameter, which the slave may refuse.
void CommandChannel::note_late_answer(const ParameterJob& job) noexcept {
  const Outcome outcome = job.result().outcome;
  const bool unanswered =
      outcome == Outcome::no_answer || outcome == Outcome::taken || outcome == Outcome::timeout;
  if (!job.request().write || !unanswered) return;
  late_answers_[job.request().slave.value()] = {job.request().number, now_ + kLateIntervals};
}

/// Slaves whose next job is of the parameter whose late answer may still come.
SlaveMask CommandChannel::late_answer_may_come() const noexcept {
  SlaveMask slaves;
  for (const SlaveNumber slave : parameters_.waiting()) {
    const LateAnswer& late = late_answers_[slave.value()];
    if (now_ < late.until && parameters_.front(slave)->request().number == late.number) slaves.set(slave);
  }
  return slaves;
}

bool CommandChannel::choose_transfer() noexcept {
  const auto slave = next_slave(transfer_scan_, transfers_waiting());
  if (!slave) return false;
  chosen_ = {Kind::transfer, *slave, 0, transfers_.front(*slave)->telegram()};
  return true;
}

/// Transfers wait until the slave has been told to forget what it may have open, and for late answers.
SlaveMask CommandChannel::transfers_waiting() const noexcept {
  SlaveMask slaves{transfers_.waiting().bits & ~open_transfers_.unknown().bits};
  for (const SlaveNumber slave : slaves) {
    const TransferJob& job = *transfers_.front(slave);
    const bool cancel_first = now_ < late_cancels_[slave.value()] && !job.cancelling();
    if (now_ < job.not_before() || cancel_first) slaves.set(slave, false);
  }
  return slaves;
}

/// The answer to a cancel telegram is also that to an initialise. One that has not come, or was perhaps that to an
/// earlier cancel, may still come.
void CommandChannel::note_late_cancel(const Chosen& asked) noexcept {
  const auto* initialise = std::get_if<TransferInitialise>(&asked.telegram);
  if (initialise != nullptr && *initialise == cancel_transfer(asked.slave))
    late_cancels_[asked.slave.value()] = now_ + kLateIntervals;
}

bool CommandChannel::choose_cancel() noexcept {
  const SlaveMask slaves{open_transfers_.unknown().bits & supervision_.responding().bits};
  if (slaves.empty()) return false;
  const SlaveNumber slave = *slaves.begin();
  chosen_ = {Kind::cancel, slave, 0, cancel_transfer(slave)};
  return true;
}

/// Another parameter command would be another job to such a slave (M 3.2.3.7, "change"): it forgets the one
/// it is busy with, and when the master asks again whether it is done, begins it anew and applies a write
/// twice. Ends at the latest with the job's monitoring time.
SlaveMask CommandChannel::busy_with_a_job() const noexcept {
  SlaveMask busy;
  for (const SlaveNumber slave : parameters_.waiting()) busy.set(slave, parameters_.front(slave)->busy());
  return busy;
}

bool CommandChannel::choose_check() noexcept {
  const SlaveMask checking = supervision_.checking();
  // No cursor is for lists: each slave's comes in turn, also where cursors scan.
  const auto slave = next_in_turn(check_scan_, {checking.bits & ~busy_with_a_job().bits});
  if (!slave) return false;
  chosen_ = {Kind::check, *slave, 0, supervision_.check_telegram(*slave)};
  return true;
}

/// Every other telegram at most while status words are due: who is on the line waits for no stranger.
bool CommandChannel::choose_census() noexcept {
  const auto slave = supervision_.next_of_census();
  if (!slave) return false;
  ParameterCommand command;
  command.slave = *slave;
  command.number =
      ParameterNumber::from(master_.slaves[slave->value()].status_parameter).value_or(ParameterNumber{});
  chosen_ = {Kind::census, *slave, 0, command};
  return true;
}

bool CommandChannel::choose_supervision() noexcept {
  const auto telegram =
      supervision_.telegram({busy_with_a_job().bits | supervision_.busy_with_checks().bits});
  if (!telegram) return false;
  const auto* command = std::get_if<ParameterCommand>(&*telegram);
  chosen_ = {Kind::supervision, command != nullptr ? command->slave : SlaveNumber{}, 0, *telegram};
  return true;
}

void CommandChannel::sent() noexcept {
  if (chosen_.kind != Kind::none) count_shares(chosen_.kind);
  asked_.kind = Kind::none;
  command_end_ = Duration(-1);
  const SlaveNumber slave = chosen_.slave;
  bool stopped = false;
  switch (chosen_.kind) {
    case Kind::none:
      return;
    case Kind::broadcast:
      echo_of_ = broadcasts_[chosen_.priority].front().request.id;
      broadcasts_[chosen_.priority].pop();
      break;
    case Kind::control_word:
      stopped = control_words_.passing().has(slave);
      echo_of_ = control_words_.remove(slave);
      control_word_scan_.last = slave.value();
      break;
    case Kind::parameter:
      parameters_.front(slave)->sent(now_);
      parameter_scan_.last = slave.value();
      asked_ = chosen_;
      break;
    case Kind::transfer:
      transfers_.front(slave)->sent(now_);
      transfer_scan_.last = slave.value();
      asked_ = chosen_;
      break;
    case Kind::cancel:
      asked_ = chosen_;
      break;
    case Kind::check:
      supervision_.check_sent(slave);
      check_scan_.last = slave.value();
      asked_ = chosen_;
      break;
    case Kind::census:
      supervision_.counted(slave);
      asked_ = chosen_;
      break;
    case Kind::supervision:
      supervision_.sent(chosen_.telegram);
      if (std::get_if<ParameterCommand>(&chosen_.telegram) != nullptr) asked_ = chosen_;
      break;
  }
  census_gives_way_ = chosen_.kind == Kind::census;
  chosen_.kind = Kind::none;
  if (!stopped) stopped_in_a_row_ = {};
  if (stopped) stopped_in_a_row_.set(slave);
  stops_gave_way_ = !stopped && !control_words_.passing().empty();
}

}  // namespace cansync
