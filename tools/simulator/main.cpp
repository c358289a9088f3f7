#include <fmt/format.h>

#include <cstdio>
#include <exception>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "simulator/arguments.h"
#include "simulator/bench.h"
#include "simulator/run.h"
#include "simulator/setup.h"
#include "simulator/socket_port.h"

namespace {

using namespace cansync_sim;

constexpr int kDone = 0;
constexpr int kCannotStart = 1;
constexpr int kWrongUsage = 2;

void remark(const std::string& text) {
  fmt::print(stderr, "cansync-sim: {}\n", text);
}

int run_drives(const Arguments& arguments) {
  const Setup setup = make_setup(arguments);
  for (const std::string& problem : setup.problems) remark(problem);
  if (!setup.problems.empty()) return kWrongUsage;
  std::vector<std::unique_ptr<sim::Drive>> drives;
  drives.reserve(setup.drives.size());
  for (const sim::DriveSettings& drive : setup.drives) drives.push_back(std::make_unique<sim::Drive>(drive));
  Bench bench(setup.bench, std::move(drives));
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
  remark(fmt::format("{} drives on {}, SYNC frame 0x{:03X}", setup.drives.size(), setup.interface,
                     setup.bench.sync_identifier));
  run(bench, port, {setup.interface, arguments.verbose, remark});
  fmt::print("{}\n", summary(bench, port.dropped()));
  return std::fflush(stdout) == 0 ? kDone : kCannotStart;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const auto parsed = parse_arguments(argc, argv);
    if (const auto* arguments = std::get_if<Arguments>(&parsed)) return run_drives(*arguments);
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
