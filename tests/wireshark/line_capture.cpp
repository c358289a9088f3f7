// A line in virtual time, written down: line_capture CONFIG LOG. The master and the simulated drives of
// CONFIG run for a second of bus time with reference values, parameter jobs, broadcasts and transfers; LOG is
// the trace of the simulated line. Standard output: a line `SLAVE VALUE RAW` (RAW signed) for each actual
// value that the master had at the end, and `block HEX` for what was downloaded and uploaded again. The same
// every time.
#include <fmt/format.h>

#include <array>
#include <cstdio>
#include <exception>
#include <numeric>
#include <stdexcept>
#include <vector>

#include "cansync/config/drive_settings.h"
#include "cansync/config/file.h"
#include "sim/trace_file.h"
#include "support/virtual_line.h"

namespace {

using namespace cansyncd;
using cansync::SlaveNumber;

constexpr std::uint64_t kEdges = 1000;
constexpr std::uint64_t kJobsAt = 300;  // active operation by then
constexpr std::uint32_t kAddress = 0x1000;

std::vector<std::unique_ptr<sim::Node>> drives_of(const Config& config) {
  std::vector<std::unique_ptr<sim::Node>> drives;
  for (unsigned i = 0; i < cansync::kSlaves; ++i) {
    if (!config.master.slaves[i].configured) continue;
    sim::DriveSettings drive = drive_settings(config, *SlaveNumber::from(i));
    drive.lock_time = std::chrono::milliseconds(100);
    drives.push_back(std::make_unique<sim::Drive>(drive));
  }
  return drives;
}

class Jobs {
 public:
  Jobs(Exchange& exchange, SlaveNumber slave) : exchange_(exchange), slave_(slave) {
    std::iota(out_.begin(), out_.end(), std::uint8_t{1});
  }

  void at_edge(std::uint64_t edge) {
    if (edge == kJobsAt) first();
    if (edge == kJobsAt + 200) transfer(cansync::TransferRequest::Direction::upload, in_);
  }

  std::span<const std::uint8_t> uploaded() const { return in_; }

 private:
  void push(const Request& request) {
    if (!exchange_.requests.try_push(request)) throw std::runtime_error("no room for a request");
  }
  void first() {
    parameter(sim::parameter::serial_number, false, 0);
    parameter(4000, false, 0);  // no such parameter
    parameter(sim::parameter::first_plain_word, true, 42);
    cansync::BroadcastRequest broadcast;
    broadcast.id = ++id_;
    broadcast.action.slaves.bits = 1u << slave_.value();
    broadcast.action.command = 200;
    broadcast.action.data_word = 0x1234;
    push(broadcast);
    transfer(cansync::TransferRequest::Direction::download, out_);
  }
  void parameter(std::uint16_t number, bool write, std::uint32_t value) {
    cansync::ParameterRequest request;
    request.id = ++id_;
    request.slave = slave_;
    request.number = *cansync::ParameterNumber::from(number);
    request.write = write;
    request.value = value;
    request.format = write ? cansync::ParameterFormat::word : cansync::ParameterFormat::as_slave_says;
    push(request);
  }
  void transfer(cansync::TransferRequest::Direction direction, std::span<std::uint8_t> data) {
    cansync::TransferRequest request;
    request.id = ++id_;
    request.slave = slave_;
    request.direction = direction;
    request.address = kAddress;
    request.data = data;
    push(request);
  }

  Exchange& exchange_;
  SlaveNumber slave_;
  cansync::JobId id_ = 0;
  std::array<std::uint8_t, 100> out_{};
  std::array<std::uint8_t, 100> in_{};
};

void print_actual(Exchange& exchange, const Config& config) {
  for (unsigned i = 0; i < cansync::kSlaves; ++i) {
    ActualReport report;
    if (!config.master.slaves[i].configured || !exchange.actual[i].read(report)) continue;
    for (unsigned n = 0; n < cansync::kValues; ++n) {
      const bool word = ((report.values.words >> n) & 1u) != 0;
      fmt::print("{} {} {}\n", i, n, cansync::number_of(report.values.value[n], word, true));
    }
  }
}

void capture(const char* config_path, const char* log_path) {
  const ConfigFile file = load_config(config_path, {});
  if (!file.problems.empty()) throw std::runtime_error(problems_text(file.problems));
  const Config& config = file.config;
  sim::TraceFileSettings settings;
  settings.path = log_path;
  sim::TraceFile trace(settings);
  support::VirtualLine line(config.master, drives_of(config));
  Jobs jobs(line.exchange(), *SlaveNumber::from(config.master.process.maximum_slave.value()));
  line.on_frame = [&trace](const sim::TracedFrame& frame, can::Time) { trace.frame(frame); };
  line.on_edge = [&](std::uint64_t edge) {
    trace.sync(line.line().now());
    line.give_references(static_cast<std::uint32_t>(1000 + 10 * edge));
    jobs.at_edge(edge);
  };
  line.run(kEdges);
  const sim::TraceSummary summary = trace.close();
  if (summary.error != 0 || summary.lost != 0) throw std::runtime_error("the trace could not be written");
  print_actual(line.exchange(), config);
  fmt::print("block ");
  for (const std::uint8_t byte : jobs.uploaded()) fmt::print("{:02x}", byte);
  fmt::print("\n");
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fputs("usage: line_capture CONFIG LOG\n", stderr);
    return 2;
  }
  try {
    capture(argv[1], argv[2]);
    return 0;
  } catch (const std::exception& error) {
    std::fputs(error.what(), stderr);
    std::fputs("\n", stderr);
    return 1;
  }
}
