#include "sim/trace_file.h"

#include <array>
#include <cerrno>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>

#include "can/candump.h"

namespace sim {
namespace {

constexpr std::string_view kSyncInterface = "sync";
constexpr std::uint32_t kSyncIdentifier = 0x080;
// At 1 Mbit/s about eight lines come in a millisecond: the ring is far from full when it is looked at.
constexpr std::chrono::milliseconds kWriterPeriod(5);

const TraceFileSettings& checked(const TraceFileSettings& settings) {
  if (settings.ring_lines == 0) throw std::invalid_argument("trace: ring_lines is 0, allowed is 1 or more");
  return settings;
}

}  // namespace

std::string trace_interface(std::string_view bus) {
  std::string interface(bus.substr(0, can::kInterfaceNameLimit));
  for (char& c : interface) {
    if (c <= ' ' || c >= '\x7f') c = '_';
  }
  return interface.empty() || interface == kSyncInterface ? interface + "_" : interface;
}

TraceFile::TraceFile(const TraceFileSettings& settings)
    : settings_(checked(settings)),
      interface_(trace_interface(settings.bus)),
      file_(std::fopen(settings.path.c_str(), "we")),
      ring_(settings.background ? settings.ring_lines : 1) {
  if (file_ == nullptr) {
    throw std::system_error(errno, std::generic_category(), "trace: cannot write '" + settings.path + "'");
  }
  if (settings_.background) writer_ = std::thread([this] { run(); });
}

TraceFile::~TraceFile() {
  close();
}

void TraceFile::frame(const TracedFrame& frame) noexcept {
  put({frame.start, frame.frame, false});
}

void TraceFile::sync(can::Time at) noexcept {
  Line line;
  line.at = at;
  line.frame.id = kSyncIdentifier;
  line.sync = true;
  put(line);
}

void TraceFile::put(const Line& line) noexcept {
  if (!settings_.background) {
    write(line);
  } else if (!ring_.push(line)) {
    lost_.fetch_add(1, std::memory_order_relaxed);
  }
}

void TraceFile::write(const Line& line) noexcept {
  std::array<char, can::kCandumpLineLimit> text;
  const auto time = std::chrono::floor<std::chrono::microseconds>(line.at + settings_.offset);
  const std::string_view interface = line.sync ? kSyncInterface : std::string_view(interface_);
  write_text(text.data(), can::write_candump_line(time, interface, line.frame, text));
  if (summary_.error == 0) ++summary_.lines;
}

void TraceFile::write_text(const char* text, std::size_t size) noexcept {
  if (summary_.error != 0 || file_ == nullptr) return;
  errno = 0;
  if (std::fwrite(text, 1, size, file_.get()) != size) summary_.error = errno != 0 ? errno : EIO;
}

void TraceFile::drain() noexcept {
  Line line;
  while (ring_.pop(line)) write(line);
}

void TraceFile::run() noexcept {
  while (!stop_.load(std::memory_order_acquire)) {
    drain();
    std::this_thread::sleep_for(kWriterPeriod);
  }
  drain();
}

TraceSummary TraceFile::close() noexcept {
  if (file_ == nullptr) return summary_;
  if (writer_.joinable()) {
    stop_.store(true, std::memory_order_release);
    writer_.join();
  }
  summary_.lost = lost_.load(std::memory_order_relaxed);
  if (summary_.lost != 0) {
    std::array<char, 64> text;
    const int size = std::snprintf(text.data(), text.size(), "# %llu lines lost\n",
                                   static_cast<unsigned long long>(summary_.lost));
    write_text(text.data(), static_cast<std::size_t>(size));
  }
  errno = 0;
  if (std::fclose(file_.release()) != 0 && summary_.error == 0) summary_.error = errno != 0 ? errno : EIO;
  return summary_;
}

}  // namespace sim
