// Fault scripts (lib/sim/fault_script.h), and what is accepted of them on a line without frames.
#include "bounded.h"
#include "bytes.h"
#include "cansync/sim/drive_faults.h"
#include "require.h"
#include "sim/fault_script.h"
#include "sim/faults.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using fuzz::require;
  const sim::FaultScript script = fuzz::bounded(size, fuzz::kOfTextInPart, [&] {
    return sim::parse_fault_script(fuzz::text_of(data, size), "fuzz.toml", sim::drive_faults());
  });
  for (const config::Problem& error : script.errors) {
    require(error.where.line > 0 && error.where.column > 0, "an error has a place");
    require(to_string(error).starts_with("fuzz.toml:"), "an error can be told");
  }
  require(script.places.size() == script.faults.size(), "each fault has a place");
  sim::FaultSchedule schedule(script.faults, 1, &sim::drive_faults());
  for (const std::uint64_t interval : {0u, 1u, 100u, 1000u}) {
    schedule.begin_interval(interval);
    static_cast<void>(schedule.missing_sync());
    for (std::uint32_t id = 0; id <= 0x7FF; id += 0x80) {
      can::Frame frame{.id = id, .dlc = 8, .data = {0xFF}};
      require(schedule.at_hand_over(frame).count() >= 0, "no frame is early");
      static_cast<void>(schedule.at_start(frame, false));
    }
    std::size_t cursor = 0;
    std::size_t injected = 0;
    while (const sim::Fault* fault = schedule.next_injection(cursor)) {
      require(fault->frame.dlc <= 8 && fault->frame.id <= 0x1FFFFFFF, "what is injected is a frame");
      ++injected;
    }
    require(injected <= script.faults.size(), "each fault injects once an interval");
  }
  return 0;
}
