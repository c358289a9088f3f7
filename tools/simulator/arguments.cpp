#include "simulator/arguments.h"

#include <CLI/CLI.hpp>
#include <string>
#include <utility>

#include "text/build_info.h"

namespace cansync_sim {
namespace {

void describe(CLI::App& app, Arguments& arguments) {
  app.set_version_flag("--version", "cansync-sim " + std::string(text::build_text()));
  app.add_option("INTERFACE", arguments.interface, "CAN interface of the kernel, such as vcan0 or can0");
  app.add_option("--slaves", arguments.slaves,
                 "Slave numbers, such as 0-31 or 0,3,5-7 (default 0; with --config its simulated drives)")
      ->type_name("LIST");
  app.add_option("--sync-id", arguments.sync_id,
                 "Identifier of the software SYNC frame (default: the configuration's sync.can_identifier, "
                 "else 0x080); not part of CANsync")
      ->type_name("ID");
  app.add_option("--bit-rate", arguments.bit_rate,
                 "125000, 250000, 500000 or 1000000 bit/s (default 1000000); fixes the interval")
      ->type_name("N");
  app.add_option("--lock-time", arguments.lock_time,
                 "From activation to bit 15 of the status word (default 500)")
      ->type_name("MS");
  app.add_option("--status-parameter", arguments.status_parameter, "Number of the status word (default 301)")
      ->type_name("N");
  app.add_option("--memory", arguments.memory, "Memory of each drive for transfers (default 262144)")
      ->type_name("BYTES");
  app.add_option("--missing-references", arguments.missing_references,
                 "Intervals without reference values until a drive faults, 0 = never (default 10)")
      ->type_name("N");
  app.add_option("--faults", arguments.faults, "Fault script (docs/fault-scripts.md)")->type_name("FILE");
  app.add_option("--device", arguments.device,
                 "Be the device of this script instead, on a bus of general frames (docs/cansync-sim.md)")
      ->type_name("FILE");
  app.add_option("--seed", arguments.seed, "Seed of the faults' chance (default 1)")->type_name("N");
  app.add_option("--config", arguments.config, "The daemon's configuration file: take the line from it")
      ->type_name("FILE");
  app.add_option("--set", arguments.set,
                 "Any option of the daemon's configuration, such as process.full_length=false")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
  app.add_flag("--master", arguments.master, "Be the master of these slaves instead, for slaves under test");
  app.add_option(
         "--reference", arguments.references,
         "With --master: gives reference value NUMBER, raw; as RAW+STEP with STEP more in each interval; "
         "repeatable")
      ->type_name("NUMBER=RAW")
      ->allow_extra_args(false);
  app.add_flag("--wait", arguments.wait, "Wait for an interface that is missing or down at the start, too");
  app.add_flag(
      "--real", arguments.real,
      "Also on an interface that is not virtual: listen for 1 s first, and end when a slave of these "
      "numbers or, with --master, a master is there");
  app.add_flag("-v,--verbose", arguments.verbose, "Tell every change of a drive's or the line's state");
  app.footer(
      "SIGTERM and SIGINT stop; then one line on standard output says what was done.\n"
      "Exit codes: 0 stopped, 1 cannot start, 2 wrong command line or file, 11 a script was read in part.\n"
      "More: docs/cansync-sim.md.");
}

}  // namespace

std::variant<Arguments, CommandLineEnd> parse_arguments(int argc, const char* const* argv) {
  CLI::App app(
      "Simulated CANsync drives, a simulated master, or a device of a script, on a CAN interface of the kernel.",
      "cansync-sim");
  Arguments arguments;
  describe(app, arguments);
  if (auto end = text::read_command_line(app, argc, argv)) return *std::move(end);
  return arguments;
}

}  // namespace cansync_sim
