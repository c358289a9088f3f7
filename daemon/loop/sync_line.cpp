#include "daemon/loop/sync_line.h"

#include <algorithm>

#include "sync/pps.h"
#include "sync/software_sync.h"

namespace cansyncd {
namespace {

/// Most edges taken from the input at once; a line that flutters must not hold the realtime thread up.
constexpr unsigned kEdgesAtOnce = 16;

sync_line::PhaseLockSettings lock_settings(const SyncConfig& config, can::Time interval) {
  sync_line::PhaseLockSettings settings;
  settings.interval = interval;
  settings.greatest_step = config.greatest_step > can::Time{0} ? config.greatest_step : interval / 1000;
  settings.holdover = config.holdover;
  if (config.input == SyncInput::pps) {
    settings.spacing = static_cast<std::uint32_t>(can::Time(std::chrono::seconds(1)) / interval);
  }
  return settings;
}

std::unique_ptr<sync_line::Input> make_input(const SyncConfig& config, sync_line::System& system) {
  switch (config.input) {
    case SyncInput::gpio:
      return std::make_unique<sync_line::GpioInput>(
          system, sync_line::GpioLine{config.input_gpio_chip, config.input_gpio_line, config.input_edge},
          "sync.input_gpio_chip", "sync.input_gpio_line");
    case SyncInput::pps:
      return std::make_unique<sync_line::PpsInput>(
          system, sync_line::PpsSource{config.pps_device, config.pps_edge}, "sync.pps_device");
    case SyncInput::can:
    case SyncInput::none:
      break;
  }
  return nullptr;
}

}  // namespace

SyncLine::SyncLine(const DaemonConfig& config, can::Time interval, sync_line::System& system)
    : config_(config.sync),
      bits_per_second_(config.bus.bits_per_second),
      system_(system),
      input_(make_input(config.sync, system)) {
  if (config_.output == SyncOutput::gpio) {
    gpio_.emplace(system, sync_line::GpioLine{config_.gpio_chip, config_.gpio_line, config_.edge},
                  "sync.gpio_chip", "sync.gpio_line");
  }
  if (config_.output == SyncOutput::phc) {
    const sync_line::PhcPin pin{config_.phc_device, config_.phc_pin, config_.phc_channel, config_.edge};
    clock_ = std::make_unique<sync_line::PhcOutput>(system, pin, interval);
  }
  if (config_.input != SyncInput::none || clock_) following_ = lock_settings(config_, interval);
}

void SyncLine::start() {
  if (clock_) clock_->start_thread();
}

void SyncLine::begin(can::Bus& bus) noexcept {
  // Both clocks tick alike; the narrowest of a few readings tells their distance.
  constexpr int kReadings = 5;
  can::Time narrowest = can::Time::max();
  for (int i = 0; i < kReadings; ++i) {
    const can::Time before = system_.monotonic();
    const can::Time on_bus = bus.now();
    const can::Time width = system_.monotonic() - before;
    if (width >= narrowest) continue;
    narrowest = width;
    bus_ahead_ = on_bus - before - width / 2;
  }
}

void SyncLine::edge(can::Bus& bus) noexcept {
  if (gpio_ && !gpio_->pulse()) ++output_failures_;
  if (config_.output != SyncOutput::can) return;
  frame_refused_ = bus.send(sync_line::software_sync(config_.can_identifier)) != can::SendResult::queued;
  if (frame_refused_) ++output_failures_;
}

void SyncLine::run(bool running) noexcept {
  if (clock_) clock_->want(running);
}

void SyncLine::idle() noexcept {
  if (gpio_) gpio_->idle();
}

bool SyncLine::take_frame(const can::ReceivedFrame& received, sync_line::PhaseLock* lock) noexcept {
  const bool output = config_.output == SyncOutput::can && received.own;
  const bool input = config_.input == SyncInput::can && !received.own;
  if (!output && !input) return false;
  if (!sync_line::is_software_sync(received.frame, config_.can_identifier)) return false;
  if (input && lock != nullptr) {
    lock->input(sync_line::edge_of(received, bits_per_second_) + config_.input_offset);
  }
  return true;
}

bool SyncLine::is_others(const can::ReceivedFrame& received) const noexcept {
  return config_.output == SyncOutput::can && !received.own &&
         sync_line::is_software_sync(received.frame, config_.can_identifier);
}

void SyncLine::follow(sync_line::PhaseLock& lock) noexcept {
  sync_line::Input* const input = clock_ ? clock_.get() : input_.get();
  if (input == nullptr) return;
  can::Time at{0};
  const can::Time offset = bus_ahead_ + config_.input_offset;
  for (unsigned i = 0; i < kEdgesAtOnce && input->take(lock.next() - offset, at); ++i) {
    lock.input(at + offset);
  }
}

int SyncLine::output_error() const noexcept {
  if (gpio_) return gpio_->error();
  if (clock_) return clock_->error();
  return frame_refused_ ? kNotSent : 0;
}

}  // namespace cansyncd
