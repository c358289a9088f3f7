#include "daemon/cansync/realtime/request_intake.h"

#include <chrono>
#include <cstddef>
#include <type_traits>
#include <utility>
#include <variant>

namespace cansyncd {

using cansync::Channel;
using cansync::Refusal;

namespace {

/// A reset that takes longer has got stuck.
constexpr can::Time kResetPatience = std::chrono::seconds(5);

/// True for the requests that get a terminal answer.
template <class T>
constexpr bool kAnswered = !std::is_same_v<T, cansync::ReferenceUpdate> && !std::is_same_v<T, Cancel> &&
                           !std::is_same_v<T, StopRelease>;

/// Calls `handler` with what the request is. Unlike std::visit it can by no means throw.
template <class Handler>
void dispatch(const Request& request, const Handler& handler) noexcept {
  [&]<std::size_t... I>(std::index_sequence<I...>) {
    ((request.index() == I ? handler(*std::get_if<I>(&request)) : void()), ...);
  }
  (std::make_index_sequence<std::variant_size_v<Request>>{});
}

}  // namespace

void RequestIntake::take(unsigned most) noexcept {
  Request request;
  for (unsigned i = 0; i < most && reporter_.can_take() && exchange_.requests.try_pop(request); ++i) {
    dispatch(request, [this](const auto& typed) noexcept {
      if constexpr (kAnswered<std::decay_t<decltype(typed)>>) reporter_.taken();
      handle(typed);
    });
  }
}

void RequestIntake::refuse_all_as_stopped() noexcept {
  constexpr auto kStopped = cansync::Outcome::master_stopped;
  if (mode_.reset_pending()) {
    mode_.forget_reset();
    reporter_.command_done(reset_, kStopped);
  }
  Request request;
  while (reporter_.can_take() && exchange_.requests.try_pop(request)) {
    dispatch(request, [this](const auto& typed) noexcept {
      using Typed = std::decay_t<decltype(typed)>;
      if constexpr (kAnswered<Typed>) reporter_.taken();
      if constexpr (std::is_same_v<Typed, cansync::ParameterRequest>) {
        reporter_.parameter_done(typed.id, {.outcome = kStopped});
      } else if constexpr (std::is_same_v<Typed, cansync::TransferRequest>) {
        reporter_.transfer_done(typed.id, {.outcome = kStopped});
      } else if constexpr (kAnswered<Typed>) {
        reporter_.command_done(typed.id, kStopped);
      }
    });
  }
}

/// Parameter, transfer, control word, broadcast: the master answers when the job ends.
template <class Job>
void RequestIntake::handle(const Job& job) noexcept {
  const Refusal refusal = master_.submit(job);
  if (refusal != Refusal::none) reporter_.refused(job.id, refusal);
}

void RequestIntake::handle(const cansync::ReferenceUpdate& update) noexcept {
  const bool led = lead_ != nullptr && lead_->gives(update.channel);
  const Refusal refusal = led ? Refusal::lead_axis : master_.submit(update);
  if (refusal != Refusal::none) {
    reporter_.report(ReferenceRefused{reporter_.moment(), update.channel, refusal, {}});
  }
}

void RequestIntake::handle(const Cancel& cancel) noexcept {
  // The job answers; one that is not open has answered already.
  static_cast<void>(master_.cancel(cancel.id));
}

void RequestIntake::handle(const StopRelease& stop) noexcept {
  if (lead_ != nullptr && lead_->gives(stop.channel)) return;
  master_.stop_release(stop.channel, stop.hold);
}

void RequestIntake::handle(const ModeRequest& request) noexcept {
  const bool reset_before = mode_.reset_pending();
  const Refusal refusal = mode_.request(request.mode, request.force);
  if (mode_.reset_pending() && !reset_before) {
    reset_ = request.id;
    reset_begun_ = reporter_.moment().bus;
  } else {
    answer(request.id, refusal);
  }
}

void RequestIntake::finish_reset() noexcept {
  if (!mode_.reset_pending()) return;
  if (const auto refusal = mode_.finish_reset()) {
    answer(reset_, *refusal);
  } else if (reporter_.moment().bus - reset_begun_ > kResetPatience) {
    mode_.forget_reset();
    answer(reset_, Refusal::bus_unavailable);
  }
}

void RequestIntake::handle(const SetPolling& request) noexcept {
  const auto before = master_.settings().process.polling;
  Refusal refusal = Refusal::none;
  for (const Channel channel : {Channel::one, Channel::two}) {
    const auto& cursor = request.polling[index(channel)];
    if (cursor && refusal == Refusal::none) refusal = master_.set_polling(channel, *cursor);
  }
  if (refusal == Refusal::none) {
    if (request.maximum_slave) master_.set_maximum_slave(*request.maximum_slave);
  } else {
    // All or nothing: the first channel may have changed already.
    static_cast<void>(master_.set_polling(Channel::one, before[index(Channel::one)]));
  }
  answer_setting(request.id, refusal);
}

void RequestIntake::handle(const SetCursors& request) noexcept {
  const auto& now = master_.settings().command_channel;
  const cansync::Cursor control_word = request.control_word.value_or(now.control_word);
  const cansync::Cursor parameter = request.parameter.value_or(now.parameter);
  const cansync::Cursor transfer = request.transfer.value_or(now.transfer);
  answer_setting(request.id, master_.set_command_cursors(control_word, parameter, transfer));
}

void RequestIntake::handle(const SetReferenceMapping& request) noexcept {
  const auto& now = master_.settings().process.reference_mapping;
  const auto led = [&](Channel channel) {
    return lead_ != nullptr && lead_->gives(channel) &&
           request.mapping[index(channel)] != now[index(channel)];
  };
  // The file was looked at for what the lead axis gives: that no doubleword becomes a word, and none is lost.
  const bool refused = led(Channel::one) || led(Channel::two);
  answer_setting(request.id, refused ? Refusal::lead_axis : master_.set_reference_mapping(request.mapping));
}

void RequestIntake::handle(const SetActualMapping& request) noexcept {
  answer_setting(request.id, master_.set_actual_mapping(request.slave, request.mapping));
}

void RequestIntake::handle(const SetReferenceLimits& request) noexcept {
  master_.set_reference_limits(request.value, request.limits);
  answer_setting(request.id, Refusal::none);
}

void RequestIntake::handle(const ReleaseSlave& request) noexcept {
  answer(request.id, master_.release(request.slave, request.force));
}

void RequestIntake::answer(cansync::JobId id, Refusal refusal) noexcept {
  if (refusal == Refusal::none) {
    reporter_.command_done(id, cansync::Outcome::done);
  } else {
    reporter_.refused(id, refusal);
  }
}

void RequestIntake::answer_setting(cansync::JobId id, Refusal refusal) noexcept {
  if (refusal == Refusal::none) publish_settings();
  answer(id, refusal);
}

void RequestIntake::publish_settings() noexcept {
  const SettingsSnapshot snapshot{cansync::in_force(master_.settings()), master_.mapping_number()};
  exchange_.settings.write(snapshot);
  reporter_.written();
}

}  // namespace cansyncd
