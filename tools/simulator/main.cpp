#include <fmt/format.h>

#include <cstdio>
#include <exception>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "can/link_kernel.h"
#include "simulator/arguments.h"
#include "simulator/bench.h"
#include "simulator/drive_log.h"
#include "simulator/first_look.h"
#include "simulator/master_bench.h"
#include "simulator/node_bench.h"
#include "simulator/run.h"
#include "simulator/setup.h"
#include "simulator/socket_port.h"
#include "text/counts.h"

namespace {

using namespace cansync_sim;

constexpr int kDone = 0;
constexpr int kCannotStart = 1;
constexpr int kWrongUsage = 2;
constexpr int kInPart = 11;  ///< as of `cansync`

void remark(const std::string& text) {
  fmt::print(stderr, "cansync-sim: {}\n", text);
}

int end(const std::string& summary) {
  fmt::print("{}\n", summary);
  return std::fflush(stdout) == 0 ? kDone : kCannotStart;
}

/// Why nothing may be sent on this interface, as exit code; `kDone`: the program is to stop; nothing: it may.
std::optional<int> look_at_bus(const Setup& setup, SocketPort& port, bool real) {
  const auto kernel = can::make_link_kernel();
  can::LinkFacts facts = kernel->read(setup.interface);
  if (!facts.present) {
    remark(fmt::format("{} does not exist; waiting for it. {}", setup.interface,
                       remedy(Link::missing, setup.interface)));
    for (; !facts.present; facts = kernel->read(setup.interface))
      if (!port.wait(port.now() + std::chrono::milliseconds(100))) return kDone;
  }
  if (is_virtual(facts)) return std::nullopt;
  if (!real) {
    remark(fmt::format(
        "{} is not virtual (driver kind \"{}\"): what is simulated here would act on real devices. Use a vcan "
        "interface, or give --real when the bus has none of these devices",
        setup.interface, facts.driver_kind.data()));
    return kCannotStart;
  }
  if (setup.device) return std::nullopt;
  const auto heard = listen(port, setup.bench.sync_identifier);
  if (!heard) return kDone;
  const std::string reason = conflict(setup, *heard);
  if (reason.empty()) return std::nullopt;
  remark(reason);
  return kCannotStart;
}

int run_drives(const Setup& setup, SocketPort& port, const Arguments& arguments) {
  std::vector<std::unique_ptr<sim::Drive>> drives;
  drives.reserve(setup.drives.size());
  for (const sim::DriveSettings& drive : setup.drives) drives.push_back(std::make_unique<sim::Drive>(drive));
  Bench bench(setup.bench, std::move(drives));
  DriveLog log(bench, remark);
  remark(fmt::format("{} on {}, SYNC frame 0x{:03X}", text::counted(setup.drives.size(), "drive"),
                     setup.interface, setup.bench.sync_identifier));
  if (const auto code = look_at_bus(setup, port, arguments.real))
    return *code == kDone ? end(summary(bench, port.dropped())) : *code;
  run(bench, port,
      {setup.interface, remark, arguments.verbose ? [&] { log.look(); } : std::function<void()>()});
  return end(summary(bench, port.dropped()));
}

int run_master(const Setup& setup, SocketPort& port, const Arguments& arguments) {
  MasterBench bench(*setup.master, setup.bench.sync_identifier,
                    arguments.verbose ? remark : std::function<void(const std::string&)>());
  remark(fmt::format("a master on {}, SYNC frame 0x{:03X}", setup.interface, setup.bench.sync_identifier));
  if (const auto code = look_at_bus(setup, port, arguments.real))
    return *code == kDone ? end(summary(bench, port.dropped())) : *code;
  run(bench, port, {setup.interface, remark});
  return end(summary(bench, port.dropped()));
}

int run_device(const Setup& setup, SocketPort& port, const Arguments& arguments) {
  const sim::DeviceSettings& device = *setup.device;
  NodeBench bench(std::make_unique<sim::ScriptedDevice>(device), port.now());
  remark(fmt::format("a device on {}, {}, {} sent again and again", setup.interface,
                     text::counted(device.answers.size(), "answer"),
                     text::counted(device.periods.size(), "frame")));
  if (const auto code = look_at_bus(setup, port, arguments.real))
    return *code == kDone ? end(summary(bench, port.dropped())) : *code;
  run(bench, port, {setup.interface, remark});
  return end(summary(bench, port.dropped()));
}

int run_program(const Arguments& arguments) {
  Setup setup = make_setup(arguments);
  // A master that comes later keeps it silent, too.
  if (arguments.real && setup.master) setup.master->master.startup.listen = kListen;
  for (const std::string& problem : setup.problems) remark(problem);
  if (!setup.problems.empty()) return kWrongUsage;
  for (const std::string& one : setup.left_out) remark(one + "; what this is in is left out");
  SocketPort port(setup.interface);
  if (const std::string obstacle = port.obstacle(); !obstacle.empty()) {
    remark(obstacle);
    return kCannotStart;
  }
  if (port.link() != Link::up && !arguments.wait) {
    remark(fmt::format("{} {}. {}. With --wait this program waits for it.", setup.interface,
                       port.link() == Link::down ? "is down" : "does not exist",
                       remedy(port.link(), setup.interface)));
    return kCannotStart;
  }
  const int code = setup.device   ? run_device(setup, port, arguments)
                   : setup.master ? run_master(setup, port, arguments)
                                  : run_drives(setup, port, arguments);
  return code == kDone && !setup.left_out.empty() ? kInPart : code;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const auto parsed = parse_arguments(argc, argv);
    if (const auto* arguments = std::get_if<Arguments>(&parsed)) return run_program(*arguments);
    const auto& end = std::get<CommandLineEnd>(parsed);
    std::fputs(end.text.c_str(), end.wrong ? stderr : stdout);
    return end.wrong ? kWrongUsage : kDone;
  } catch (const std::exception& error) {
    std::fputs("cansync-sim: ", stderr);
    std::fputs(error.what(), stderr);
    std::fputs("\n", stderr);
    return kCannotStart;
  }
}
