// A lead axis: gives every drive of a line a position reference value for every interval, each released
// exactly once, and shows at the end how far each follower is behind. Values are written eight intervals
// ahead, so that this program may be late now and then. The daemon's Interval topic is the clock
// (dds.interval_topic = true); 65536 increments are one revolution.
// Usage: lead_axis DOMAIN BUS RPM SECONDS        Exit code: 0 done, 1 failed
#include <cansync/client.h>
#include <cansync/topics.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <semaphore>
#include <string>

namespace {

using namespace cansync::client;

constexpr std::uint64_t kAhead = 8;

int lead(const Options& options, double rpm, double seconds) {
  Client client = Client::connect(options);
  const double interval = static_cast<double>(client.master_status().interval_length) * 1e-9;
  ReferenceWriter writer(client, 10);

  std::counting_semaphore<> begun(0);
  std::atomic<std::uint64_t> number{0};
  const Subscription subscription = client.on_interval([&](const Interval& now) {
    number = now.number;
    begun.release();
  });

  const double full_step = rpm / 60 * 65536 * interval;
  const auto steps = static_cast<std::uint64_t>(seconds / interval);
  double position = 0;
  std::uint64_t next = 0;  // the interval that gets a value next
  for (std::uint64_t done = 0; done < steps;) {
    if (!begun.try_acquire_for(std::chrono::seconds(20))) {
      std::fprintf(stderr, "no interval for 20 s: is dds.interval_topic on, and does the line run?\n");
      return 1;
    }
    for (next = std::max(next, number + 1); next <= number + kAhead; ++next, ++done) {
      // Two seconds to full speed.
      position += full_step * std::min(static_cast<double>(done) * interval / 2, 1.0);
      const auto raw = static_cast<std::int32_t>(static_cast<std::uint32_t>(std::llround(position)));
      if (const std::string failed = writer.write(1, {raw, 0, 0, 0}, 0b0001, 1, next); !failed.empty()) {
        std::fprintf(stderr, "%s\n", failed.c_str());
        return 1;
      }
    }
  }
  for (const SlaveStatus& slave : client.slaves()) {
    if (const auto values = client.actual_values(slave.slave))
      std::printf("slave %d: %.0f increments behind\n", slave.slave,
                  position - static_cast<std::int32_t>(values->raw[0]));
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 5) return std::fprintf(stderr, "usage: %s DOMAIN BUS RPM SECONDS\n", argv[0]), 1;
  try {
    Options options;
    options.domain = static_cast<std::uint32_t>(std::atoi(argv[1]));
    options.bus = argv[2];
    options.client_name = "lead axis";
    // As for the command cansync. NOLINTNEXTLINE(concurrency-mt-unsafe): nobody changes the environment
    const char* types = std::getenv("CANSYNC_TYPES");
    options.final_types = types != nullptr && std::string(types) == "final";
    return lead(options, std::atof(argv[3]), std::atof(argv[4]));
  } catch (const std::exception& error) {
    return std::fprintf(stderr, "%s\n", error.what()), 1;
  }
}
