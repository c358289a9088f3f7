#include "cli/layer2/send_verb.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "cli/base/interrupt.h"
#include "cli/connect/bus_verb.h"
#include "cli/connect/gateway_reply.h"
#include "cli/layer2/frame_lines.h"
#include "cli/layer2/send_frames.h"
#include "cli/text/values.h"
#include "layer2/client/frame_client.h"
#include "text/counts.h"

namespace cansync::cli {
namespace {

using Clock = std::chrono::steady_clock;

/// The arguments of `can send` as they were typed.
struct SendTexts {
  std::vector<std::string> frames;
  std::string every;
  std::string count;
  layer2::client::SendChoice choice;
};

/// How often the frames are sent.
struct Repetition {
  std::uint64_t count = 1;            ///< 0: until Ctrl-C
  std::chrono::microseconds every{};  ///< from the first frame of one turn to that of the next; 0: at once
};

Repetition repetition_of(const SendTexts& texts) {
  constexpr double kLongest = 3'600'000.0;  // ms
  Repetition repetition;
  if (!texts.every.empty()) {
    const double period_ms = parse_real(texts.every, "--every");
    if (!(period_ms >= 1.0 && period_ms <= kLongest))
      throw UsageError(
          fmt::format("--every: found '{}'; allowed: 1 to {:.0f} milliseconds", texts.every, kLongest));
    repetition.every = std::chrono::microseconds(static_cast<std::int64_t>(period_ms * 1000.0));
    repetition.count = 0;
  }
  if (!texts.count.empty())
    repetition.count = static_cast<std::uint64_t>(parse_integer(texts.count, "--count", 1, INT32_MAX));
  return repetition;
}

/// One run of the verb.
class Sender {
 public:
  Sender(Session& session, const SendTexts& texts, std::vector<can::Frame> frames)
      : session_(session),
        choice_(texts.choice),
        frames_(std::move(frames)),
        client_(connect_bus<layer2::client::FrameClient>(session)) {}

  /// Turn after turn, until one fails, or Ctrl-C. A turn that is not over in time costs the next ones.
  ExitCode run(const Repetition& repetition) {
    (void)client_.status(session_.search_time());
    const bool alone = frames_.size() == 1 && repetition.count == 1;
    auto due = Clock::now();
    for (std::uint64_t turn = 0; repetition.count == 0 || turn < repetition.count; ++turn) {
      for (const can::Frame& frame : frames_)
        if (const ExitCode code = send(frame, alone); code != ExitCode::done) return end(code, alone);
      due += repetition.every;
      if (repetition.every.count() != 0) skip(due, repetition.every);
      if (turn + 1 != repetition.count && pause_until(due)) break;
    }
    return end(ExitCode::done, alone);
  }

 private:
  ExitCode send(const can::Frame& frame, bool alone) {
    const layer2::client::SendResult result = client_.send(frame, session_.monitoring_ms(), choice_);
    JsonObject object;
    add_frame(frame, object);
    object.add("sent_time_ns", result.sent_time);
    const std::string where = fmt::format("frame {}", identifier_text(frame));
    const ExitCode code =
        session_.finish(reply_of(result), object, where, alone ? where + " sent" : std::string());
    if (code == ExitCode::done) ++sent_;
    return code;
  }

  /// Leaves out turns whose time is over.
  void skip(Clock::time_point& due, std::chrono::microseconds every) {
    for (const auto now = Clock::now(); due + every <= now; due += every) ++left_out_;
  }

  /// True at Ctrl-C.
  static bool pause_until(Clock::time_point due) {
    constexpr auto kLook = std::chrono::milliseconds(50);
    for (auto now = Clock::now(); now < due && !interrupt_flag().load(); now = Clock::now())
      std::this_thread::sleep_until(std::min<Clock::time_point>(due, now + kLook));
    return interrupt_flag().load();
  }

  ExitCode end(ExitCode code, bool alone) {
    if (!alone && !session_.json()) session_.output().remark(text::counted(sent_, "frame") + " sent");
    if (left_out_ != 0)
      session_.output().remark("left out " + text::counted(left_out_, "time") +
                               ": the turn before was not over in time");
    return code;
  }

  Session& session_;
  layer2::client::SendChoice choice_;
  std::vector<can::Frame> frames_;
  layer2::client::FrameClient client_;
  std::uint64_t sent_ = 0;
  std::uint64_t left_out_ = 0;
};

ExitCode send_verb(Session& session, const SendTexts& texts) {
  std::vector<can::Frame> frames;
  frames.reserve(texts.frames.size());
  for (const std::string& text : texts.frames) frames.push_back(parse_sent_frame(text));
  const Repetition repetition = repetition_of(texts);
  return Sender(session, texts, std::move(frames)).run(repetition);
}

}  // namespace

void add_send_verb(CLI::App& can, Verb& chosen) {
  auto* send = can.add_subcommand("send", "send frames");
  auto texts = std::make_shared<SendTexts>();
  send->add_option("FRAME", texts->frames,
                   "ID#DATA, hexadecimal: 123#0102FF, with eight digits of the identifier for 29 bits; "
                   "123#R3: a remote frame that asks for 3 bytes")
      ->required();
  send->add_option("--every", texts->every,
                   "send them again and again, so many milliseconds apart, until Ctrl-C or --count")
      ->type_name("MS");
  send->add_option("--count", texts->count, "send them so often (default 1; with --every without end)")
      ->type_name("N");
  send->add_flag("--high", texts->choice.high_priority,
                 "wait in the queue of high priority, which is sent first");
  send->add_flag("--by-id", texts->choice.by_identifier,
                 "wait in front of frames that lose the arbitration against it, second at best");
  send->footer(
      "Of a bus with bus.protocol = \"layer2\". Each frame is sent when the one before it was on the bus; "
      "the first that\nfails is the last. Without an answer it may have been on the bus, or be sent yet.");
  run_when_named(*send, chosen, texts, send_verb);
}

}  // namespace cansync::cli
