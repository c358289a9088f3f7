#include "sync/gpio.h"

#include <fcntl.h>
#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace sync_line {
namespace {

/// Most edges the kernel keeps between two looks.
constexpr std::uint32_t kKernelBuffer = 64;

gpio_v2_line_request request_for(const GpioLine& line, std::uint64_t flags) noexcept {
  gpio_v2_line_request request = {};
  request.offsets[0] = line.line;
  request.num_lines = 1;
  request.config.flags = flags;
  constexpr std::string_view kConsumer = "cansyncd SYNC";
  std::copy(kConsumer.begin(), kConsumer.end(), std::begin(request.consumer));
  return request;
}

void take_line(System& system, Descriptor& into, gpio_v2_line_request& request, const GpioLine& line,
               const std::string& chip_option, const std::string& line_option) {
  Descriptor chip(system);
  open_or_throw(system, chip, chip_option, line.chip, O_RDWR);
  gpiochip_info info = {};
  if (const int result = system.control(chip.get(), GPIO_GET_CHIPINFO_IOCTL, &info); result < 0) {
    throw SetupError(chip_option, reason_and_remedy(line.chip, -result));
  }
  if (line.line >= info.lines) {
    throw SetupError(line_option, fmt::format("found {}; {} has lines 0..{}", line.line, line.chip,
                                              info.lines == 0 ? 0 : info.lines - 1));
  }
  if (const int result = system.control(chip.get(), GPIO_V2_GET_LINE_IOCTL, &request); result < 0) {
    throw SetupError(line_option,
                     reason_and_remedy(fmt::format("{} line {}", line.chip, line.line), -result));
  }
  into.reset(request.fd);
}

}  // namespace

GpioOutput::GpioOutput(System& system, const GpioLine& line, const std::string& chip_option,
                       const std::string& line_option)
    : system_(system), line_(system) {
  // A line that is active while low makes "1" the pulse in both polarities; it starts inactive.
  std::uint64_t flags = GPIO_V2_LINE_FLAG_OUTPUT;
  if (line.edge == Edge::falling) flags |= GPIO_V2_LINE_FLAG_ACTIVE_LOW;
  gpio_v2_line_request request = request_for(line, flags);
  request.config.num_attrs = 1;
  request.config.attrs[0].mask = 1;
  request.config.attrs[0].attr.id = GPIO_V2_LINE_ATTR_ID_OUTPUT_VALUES;
  request.config.attrs[0].attr.values = 0;
  take_line(system, line_, request, line, chip_option, line_option);
}

bool GpioOutput::set(bool active) noexcept {
  gpio_v2_line_values values = {};
  values.mask = 1;
  values.bits = active ? 1 : 0;
  const int result = system_.control(line_.get(), GPIO_V2_LINE_SET_VALUES_IOCTL, &values);
  error_ = result < 0 ? -result : 0;
  if (error_ == 0) active_ = active;
  return error_ == 0;
}

GpioInput::GpioInput(System& system, const GpioLine& line, const std::string& chip_option,
                     const std::string& line_option)
    : system_(system), line_(system) {
  const std::uint64_t edge =
      line.edge == Edge::falling ? GPIO_V2_LINE_FLAG_EDGE_FALLING : GPIO_V2_LINE_FLAG_EDGE_RISING;
  gpio_v2_line_request request = request_for(line, GPIO_V2_LINE_FLAG_INPUT | edge);
  request.event_buffer_size = kKernelBuffer;
  take_line(system, line_, request, line, chip_option, line_option);
  if (const int result = system.set_nonblocking(line_.get()); result < 0) {
    throw SetupError(line_option, reason_and_remedy(line.chip, -result));
  }
}

bool GpioInput::take(Time /*near*/, Time& at) noexcept {
  if (taken_ == count_) {
    if (drained_) {
      drained_ = false;
      return false;
    }
    const long bytes = system_.read(line_.get(), events_.data(), sizeof events_);
    error_ = bytes < 0 && bytes != -EAGAIN ? static_cast<int>(-bytes) : 0;
    taken_ = 0;
    count_ = bytes > 0 ? static_cast<std::size_t>(bytes) / sizeof(gpio_v2_line_event) : 0;
    drained_ = count_ > 0 && count_ < kEvents;
    if (count_ == 0) return false;
  }
  at = Time(static_cast<Time::rep>(events_[taken_++].timestamp_ns));
  return true;
}

}  // namespace sync_line
