#include "cli/trace/trace_writer.h"

#include <fmt/format.h>

#include <cerrno>
#include <system_error>

#include "cli/text/values.h"

namespace cansync::cli {

TraceCapture::TraceCapture(const std::string& path, Output& output, std::string_view option)
    : path_(path), output_(output), file_(nullptr, &std::fclose) {
  if (path == "-") {
    if (output.data_on_terminal())
      throw UsageError(
          fmt::format("{}: standard output is a terminal; allowed: a file, or a pipe behind '-'", option));
  } else {
    file_.reset(std::fopen(path.c_str(), "wbe"));
    if (!file_) throw std::system_error(errno, std::generic_category(), path);
  }
  put(can::PcapngWriter::begin("cansync " CANSYNC_VERSION));
  flush();
}

void TraceCapture::write(std::chrono::nanoseconds time, std::string_view interface, const can::Frame& frame) {
  put(writer_.frame(time, interface, frame));
}

void TraceCapture::put(std::string_view bytes) {
  if (!file_) return output_.bytes(bytes);
  if (std::fwrite(bytes.data(), 1, bytes.size(), file_.get()) != bytes.size())
    throw std::system_error(errno, std::generic_category(), path_);
}

void TraceCapture::flush() {
  if (file_ && std::fflush(file_.get()) != 0) throw std::system_error(errno, std::generic_category(), path_);
}

}  // namespace cansync::cli
