#include "cansync/observe/evidence.h"

#include <algorithm>
#include <numeric>
#include <type_traits>
#include <variant>

#include "can/frame_length.h"

namespace cansync::observe {
namespace {

/// At least so many RC that repeat the number of their command, or reference values at a steady rate, outweigh what
/// looks like another protocol on the same bus.
constexpr std::uint64_t kSureReplies = 2;
constexpr unsigned kSureRate = 50;  // percent
constexpr std::uint64_t kLeastHeartbeats = 2;

unsigned percent(std::uint64_t part, std::uint64_t all) noexcept {
  return all == 0 ? 0 : static_cast<unsigned>(100 * part / all);
}

// --- J1939: parameter groups of SAE J1939-21 and -81

constexpr std::uint32_t kAddressClaimed = 0xEE;

constexpr std::uint32_t pdu_format(std::uint32_t identifier) noexcept {
  return (identifier >> 16) & 0xFF;
}

/// Acknowledgement, request, both transport protocols, address claimed, proprietary, and all that are broadcast.
bool is_j1939_group(std::uint32_t identifier) noexcept {
  const std::uint32_t format = pdu_format(identifier);
  return format >= 0xE8 && format != 0xE9 && format != 0xED;
}

// --- CANopen: connection set of CiA 301

constexpr std::uint32_t kSdoAnswer = 0x580;
constexpr std::uint32_t kSdoRequest = 0x600;
constexpr std::uint32_t kHeartbeat = 0x700;

/// Boot-up, stopped, operational, pre-operational; bit 7 toggles with node guarding.
bool is_heartbeat(const can::Frame& frame) noexcept {
  if (frame.dlc != 1) return false;
  const unsigned state = frame.data[0] & 0x7Fu;
  return state == 0 || state == 4 || state == 5 || state == 0x7F;
}

/// Index and sub-index.
std::uint32_t object_of(const can::Frame& frame) noexcept {
  return frame.data[1] | (static_cast<std::uint32_t>(frame.data[2]) << 8) |
         (static_cast<std::uint32_t>(frame.data[3]) << 16);
}

bool is_transfer(const Telegram& telegram) noexcept {
  return std::holds_alternative<TransferInitialise>(telegram) ||
         std::holds_alternative<UploadBlock>(telegram) || std::holds_alternative<DownloadBlock>(telegram);
}

}  // namespace

unsigned LineEvidence::identifiers_percent() const noexcept {
  return percent(telegrams, frames);
}
unsigned LineEvidence::rate_percent() const noexcept {
  return percent(in_rate, rated);
}
unsigned LineEvidence::answers_percent() const noexcept {
  return percent(expected, answers);
}

unsigned LineEvidence::confidence() const noexcept {
  if (telegrams < kLeastTelegrams || references + commands == 0) return 0;
  if (references == 0 && actual > 0) return 0;
  if (answers == 0) return std::min(identifiers_percent(), rate_percent());
  return (identifiers_percent() + rate_percent() + answers_percent()) / 3;
}

LineKind LineEvidence::kind() const noexcept {
  if (frames == 0) return edges == 0 ? LineKind::silent : LineKind::unknown;
  const bool cansync = confidence() >= kLeastConfidence;
  const bool sure =
      cansync && (replies >= kSureReplies || (references >= kLeastTelegrams && rate_percent() >= kSureRate));
  if (sure) return LineKind::cansync;
  if (2 * extended > frames && (claims > 0 || 2 * j1939 > extended)) return LineKind::j1939;
  if ((heartbeats >= kLeastHeartbeats && heartbeats > no_heartbeats) || sdo_pairs > 0)
    return LineKind::canopen;
  return cansync ? LineKind::cansync : LineKind::unknown;
}

void EvidenceTaker::sync(const can::Frame* frame) noexcept {
  ++out_.edges;
  reference_since_edge_ = command_since_edge_ = false;
  if (frame == nullptr) return;
  ++out_.frames;
  ++out_.telegrams;
}

void EvidenceTaker::frame(const can::Frame& frame) {
  if (frame.error) return;
  ++out_.frames;
  if (frame.extended) return extended(frame.identifier());
  canopen(frame);
  const Decoded decoded = decode(frame);
  const auto* telegram = std::get_if<Telegram>(&decoded);
  if (telegram == nullptr) return;
  ++out_.telegrams;
  this->telegram(*telegram);
}

void EvidenceTaker::telegram(const Telegram& telegram) {
  std::visit(
      [&](const auto& one) {
        using T = std::decay_t<decltype(one)>;
        if constexpr (std::is_same_v<T, ReferenceTelegram>) {
          polled_[index(one.channel)] = one.polled;
          if (one.channel != Channel::one) return;
          ++out_.references;
          references_in_rate_ += reference_since_edge_ ? 0 : 1;
          reference_since_edge_ = true;
        } else if constexpr (std::is_same_v<T, ActualTelegram>) {
          ++out_.answers;
          ++out_.actual;
          if (polled_[index(one.channel)] == one.slave.value()) ++out_.expected;
        } else if constexpr (std::is_same_v<T, ParameterReply> || std::is_same_v<T, TransferReply>) {
          ++out_.answers;
          const auto& asked = asked_[one.slave.value()];
          constexpr bool transfer = std::is_same_v<T, TransferReply>;
          bool fits = asked && asked->transfer == transfer;
          if constexpr (!transfer) fits = fits && asked->number == one.number.value();
          if (!fits) return;
          ++out_.expected;
          ++out_.replies;
        } else if constexpr (!std::is_same_v<T, ActionCommand>) {
          ++out_.commands;
          commands_in_rate_ += command_since_edge_ ? 0 : 1;
          command_since_edge_ = true;
          Question question{is_transfer(telegram), 0};
          if constexpr (std::is_same_v<T, ParameterCommand>) question.number = one.number.value();
          asked_[one.slave.value()] = question;
        }
      },
      telegram);
}

void EvidenceTaker::extended(std::uint32_t identifier) noexcept {
  ++out_.extended;
  if (is_j1939_group(identifier)) ++out_.j1939;
  if (pdu_format(identifier) == kAddressClaimed) ++out_.claims;
}

void EvidenceTaker::canopen(const can::Frame& frame) noexcept {
  if (frame.remote) return;
  const std::uint32_t node = frame.id & (kNodes - 1);
  const std::uint32_t function = frame.id & ~(kNodes - 1);
  if (node == 0) return;
  if (function == kHeartbeat) ++(is_heartbeat(frame) ? out_.heartbeats : out_.no_heartbeats);
  if (frame.dlc != 8) return;
  if (function == kSdoRequest) object_[node] = object_of(frame);
  if (function != kSdoAnswer || object_[node] != object_of(frame)) return;
  ++out_.sdo_pairs;
  object_[node].reset();
}

LineEvidence EvidenceTaker::evidence(const IntervalVote::Result& interval) const noexcept {
  LineEvidence out = out_;
  if (out.edges > 0) {
    out.rated = out.references > 0 ? out.references : out.commands;
    out.in_rate = out.references > 0 ? references_in_rate_ : commands_in_rate_;
  } else {
    // Reference values come in every interval, commands when there is something to ask.
    out.rated = interval.among;
    out.in_rate = out.references > 0 ? interval.votes : interval.in_step;
  }
  return out;
}

void StampCheck::frame(Duration at, const can::Frame& frame) noexcept {
  const unsigned bits = can::frame_bits(frame);
  if (last_ && !frame.error) {
    ++frames_;
    step_ = Duration{std::gcd(step_.count(), (at - *last_).count())};
    // Whether a stamp is of a frame's start or end, one of the two lies between it and the next.
    const auto least = static_cast<Duration::rep>(std::min(bits, last_bits_));
    for (std::size_t i = 0; i < kSlotTimes.size(); ++i)
      if (2 * (at - *last_) < least * kSlotTimes[i].bit_time()) ++too_near_[i];
  }
  last_ = at;
  last_bits_ = bits;
}

StampCheck::Result StampCheck::result(BitRate bit_rate) const noexcept {
  return {frames_, too_near_[static_cast<unsigned>(bit_rate)], step_};
}

}  // namespace cansync::observe
