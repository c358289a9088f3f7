// A first client: reads a parameter, shows ten telegrams of actual values of a slave, gives reference values
// for two seconds. IT MOVES EVERY DRIVE of the line that follows: for a simulated line.
// Usage: first_client DOMAIN BUS SLAVE        Exit code: 0 done, 1 failed
#include <cansync/client.h>
#include <cansync/reference_repeater.h>
#include <cansync/topics.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <semaphore>
#include <stdexcept>
#include <thread>

using namespace cansync::client;
using namespace std::chrono_literals;

void check(const Reply& reply) {
  if (!reply.ok()) throw std::runtime_error(describe(reply));
}

int main(int argc, char** argv) try {
  if (argc != 4) return std::fprintf(stderr, "usage: %s DOMAIN BUS SLAVE\n", argv[0]), 1;
  Client client = Client::connect({.domain = static_cast<std::uint32_t>(std::atoi(argv[1])),
                                   .bus = argv[2],
                                   .client_name = "first client"});

  const SlaveLookup found = client.find_slave(argv[3]);
  if (!found.slave) throw std::runtime_error(found.problem);
  const std::uint8_t slave = *found.slave;

  const ParameterReply status = client.read(slave, 301);
  check(status);
  std::printf("parameter 301: 0x%04X\n", status.value);

  // The callbacks run on a thread of the library. Values come while somebody gives reference values, or with
  // process.poll_without_reference.
  std::counting_semaphore<10> came(0);
  int shown = 0;
  Subscription values = client.on_actual_values([&](const ActualValues& now) {
    if (now.slave != slave || shown == 10) return;
    std::printf("value 0: %d, in its unit: %g\n", static_cast<std::int32_t>(now.raw[0]), now.scaled[0]);
    ++shown;
    came.release();
  });
  for (int i = 0; i < 10; ++i)
    if (!came.try_acquire_for(10s)) throw std::runtime_error("no actual values for 10 s: does the line run?");
  values = {};  // no callback runs any more

  // What a control word means is the drive's matter: this one lets a simulated drive follow, and resets its fault.
  check(client.control_word(slave, 0x0087).wait());
  // Reference values are for all drives of the line. They are given again every 20 ms until something else is set.
  const auto before = static_cast<std::int32_t>(client.actual_values(slave).value().raw[0]);
  ReferenceRepeater references(client, 20ms);
  references.set(1, {before + 65536, 0, 0, 0}, 0b0001);
  std::this_thread::sleep_for(2s);
  if (!references.error().empty()) throw std::runtime_error(references.error());
  const auto after = static_cast<std::int32_t>(client.actual_values(slave).value().raw[0]);
  std::printf("value 0 moved by %d\n", after - before);
  references.stop();  // a drive that had reference values and gets none any more faults after a while
  return 0;
} catch (const std::exception& error) {  // NoDaemon says where it looked, and the remedy
  return std::fprintf(stderr, "%s\n", error.what()), 1;
}
