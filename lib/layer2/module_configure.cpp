// Settings of a module that change while it runs.
#include <utility>

#include "layer2/module.h"

namespace layer2 {
namespace {

/// Saia 3.5: objects that belong to the data mapping.
constexpr unsigned kMappingObjects[] = {28, 29};

bool same_scripts(const ModuleSettings& a, const ModuleSettings& b) noexcept {
  return a.power_on.commands == b.power_on.commands && a.run.commands == b.run.commands &&
         a.stop.commands == b.stop.commands;
}

void configure_timers(Timers& timers, const ModuleSettings& settings) noexcept {
  for (unsigned number = 1; number <= Timers::kMost; ++number) {
    const auto& wanted = settings.timers[number - 1];
    if (!wanted) {
      if (timers.configured(number)) (void)timers.forget(number);
    } else if (!timers.configured(number) || timers.settings(number) != *wanted) {
      (void)timers.configure(number, *wanted);
    }
  }
}

void configure_objects(MessageObjects& objects, const ModuleSettings& settings) noexcept {
  for (unsigned number = 0; number < MessageObjects::kMost; ++number) {
    const auto& wanted = settings.objects[number];
    const ObjectState state = objects.state(number);
    if (!wanted) {
      if (state.configured) (void)objects.forget(number);
    } else if (!state.configured || state.settings != *wanted) {
      (void)objects.configure(number, *wanted);
    }
  }
}

}  // namespace

PreparedSettings::PreparedSettings(ModuleSettings prepared) : settings(std::move(prepared)) {
  mapping.configure(settings.mapping, settings.mapped);
}

/// Why nothing of it can be taken over now.
Refusal Module::objection(const PreparedSettings& prepared) const noexcept {
  const ModuleSettings& next = prepared.settings;
  if (prepared.parts.station && !station_.fits(next.station)) return Refusal::queue_in_use;
  if (prepared.parts.receive_queues &&
      (received_.size() > next.receive_queue || received_high_.size() > next.receive_high_queue))
    return Refusal::queue_in_use;
  const bool script = runner_.runs() || next_script_ != nullptr;
  if (prepared.parts.scripts && script && !same_scripts(settings_, next)) return Refusal::script_under_way;
  return Refusal::none;
}

Refusal Module::configure(PreparedSettings& prepared, Time now) noexcept {
  now_ = now;
  if (const Refusal refusal = objection(prepared); refusal != Refusal::none) return refusal;
  ModuleSettings& next = prepared.settings;
  if (prepared.parts.station) {
    settings_.station = next.station;
    station_.set(next.station);
    settings_.object_patience = next.object_patience;
    orders_.set_patience(next.object_patience);
  }
  if (prepared.parts.receive_queues) {
    received_.set(next.receive_queue, next.receive_overflow);
    received_high_.set(next.receive_high_queue, next.receive_overflow);
  }
  if (prepared.parts.window && next.window != settings_.window) {
    settings_.window = next.window;
    window_ = SyncWindow(next.window);
    // From now on they move the window, and send nothing.
    for (const unsigned number : {1u, 2u}) {
      if (next.window.used) (void)timers_.stop(number);
    }
  }
  if (prepared.parts.scripts && !same_scripts(settings_, next)) {
    std::swap(settings_.power_on.commands, next.power_on.commands);
    std::swap(settings_.run.commands, next.run.commands);
    std::swap(settings_.stop.commands, next.stop.commands);
  }
  if (prepared.parts.mapping) configure_mapping(prepared, now);
  if (prepared.parts.timers) configure_timers(timers_, next);
  if (prepared.parts.objects) configure_objects(objects_, next);
  return Refusal::none;
}

void Module::configure_mapping(PreparedSettings& prepared, Time now) noexcept {
  mapping_.swap_table(prepared.mapping);
  std::swap(settings_.mapping, prepared.settings.mapping);
  settings_.mapped.swap(prepared.settings.mapped);
  for (const unsigned number : kMappingObjects) {
    if (has_mapping()) {
      objects_.reserve(number);
    } else {
      objects_.unreserve(number);
    }
  }
  if (running_) mapping_.start(now);
}

}  // namespace layer2
