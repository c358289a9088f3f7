// A local drive behind a daemon that is a slave: what BAPS is between an Omega and the drive in its housing.
// In every cycle it takes the master's reference value 0 (position) and gives the actual values 0 (position)
// and 4 (control word); parameters 1000 (time constant, in cycles) and 1001 (position, read only) are its
// own. Usage: local_drive DOMAIN BUS SECONDS        Exit code: 0 done, 1 failed
#include <cansync/client.h>
#include <cansync/function_blocks.h>
#include <cansync/slave_connection.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>
#include <thread>

namespace {

using namespace cansync::client;
using namespace cansync::client::function_blocks;

constexpr UINT kTimeConstant = 1000;
constexpr UINT kPosition = 1001;
constexpr INT kNotChangeable = static_cast<INT>(0xFFFC);
constexpr WORD kEnabled = 0x000F;  // the bits of a control word that let this drive move

int drive(const Options& options, std::chrono::seconds time) {
  SlaveConnection connection = SlaveConnection::connect(options);
  CONTROLWORD_SL control(connection);
  PD_COMM_SL cyclic(connection);
  PAR_SL parameters(connection, {kTimeConstant, kPosition});
  parameters.x_EN = true;
  cyclic.si_RDC1_SEND = cyclic.si_RDC2_SEND = 5;
  double position = 0;
  UDINT time_constant = 4;
  unsigned references = 0, jobs = 0;

  const auto end = Clock::now() + time;
  for (auto next = Clock::now(); next < end; next += std::chrono::milliseconds(1)) {
    std::this_thread::sleep_until(next);
    control.call();
    cyclic.call();
    const auto wanted = static_cast<double>(cyclic.a_WR_VALUES_RECEIVED[0]);
    if (cyclic.si_WRC1_RECEIVED != 0) ++references;
    // Without a control word that enables it, the drive stands.
    if ((control.w_CONTROLWORD & kEnabled) == kEnabled) position += (wanted - position) / time_constant;
    const auto actual = static_cast<DINT>(position);
    cyclic.a_RD_VALUES_SEND = {actual, 0, 0, 0, control.w_CONTROLWORD, 0, 0, 0};

    parameters.call();
    const bool own = parameters.u_PAR_NR == kTimeConstant;
    if (parameters.x_WRITE && own) time_constant = std::max<UDINT>(1, parameters.ud_PAR_VALUE_WRITE);
    parameters.ud_PAR_VALUE_READ = own ? time_constant : static_cast<UDINT>(actual);
    parameters.x_PAR_FORMAT_READ = !own;
    parameters.i_ERR = kNotChangeable;
    parameters.x_ERR_IN = parameters.x_ACTIV && parameters.x_WRITE && !own;
    parameters.x_OK_IN = parameters.x_ACTIV && !parameters.x_ERR_IN;
    jobs += parameters.x_OK ? 1u : 0u;
    if (!connection.daemon_present()) return std::fprintf(stderr, "the daemon has gone\n"), 1;
  }
  std::printf("%u reference values, %u parameter jobs, control word 0x%04X, position %.0f\n", references,
              jobs, control.w_CONTROLWORD, position);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) return std::fprintf(stderr, "usage: %s DOMAIN BUS SECONDS\n", argv[0]), 1;
  try {
    Options options;
    options.domain = static_cast<std::uint32_t>(std::atoi(argv[1]));
    options.bus = argv[2];
    options.client_name = "local drive";
    return drive(options, std::chrono::seconds(std::atoi(argv[3])));
  } catch (const std::exception& error) {
    return std::fprintf(stderr, "%s\n", error.what()), 1;
  }
}
