// Recordings: how fast a log is read, and shown as `cansync can dump FILE` does, with and without a file of signals.
// The yardstick is `Lines`, which only finds the ends of the lines.
#include <benchmark/benchmark.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <initializer_list>
#include <iterator>
#include <memory>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "can/candump.h"
#include "cli/app/application.h"
#include "cli/trace/trace_source.h"

namespace {

using namespace cansync::cli;

constexpr unsigned kFrames = 200'000;
constexpr unsigned kMessages = 60;

/// A log of 11-bit frames of eight bytes, and a DBC file with four signals for each message.
class Files {
 public:
  Files() {
    std::mt19937_64 dice(1);
    std::ofstream out(log, std::ios::binary);
    for (unsigned i = 0; i < kFrames; ++i) {
      can::Frame frame;
      frame.id = 0x100 + static_cast<std::uint32_t>(dice() % kMessages);
      frame.dlc = 8;
      for (std::uint8_t& byte : frame.data) byte = static_cast<std::uint8_t>(dice());
      std::array<char, can::kCandumpLineLimit> text{};
      const auto time = std::chrono::seconds(1'700'000'000) + std::chrono::microseconds(200) * i;
      const std::size_t length = can::write_candump_line(time, "can0", frame, text);
      out.write(text.data(), static_cast<std::streamsize>(length));
      bytes += length;
    }
    std::ofstream names(dbc);
    names << "VERSION \"\"\nBU_: A\n";
    for (unsigned m = 0; m < kMessages; ++m)
      names
          << "BO_ " << 0x100 + m << " M" << m << ": 8 A\n SG_ Speed : 0|16@1+ (0.125,0) [0|0] \"rpm\" A\n"
          << " SG_ Torque : 16|16@1- (0.5,-10) [0|0] \"Nm\" A\n SG_ Temp : 32|8@1+ (1,-40) [0|0] \"degC\" A\n"
          << " SG_ Mode : 40|4@1+ (1,0) [0|0] \"\" A\n";
  }
  ~Files() {
    std::remove(log.c_str());
    std::remove(dbc.c_str());
  }
  Files(const Files&) = delete;
  Files& operator=(const Files&) = delete;

  std::string log = "/tmp/recording_bench." + std::to_string(::getpid()) + ".log";
  std::string dbc = "/tmp/recording_bench." + std::to_string(::getpid()) + ".dbc";
  std::uint64_t bytes = 0;
};

const Files& files() {
  static const Files made;
  return made;
}

void count(benchmark::State& state) {
  state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(files().bytes));
  state.SetItemsProcessed(static_cast<std::int64_t>(state.iterations() * kFrames));
}

void Lines(benchmark::State& state) {
  std::ifstream in(files().log, std::ios::binary);
  const std::string text((std::istreambuf_iterator<char>(in)), {});
  for (auto _ : state) {
    std::size_t lines = 0;
    for (std::size_t at = text.find('\n'); at != text.npos; at = text.find('\n', at + 1)) ++lines;
    benchmark::DoNotOptimize(lines);
  }
  count(state);
}

void Frames(benchmark::State& state) {
  for (auto _ : state) {
    const auto source = open_log(files().log);
    std::size_t frames = 0;
    for (TraceItem item = source->next(); !std::holds_alternative<TraceEnd>(item); item = source->next())
      frames += item.index() == 0 ? 1 : 0;
    benchmark::DoNotOptimize(frames);
  }
  count(state);
}

void dump(benchmark::State& state, std::initializer_list<std::string_view> words) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> data(std::fopen("/dev/null", "w"), &std::fclose);
  std::vector<const char*> arguments{"cansync"};
  for (const std::string_view word : words) arguments.push_back(word.data());
  for (auto _ : state) {
    const ExitCode code = run(static_cast<int>(arguments.size()), arguments.data(), data.get(), stderr);
    if (code != ExitCode::done) state.SkipWithError("the verb failed");
  }
  count(state);
}

void Table(benchmark::State& state) {
  dump(state, {"can", "dump", files().log});
}

void TableWithSignals(benchmark::State& state) {
  dump(state, {"can", "dump", files().log, "--dbc", files().dbc});
}

BENCHMARK(Lines);
BENCHMARK(Frames);
BENCHMARK(Table);
BENCHMARK(TableWithSignals);

}  // namespace
