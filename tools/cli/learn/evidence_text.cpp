#include "cli/learn/evidence_text.h"

#include <fmt/format.h>

#include "text/counts.h"

namespace cansync::cli {

using observe::LineEvidence;
using observe::LineKind;

bool is_other_protocol(const LineEvidence& evidence, std::uint64_t frames) noexcept {
  return frames > 0 && evidence.kind() != LineKind::cansync;
}

std::string protocol_text(const LineEvidence& evidence) {
  switch (evidence.kind()) {
    case LineKind::silent:
      return "-";
    case LineKind::cansync:
      return fmt::format("CANsync, {} %", evidence.confidence());
    case LineKind::j1939:
      return "J1939";
    case LineKind::canopen:
      return "CANopen";
    case LineKind::unknown:
      break;
  }
  return "unknown";
}

std::string evidence_text(const LineEvidence& evidence) {
  switch (evidence.kind()) {
    case LineKind::silent:
      return "no data frame was received";
    case LineKind::cansync:
      break;
    case LineKind::j1939:
      return fmt::format("{} of {} have 29-bit identifiers, {}", evidence.extended,
                         text::counted(evidence.frames, "frame"),
                         text::counted(evidence.claims, "address claim"));
    case LineKind::canopen:
      return fmt::format("{}, {}", text::counted(evidence.heartbeats, "heartbeat"),
                         text::counted(evidence.sdo_pairs, "SDO request with its answer",
                                       "SDO requests with their answers"));
    case LineKind::unknown:
      if (evidence.extended == evidence.frames)
        return "29-bit identifiers alone, of no parameter group of J1939";
      if (evidence.frames == evidence.telegrams &&
          evidence.references + evidence.commands + evidence.answers == 0)
        return "SYNC frames alone; CANsync and CANopen have them";
      if (evidence.telegrams < observe::kLeastTelegrams)
        return fmt::format("{} of {} could be of CANsync; {} are needed", evidence.telegrams,
                           text::counted(evidence.frames, "frame"), observe::kLeastTelegrams);
      break;
  }
  const std::string rate =
      evidence.rated == 0
          ? "no rate to compare"
          : fmt::format("{} % of reference values or commands once an interval", evidence.rate_percent());
  const std::string answers = evidence.answers == 0
                                  ? "no answer"
                                  : fmt::format("{} % of answers to a question", evidence.answers_percent());
  return fmt::format("{} % of identifiers fit, {}, {}", evidence.identifiers_percent(), rate, answers);
}

std::string other_protocol_text(const LineEvidence& evidence) {
  if (evidence.kind() == LineKind::silent)
    return "this does not look like CANsync: there are error frames alone, as with a wrong bit rate or a broken cable";
  const std::string found = protocol_text(evidence);
  const bool known = evidence.kind() == LineKind::j1939 || evidence.kind() == LineKind::canopen;
  return fmt::format("this does not look like CANsync; {}: {}",
                     known ? "it looks like " + found : "what it is, is unknown", evidence_text(evidence));
}

std::string stamps_text(const observe::StampCheck::Result& stamps) {
  if (stamps.frames == 0) return "-";
  if (stamps.bunched()) return "bunched";
  return stamps.coarse() ? "coarse" : "steady";
}

std::string stamps_evidence(const observe::StampCheck::Result& stamps) {
  if (stamps.coarse() && !stamps.bunched())
    return fmt::format("multiples of {}; slots and send margin are not derived from them",
                       text::duration_text(stamps.step));
  if (!stamps.bunched())
    return stamps.frames == 0 ? "no two frames to compare" : "as far apart as frames are long";
  return fmt::format(
      "{} of {} closer than the bit times of a frame, as from a USB adapter without a clock, a virtual "
      "interface, or recordings that were merged; no timing is derived from them",
      stamps.too_near, text::counted(stamps.frames, "time stamp is", "time stamps are"));
}

void remark_on_stamps(Output& output, const observe::StampCheck::Result& stamps) {
  if (!stamps.fine())
    output.remark(fmt::format("time stamps are {}: {}", stamps_text(stamps), stamps_evidence(stamps)));
}

}  // namespace cansync::cli
