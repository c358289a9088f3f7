#include "cli/layer2/dump_form.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <span>
#include <utility>
#include <vector>

#include "can/candump.h"
#include "cli/base/session.h"
#include "cli/dbc/dbc_file.h"
#include "cli/layer2/frame_lines.h"

namespace cansync::cli {
namespace {

/// Width of eight bytes with blanks between.
constexpr std::size_t kDataWidth = 23;

/// The signals of a frame; a remote one has none.
std::vector<dbc::Reading> readings_of(const dbc::Message& message, const can::Frame& frame) {
  if (frame.remote) return {};
  return dbc::read_signals(message,
                           std::span(frame.data).first(std::min<std::size_t>(frame.dlc, frame.data.size())));
}

std::string meaning_of(const dbc::Database& names, const can::Frame& frame) {
  const dbc::Message* message = names.find(frame);
  return message == nullptr ? "" : cli::meaning_of(*message, readings_of(*message, frame));
}

JsonObject dumped_object(const DumpedFrame& dumped, const dbc::Database& names) {
  JsonObject object;
  object.add("time_ns", dumped.time).add("interface", dumped.interface);
  add_frame(dumped.frame, object);
  if (dumped.taken_by) {
    object.add("range", dumped.taken_by->range).add("high_priority", dumped.taken_by->high_priority);
  } else {
    object.add_null("range").add_null("high_priority");
  }
  const dbc::Message* message = names.find(dumped.frame);
  add_meaning(message, message == nullptr ? std::vector<dbc::Reading>() : readings_of(*message, dumped.frame),
              object);
  return object;
}

}  // namespace

std::vector<Table::Column> dump_columns() {
  constexpr auto left = Table::Align::left;
  constexpr auto right = Table::Align::right;
  return {{"TIME", left, "when its last bit was on the bus, in the time zone of this computer", 23},
          {"ID", right, "identifier, hexadecimal: three digits for 11 bits, eight for 29", 8},
          {"LEN", right, "length in bytes, 0 to 8", 3},
          {"RANGE", right, "place in the configuration of the range that takes it; -: recorded", 5},
          {"DATA", left,
           "the bytes, hexadecimal, those that changed in colour; remote: a frame that asks for them",
           kDataWidth},
          {"MEANING", left, "with --dbc: message and signals, with unit and name of the value", 7}};
}

DumpForm::DumpForm(Output& output, Choice choice)
    : output_(output), choice_(std::move(choice)), colours_(output.colours()), table_(dump_columns()) {
  if (!choice_.capture.empty()) capture_ = std::make_unique<TraceCapture>(choice_.capture, output, "--write");
}

std::string DumpForm::painted_data(const can::Frame& frame) {
  std::string plain = fitted(data_text(frame), kDataWidth);
  if (!colours_ || frame.remote) return plain;
  const Key key = (Key{frame.extended} << 32U) | frame.id;
  const auto known = last_.find(key);
  if (known == last_.end()) {
    if (last_.size() < kMostRemembered) last_[key] = frame;
    return plain;
  }
  std::string text;
  for (unsigned i = 0; i < frame.dlc && i < frame.data.size(); ++i) {
    const bool changed = i >= known->second.dlc || known->second.data[i] != frame.data[i];
    text += (i == 0 ? "" : " ") +
            output_.painted(fmt::format("{:02X}", frame.data[i]), changed ? Style::warning : Style::plain);
  }
  known->second = frame;
  return text + plain.substr(data_text(frame).size());
}

void DumpForm::write_line(const DumpedFrame& dumped) {
  const std::string time = time_text(dumped.time, true);
  const std::string identifier = identifier_text(dumped.frame);
  const std::string length = std::to_string(dumped.frame.dlc);
  const std::string range = dumped.taken_by ? std::to_string(dumped.taken_by->range) : "-";
  const std::string data = painted_data(dumped.frame);
  const std::string meaning = meaning_of(choice_.names, dumped.frame);
  table_.append(text_, std::array<std::string_view, 6>{time, identifier, length, range, data, meaning});
}

void DumpForm::write(const DumpedFrame& dumped) {
  const std::chrono::nanoseconds time(dumped.time);
  if (capture_) {
    capture_->write(time, dumped.interface, dumped.frame);
  } else if (choice_.candump) {
    std::array<char, can::kCandumpLineLimit> line{};
    const auto micros = std::chrono::duration_cast<std::chrono::microseconds>(time);
    text_.append(line.data(), can::write_candump_line(micros, dumped.interface, dumped.frame, line));
  } else if (output_.json()) {
    text_ += dumped_object(dumped, choice_.names).text() + '\n';
  } else {
    if (!headed_) table_.append_heading(text_);
    headed_ = true;
    write_line(dumped);
  }
  if (text_.size() >= kMostWaiting) flush();
}

void DumpForm::flush() {
  if (capture_) capture_->flush();
  if (!text_.empty()) output_.bytes(text_);
  text_.clear();
}

}  // namespace cansync::cli
