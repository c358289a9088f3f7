#include "cansync/cluster/cluster.h"

#include <variant>

namespace cansync {
namespace {

constexpr std::uint8_t kAllWords = (1u << kWords) - 1;

}  // namespace

std::string_view name(ClusterState state) noexcept {
  switch (state) {
    case ClusterState::stopped:
      return "stopped";
    case ClusterState::waiting_for_sync:
      return "waiting_for_sync";
    case ClusterState::setting_up:
      return "setting_up";
    case ClusterState::active:
      break;
  }
  return "active";
}

Cluster::Cluster(const ClusterSettings& settings)
    : settings_(settings),
      gateway_(settings.gateway, slot_times(settings.lower.bit_rate).interval),
      upper_(settings.upper, gateway_),
      lower_(settings.lower, gateway_),
      lead_(settings.lead, settings.lower.bit_rate, settings.lower.send_margin, settings.lead_reserve) {
  gateway_.attach(lower_);
}

Cluster::Cluster(const ClusterSettings& settings, SlaveApplication& own, MasterListener& below)
    : Cluster(settings) {
  serve(own);
  tell(below);
}

// --- states (O 7.1.2)

void Cluster::start() noexcept {
  if (started_) return;
  started_ = true;
  static_cast<void>(upper_.control(ControlCommand::handshake));
  static_cast<void>(upper_.control(ControlCommand::take_over_initialisation));
  initialise_lower();
  static_cast<void>(upper_.control(ControlCommand::start_synchronous));
  if (settings_.enable_upper) static_cast<void>(upper_.control(ControlCommand::enable_active));
}

void Cluster::initialise_lower() noexcept {
  static_cast<void>(lower_.control(ControlCommand::handshake));
  static_cast<void>(lower_.control(ControlCommand::take_over_initialisation));
}

void Cluster::stop() noexcept {
  started_ = false;
  static_cast<void>(lower_.control(ControlCommand::cold_restart));
  static_cast<void>(upper_.control(ControlCommand::cold_restart));
  gateway_.forget();
}

bool Cluster::sync_allowed() const noexcept {
  if (!is_synchronous(upper_.state())) return false;
  return is_synchronous(lower_.state()) ? sync_ != UpperSync::lost : sync_ == UpperSync::locked;
}

void Cluster::decide_sync() noexcept {
  const bool runs = is_synchronous(lower_.state());
  if (runs && !sync_allowed()) {
    ++sync_losses_;
    // Its jobs end, and are answered above.
    static_cast<void>(lower_.control(ControlCommand::cold_restart));
    initialise_lower();
  } else if (started_ && !runs && sync_allowed()) {
    initialise_lower();
    static_cast<void>(lower_.control(ControlCommand::start_synchronous));
  }
}

ClusterState Cluster::state() const noexcept {
  if (lower_.state() == State::start_up) return ClusterState::stopped;
  if (!is_synchronous(lower_.state())) return ClusterState::waiting_for_sync;
  return is_active(lower_.state()) ? ClusterState::active : ClusterState::setting_up;
}

// --- the interval

void Cluster::begin_interval(IntervalNumber now) noexcept {
  begin_above(now);
  decide_sync();
  begin_below(now);
}

void Cluster::begin_above(IntervalNumber now) noexcept {
  const IntervalNumber passed = first_ || now <= now_ ? 1 : now - now_;
  first_ = false;
  now_ = now;
  lead_.begin_interval(now);
  upper_.on_sync(passed);
  gateway_.begin_interval(now);
}

void Cluster::begin_below(IntervalNumber now) noexcept {
  if (!sync_output()) return lower_.pass_interval(now);
  lower_.begin_interval(now);
  if (started_ && settings_.enable_lower && lower_.state() == State::setting_up_master)
    static_cast<void>(lower_.control(ControlCommand::enable_active));
}

// --- the upper bus

std::optional<SlaveAnswer> Cluster::receive_above(const can::Frame& frame, Duration since_sync) noexcept {
  const Decoded decoded = decode(frame);
  const auto* telegram = std::get_if<Telegram>(&decoded);
  if (telegram == nullptr) return std::nullopt;
  return receive_above(*telegram, since_sync);
}

std::optional<SlaveAnswer> Cluster::receive_above(const Telegram& telegram, Duration since_sync) noexcept {
  const auto* actual = std::get_if<ActualTelegram>(&telegram);
  const std::uint32_t before = actual != nullptr ? upper_.monitored_count(actual->slave, actual->channel) : 0;
  const auto answer = upper_.receive(telegram, since_sync);
  // While the timeline moves, an interval of it is none of the upper bus.
  if (!tracking() || !is_active(upper_.state())) return answer;
  const SlaveSideSettings& settings = upper_.settings();
  if (const auto* reference = std::get_if<ReferenceTelegram>(&telegram)) {
    lead_.took_references(reference->channel, reference->words, settings.reference_mapping,
                          upper_.references(), since_sync);
  } else if (actual != nullptr && upper_.monitored_count(actual->slave, actual->channel) != before) {
    lead_.took_monitored(actual->slave, actual->channel, actual->words,
                         *settings.monitored[actual->slave.value()], upper_.monitored(actual->slave),
                         since_sync);
  }
  return answer;
}

void Cluster::release_actual(Channel channel, const Values& values) noexcept {
  upper_.release_actual(channel, values);
  lead_.released(channel, kAllWords, values);
}

// --- the lower bus

std::optional<can::Frame> Cluster::take(Slot slot) noexcept {
  // A slot below that is late, after the next edge, must not take what belongs to the interval of that edge.
  const bool in_this_interval = lower_.interval() == now_;
  if (slot != Slot::command && in_this_interval && is_active(lower_.state())) {
    return take_reference(slot == Slot::reference_one ? Channel::one : Channel::two, slot);
  }
  const auto frame = lower_.take(slot);
  if (slot == Slot::command && frame) gateway_.sent_below(*frame);
  return frame;
}

std::optional<can::Frame> Cluster::take_reference(Channel channel, Slot slot) noexcept {
  const std::uint64_t beyond_limits = lower_.release(channel).beyond_limits;
  bool refused = false;
  if (auto update = lead_.take(channel)) {
    update->mapping_number = lower_.mapping_number();
    refused = lower_.submit(*update) != Refusal::none;
  }
  const auto frame = lower_.take(slot);
  // Limits are checked when the telegram is made.
  if (lead_.gives(channel) && (refused || lower_.release(channel).beyond_limits != beyond_limits))
    lead_.refused(channel);
  return frame;
}

}  // namespace cansync
