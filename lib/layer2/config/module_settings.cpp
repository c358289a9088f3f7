#include "layer2/config/module_settings.h"

namespace cansyncd {

layer2::ModuleSettings module_settings(const Layer2Config& config) {
  layer2::ModuleSettings module;
  module.station.queue = config.send.queue;
  module.station.high_queue = config.send.high_queue;
  module.station.overflow = config.send.overflow;
  for (const layer2::ReceiveRange& range : config.receive) module.station.filter.add(range);
  if (config.node_filter != 0) module.station.node = {config.node_filter, config.node_filter_extended};
  module.receive_queue = config.queues.receive;
  module.receive_high_queue = config.queues.receive_high;
  module.receive_overflow = config.queues.overflow;
  for (const TimerConfig& timer : config.timers) module.timers[timer.number - 1] = timer.timer;
  for (const ObjectConfig& object : config.objects) module.objects[object.number] = object.settings;
  module.object_patience = config.send.timeout;
  module.window = config.window;
  module.bits_per_second = config.bus.bits_per_second;
  module.power_on = read_script(config.script.power_on, config.script.rules);
  module.run = read_script(config.script.run, config.script.rules);
  module.stop = read_script(config.script.stop, config.script.rules);
  module.starts_in_run = config.starts_in_run && config.run_follows.empty();
  module.mapping = config.mapping;
  module.mapped = config.mapped;
  return module;
}

}  // namespace cansyncd
