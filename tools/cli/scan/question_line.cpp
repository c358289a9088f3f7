#include "cli/scan/question_line.h"

#include <stdexcept>

namespace cansync::cli {
namespace {

/// So many frames that the queue has no room for in a row: nobody acknowledges.
constexpr unsigned kMostRefused = 50;
/// So many error frames without one answer: wrong bit rate, or nobody acknowledges.
constexpr std::uint64_t kMostErrorFrames = 500;

constexpr const char* kNobodyAcknowledges =
    "no frame gets onto the bus: nobody acknowledges, or the bit rate is another; look at cable, both terminating "
    "resistors, power of the drives, and the bit rate";

}  // namespace

std::optional<ask::Answer> QuestionLine::ask(const ask::Question& question) {
  const std::uint64_t before = sent_;
  // The slave may have begun the upload, whatever it answers.
  const auto close_what_began = [&] {
    if (std::holds_alternative<ask::BlockQuestion>(question) && sent_ != before) close(asked_slave(question));
  };
  try {
    auto answer = wait_for_answer(question);
    if (!answer) close_what_began();
    return answer;
  } catch (const std::runtime_error&) {
    close_what_began();
    throw;
  }
}

/// As far as the line lets it.
void QuestionLine::close(SlaveNumber slave) noexcept {
  try {
    wait_for_answer(ask::CloseQuestion{slave});
  } catch (const std::exception&) {
    return;
  }
}

std::optional<ask::Answer> QuestionLine::wait_for_answer(const ask::Question& question) {
  const bool closes = std::holds_alternative<ask::CloseQuestion>(question);
  asker_.ask(question, port_.now());
  for (;;) {
    if (stop_.load() && !closes) return std::nullopt;
    take_frames();
    if (asker_.master_heard() && !closes)
      throw std::runtime_error(
          "somebody else sends what a master sends: nothing more is asked. Switch that master off, or learn "
          "from it with `cansync learn`");
    const Duration now = port_.now();
    if (const auto answer = asker_.answer(now)) return answer;
    if (const auto frame = asker_.take(now)) {
      send(*frame);
      continue;
    }
    port_.wait(asker_.next());
  }
}

void QuestionLine::take_frames() {
  can::Frame frame;
  while (port_.receive(frame)) {
    if (frame.error && ++error_frames_ > kMostErrorFrames) throw std::runtime_error(kNobodyAcknowledges);
    asker_.receive(frame, port_.now());
  }
}

void QuestionLine::send(const can::Frame& frame) {
  switch (port_.send(frame)) {
    case can::SocketResult::done:
      refused_ = 0;
      ++sent_;
      return;
    case can::SocketResult::interface_down:
      throw std::runtime_error("the interface is down; `ip link set NAME up` sets it up");
    case can::SocketResult::interface_gone:
      throw std::runtime_error("the interface has gone");
    default:
      break;
  }
  asker_.left_out();
  if (++refused_ > kMostRefused) throw std::runtime_error(kNobodyAcknowledges);
}

}  // namespace cansync::cli
