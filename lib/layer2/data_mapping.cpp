#include "layer2/data_mapping.h"

#include <algorithm>
#include <bitset>
#include <memory>
#include <utility>

#include "can/frame_length.h"

namespace layer2 {
namespace {

constexpr std::size_t kFrameBytes = 8;

/// What of a table was seen so far.
struct Seen {
  std::bitset<DataMapping::kBytes> filled;  ///< bytes of the image in
  struct Message {
    std::uint32_t identifier = 0;
    std::uint8_t bytes = 0;  ///< a bit for each byte that is mapped
  };
  std::vector<Message> in;
  std::vector<Message> out;
};

MappingProblem look_at(const MappingSettings& settings, const MappedBytes& entry, Seen& seen) {
  const bool wide = settings.rule.extended;
  if (entry.identifier > (wide ? can::kExtendedIdentifierMask : can::kStandardIdentifierMask))
    return MappingProblem::identifier;
  can::Frame frame{.id = entry.identifier, .extended = wide};
  if (!entry.output && !settings.table_alone && !takes(settings.rule, frame))
    return MappingProblem::not_in_rule;
  if (entry.size == 0 || entry.offset + entry.size > kFrameBytes) return MappingProblem::bytes;
  if (entry.address + entry.size > DataMapping::kBytes) return MappingProblem::address;
  auto& messages = entry.output ? seen.out : seen.in;
  auto message = std::find_if(messages.begin(), messages.end(),
                              [&](const auto& one) { return one.identifier == entry.identifier; });
  if (message == messages.end()) {
    if (messages.size() == DataMapping::kMessages) return MappingProblem::messages;
    message = messages.insert(messages.end(), {entry.identifier, 0});
  }
  for (unsigned i = 0; i < entry.size; ++i) {
    const auto bit = static_cast<std::uint8_t>(1u << (entry.offset + i));
    if ((message->bytes & bit) != 0) return MappingProblem::bytes_taken;
    message->bytes |= bit;
    if (entry.output) continue;
    if (seen.filled.test(entry.address + i)) return MappingProblem::address_taken;
    seen.filled.set(entry.address + i);
  }
  return MappingProblem::none;
}

}  // namespace

MappingFault DataMapping::check(const MappingSettings& settings, std::span<const MappedBytes> table) {
  if (settings.interval <= Time{0}) return {MappingProblem::interval, 0};
  const auto seen = std::make_unique<Seen>();
  for (std::size_t i = 0; i < table.size(); ++i) {
    if (const auto problem = look_at(settings, table[i], *seen); problem != MappingProblem::none)
      return {problem, i};
  }
  return {};
}

DataMapping::Telegram* DataMapping::find(std::vector<Telegram>& telegrams,
                                         std::uint32_t identifier) noexcept {
  for (Telegram& telegram : telegrams) {
    if (telegram.identifier == identifier) return &telegram;
  }
  return nullptr;
}

void DataMapping::add(std::vector<Telegram>& telegrams, const MappedBytes& bytes) {
  Telegram* telegram = find(telegrams, bytes.identifier);
  if (telegram == nullptr) {
    telegram = &telegrams.emplace_back();
    telegram->identifier = bytes.identifier;
    telegram->address.fill(kUnmapped);
  }
  for (unsigned i = 0; i < bytes.size; ++i)
    telegram->address[bytes.offset + i] = static_cast<std::uint16_t>(bytes.address + i);
  telegram->length = std::max(telegram->length, static_cast<std::uint8_t>(bytes.offset + bytes.size));
}

std::int64_t DataMapping::share_of_bus(std::uint32_t bits_per_second) const noexcept {
  if (settings_.on_change) return 0;
  std::int64_t bits = 0;
  for (const Telegram& telegram : out_) bits += can::least_bits(telegram.last);
  return can::share_of_bus(bits, settings_.interval, bits_per_second);
}

void DataMapping::configure(const MappingSettings& settings, std::span<const MappedBytes> table) {
  stop();
  settings_ = settings;
  in_.clear();
  out_.clear();
  for (const MappedBytes& bytes : table) add(bytes.output ? out_ : in_, bytes);
  std::sort(in_.begin(), in_.end(),
            [](const Telegram& a, const Telegram& b) { return a.identifier < b.identifier; });
  inputs_.fill(0);
  outputs_.fill(0);
  sending_ = false;
  for (std::size_t i = 0; i < out_.size(); ++i) out_[i].last = frame(static_cast<std::uint8_t>(i));
}

void DataMapping::swap_table(DataMapping& other) noexcept {
  stop();
  std::swap(settings_, other.settings_);
  in_.swap(other.in_);
  out_.swap(other.out_);
  inputs_.fill(0);
  outputs_.fill(0);
  sending_ = false;
  ++table_;
}

void DataMapping::start(Time now) noexcept {
  runs_ = !in_.empty() || !out_.empty();
  next_ = now;
  for (Telegram& telegram : out_) {
    telegram.due = false;
    telegram.sent = false;
  }
  turn_ = 0;
}

void DataMapping::stop() noexcept {
  runs_ = false;
  for (Telegram& telegram : out_) telegram.due = false;
}

bool DataMapping::receive(const can::Frame& frame) noexcept {
  if (!runs_ || in_.empty() || frame.remote || frame.extended != settings_.rule.extended) return false;
  if (!settings_.table_alone && !takes(settings_.rule, frame)) return false;
  const std::uint32_t identifier = frame.identifier();
  const auto found = std::lower_bound(in_.begin(), in_.end(), identifier,
                                      [](const Telegram& a, std::uint32_t b) { return a.identifier < b; });
  if (found == in_.end() || found->identifier != identifier) {
    if (settings_.table_alone) return false;
    ++dropped_;
    return true;
  }
  ++received_;
  for (std::size_t i = 0; i < std::min<std::size_t>(frame.dlc, kFrameBytes); ++i) {
    if (found->address[i] != kUnmapped) inputs_[found->address[i]] = frame.data[i];
  }
  return true;
}

void DataMapping::advance(Time now) noexcept {
  if (!runs_ || now < next_) return;
  next_ += ((now - next_) / settings_.interval + 1) * settings_.interval;
  if (!next()) turn_ = 0;
  for (std::size_t i = 0; i < out_.size(); ++i) {
    Telegram& telegram = out_[i];
    const bool known = telegram.sent || !settings_.first_always;
    const bool due = sending_ && (!settings_.on_change || !known || telegram.lost ||
                                  frame(static_cast<std::uint8_t>(i)) != telegram.last);
    if (due && telegram.due) {
      ++telegram.left_out;
      ++left_out_;
    }
    telegram.due = due;
  }
}

void DataMapping::set_sending(bool sending) noexcept {
  sending_ = sending;
  if (sending) return;
  for (Telegram& telegram : out_) telegram.due = false;
}

Time DataMapping::next_deadline() const noexcept {
  return runs_ && !out_.empty() ? next_ : Time::max();
}

std::optional<std::uint8_t> DataMapping::next() const noexcept {
  for (std::size_t i = 0; i < out_.size(); ++i) {
    const std::size_t telegram = (turn_ + i) % out_.size();
    if (out_[telegram].due) return static_cast<std::uint8_t>(telegram);
  }
  return std::nullopt;
}

can::Frame DataMapping::frame(std::uint8_t telegram) const noexcept {
  const Telegram& out = out_[telegram];
  can::Frame frame{.id = out.identifier, .extended = settings_.rule.extended, .dlc = out.length};
  for (std::size_t i = 0; i < out.length; ++i) {
    if (out.address[i] != kUnmapped) frame.data[i] = outputs_[out.address[i]];
  }
  return frame;
}

void DataMapping::lost(std::uint8_t telegram) noexcept {
  if (telegram < out_.size()) out_[telegram].lost = out_[telegram].sent;
}

void DataMapping::controller_emptied() noexcept {
  for (Telegram& telegram : out_) telegram.lost = telegram.sent;
}

void DataMapping::handed_over(std::uint8_t telegram, const can::Frame& frame) noexcept {
  Telegram& out = out_[telegram];
  out.due = false;
  out.sent = true;
  out.lost = false;
  out.last = frame;
  turn_ = telegram + 1u;
  ++sent_;
}

}  // namespace layer2
