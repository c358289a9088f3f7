#include "j1939/dds/texts.h"

#include <fmt/format.h>

#include <array>

namespace j1939::dds {
namespace {

std::string_view reason_of_timeout(const Answer& answer) noexcept {
  if (!answer.claiming) return can::reason_not_sent(answer.obstacle);
  return "not sent within the monitoring time: the address is still being claimed, for which another node must "
         "be on the bus; see NodeStatus";
}

/// Something was on the bus, or may have been.
std::string_view reason_of_no_answer(JobEnd ended_by) noexcept {
  switch (ended_by) {
    case JobEnd::cancelled:
      return "cancelled when a part of it, or the request, was on the bus: the other node may act on it";
    case JobEnd::stopped:
      return "the daemon was stopped when a part of it, or the request, was on the bus: the other node may act "
             "on it";
    case JobEnd::lost:
      return "the daemon lost its address to a stronger NAME when a part of it, or the request, was on the bus: "
             "the other node may act on it; see NodeStatus";
    case JobEnd::unanswered:
    case JobEnd::time:
      break;
  }
  return "begun, but not seen on the bus or not answered within the monitoring time or the standard's "
         "time-outs; check that the node is there and has this group";
}

std::string_view reason_of_refusal(std::uint8_t control) noexcept {
  switch (control) {
    case 1:
      return "the node does not have this group (negative acknowledgement)";
    case 2:
      return "the node denies access to this group";
    default:
      return "the node cannot respond now; ask again later";
  }
}

std::string_view reason_of_abort(std::uint8_t reason) noexcept {
  switch (static_cast<AbortReason>(reason)) {
    case AbortReason::busy:
      return "it has a connection with this node already";
    case AbortReason::no_resources:
      return "it needs its resources elsewhere";
    case AbortReason::timeout:
      return "it waited too long";
    case AbortReason::cts_while_sending:
      return "a clear to send came in the midst of packets";
    case AbortReason::too_many_repeats:
      return "too many packets had to be repeated";
    case AbortReason::unexpected_data:
      return "a packet it did not expect";
    case AbortReason::bad_sequence:
      return "a packet's number that cannot be";
    case AbortReason::twice:
      return "a packet twice";
    case AbortReason::too_long:
      return "the message is too long for it";
    case AbortReason::wrong_count:
      return "more packets were announced than it asked for";
    case AbortReason::wrong_offset:
      return "an offset that is not that of the packet it asked for";
  }
  return "no reason that the standard knows";
}

}  // namespace

std::string_view name_of(ClaimState state) noexcept {
  return name(state == ClaimState::asking ? ClaimState::claiming : state);
}

std::string_view name_of(Outcome outcome) noexcept {
  switch (outcome) {
    case Outcome::done:
      return "done";
    case Outcome::refused:
      return "refused";
    case Outcome::aborted:
      return "aborted";
    case Outcome::no_answer:
      return "no_answer";
    case Outcome::timeout:
      return "timeout";
    case Outcome::cancelled:
      return "cancelled";
    case Outcome::address_lost:
      return "address_lost";
    case Outcome::stopped:
      break;
  }
  return "stopped";
}

std::string reason_of(const Answer& answer) {
  switch (answer.outcome) {
    case Outcome::done:
      return {};
    case Outcome::refused:
      return std::string(reason_of_refusal(answer.code));
    case Outcome::aborted:
      return fmt::format("the node broke the connection off: {} (reason {})", reason_of_abort(answer.code),
                         answer.code);
    case Outcome::no_answer:
      return std::string(reason_of_no_answer(answer.ended_by));
    case Outcome::timeout:
      return std::string(reason_of_timeout(answer));
    case Outcome::cancelled:
      return "cancelled";
    case Outcome::address_lost:
      return "the daemon lost its address to a stronger NAME before this was sent; see NodeStatus";
    case Outcome::stopped:
      break;
  }
  return "the daemon was stopped before this was sent";
}

std::string_view failure_mode(std::uint8_t fmi) noexcept {
  static constexpr std::array<std::string_view, 32> kModes = {"above normal, most severe",
                                                              "below normal, most severe",
                                                              "erratic or incorrect",
                                                              "voltage high",
                                                              "voltage low",
                                                              "current low or open circuit",
                                                              "current high or grounded",
                                                              "mechanical",
                                                              "abnormal frequency or pulse width",
                                                              "abnormal update rate",
                                                              "abnormal rate of change",
                                                              "root cause not known",
                                                              "bad device or component",
                                                              "out of calibration",
                                                              "special instructions",
                                                              "above normal, least severe",
                                                              "above normal, moderate",
                                                              "below normal, least severe",
                                                              "below normal, moderate",
                                                              "network data in error",
                                                              "drifted high",
                                                              "drifted low",
                                                              "reserved",
                                                              "reserved",
                                                              "reserved",
                                                              "reserved",
                                                              "reserved",
                                                              "reserved",
                                                              "reserved",
                                                              "reserved",
                                                              "reserved",
                                                              "condition exists"};
  return kModes[fmi & 31];
}

}  // namespace j1939::dds
