#include <fmt/format.h>

#include <cstdio>
#include <exception>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "simulator/arguments.h"
#include "simulator/bench.h"
#include "simulator/drive_log.h"
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

void remark(const std::string& text) {
  fmt::print(stderr, "cansync-sim: {}\n", text);
}

int end(const std::string& summary) {
  fmt::print("{}\n", summary);
  return std::fflush(stdout) == 0 ? kDone : kCannotStart;
}

int run_drives(const Setup& setup, SocketPort& port, bool verbose) {
  std::vector<std::unique_ptr<sim::Drive>> drives;
  drives.reserve(setup.drives.size());
  for (const sim::DriveSettings& drive : setup.drives) drives.push_back(std::make_unique<sim::Drive>(drive));
  Bench bench(setup.bench, std::move(drives));
  DriveLog log(bench, remark);
  remark(fmt::format("{} on {}, SYNC frame 0x{:03X}", text::counted(setup.drives.size(), "drive"),
                     setup.interface, setup.bench.sync_identifier));
  run(bench, port, {setup.interface, remark, verbose ? [&] { log.look(); } : std::function<void()>()});
  return end(summary(bench, port.dropped()));
}

int run_master(const Setup& setup, SocketPort& port, bool verbose) {
  MasterBench bench(*setup.master, setup.bench.sync_identifier,
                    verbose ? remark : std::function<void(const std::string&)>());
  remark(fmt::format("a master on {}, SYNC frame 0x{:03X}", setup.interface, setup.bench.sync_identifier));
  run(bench, port, {setup.interface, remark});
  return end(summary(bench, port.dropped()));
}

int run_device(const Setup& setup, SocketPort& port) {
  const sim::DeviceSettings& device = *setup.device;
  NodeBench bench(std::make_unique<sim::ScriptedDevice>(device), port.now());
  remark(fmt::format("a device on {}, {}, {} sent again and again", setup.interface,
                     text::counted(device.answers.size(), "answer"),
                     text::counted(device.periods.size(), "frame")));
  run(bench, port, {setup.interface, remark});
  return end(summary(bench, port.dropped()));
}

int run_program(const Arguments& arguments) {
  const Setup setup = make_setup(arguments);
  for (const std::string& problem : setup.problems) remark(problem);
  if (!setup.problems.empty()) return kWrongUsage;
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
  if (setup.device) return run_device(setup, port);
  return setup.master ? run_master(setup, port, arguments.verbose)
                      : run_drives(setup, port, arguments.verbose);
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
