// Scripts of simulated devices (lib/sim/device_script.h), and what an accepted one answers.
#include <chrono>

#include "bounded.h"
#include "bytes.h"
#include "require.h"
#include "sim/device_script.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using fuzz::require;
  sim::DeviceScript script = fuzz::bounded(size, fuzz::kOfTextInPart, [&] {
    return sim::parse_device_script(fuzz::text_of(data, size), "device");
  });
  for (const config::Problem& error : script.errors) require(!error.text.empty(), "a problem has words");
  if (script.refused()) return 0;
  const auto answers = script.device.answers;
  const std::size_t periods = script.device.periods.size();
  sim::ScriptedDevice device(std::move(script.device));
  for (const sim::ScriptedAnswer& answer : answers) {
    require(device.accepts(answer.to), "it accepts what it answers");
    const auto sent = device.on_frame(answer.to, can::Time{0});
    require(!sent || (sent->frame.dlc <= 8 && sent->not_before >= can::Time{0}), "an answer is a frame");
  }
  (void)device.on_join(can::Time{0});
  for (std::size_t i = 0; i < 4 * periods; ++i) {
    const can::Time due = *device.next_time();
    require(device.on_time(due).transmission.has_value(), "what is due is sent");
    require(*device.next_time() >= due, "time goes on");
  }
  return 0;
}
