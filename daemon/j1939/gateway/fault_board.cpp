#include "daemon/j1939/gateway/fault_board.h"

#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <string>
#include <utility>

#include "j1939/dds/convert.h"
#include "j1939/dds/texts.h"
#include "j1939/diagnostics.h"
#include "text/counts.h"

namespace cansyncd {
namespace {

using Bytes = std::span<const std::uint8_t>;

/// The fault of `code` stands in the message, however often it has occurred.
bool has_fault(Bytes message, const j1939::TroubleCode& code) noexcept {
  for (std::size_t i = 0; i < j1939::trouble_codes_in(message); ++i) {
    const j1939::TroubleCode one = j1939::trouble_code(message, i);
    if (one.spn == code.spn && one.fmi == code.fmi) return true;
  }
  return false;
}

std::string fault_text(const char* what, std::uint8_t source, const j1939::TroubleCode& code) {
  return fmt::format(
      "address {}: fault {}: SPN {}, FMI {} ({}), {}", source, what, code.spn, code.fmi,
      j1939::dds::failure_mode(code.fmi),
      code.occurrences == 127 ? "an unknown number of times" : text::counted(code.occurrences, "time"));
}

/// The lamps that are on, where no code says why; empty: none.
std::string lamps_without_code(Bytes message) {
  using j1939::Lamp;
  const auto lamps = j1939::lamps_of(message);
  if (!lamps || j1939::trouble_codes_in(message) != 0) return {};
  std::string text;
  const std::pair<Lamp, const char*> all[] = {{lamps->malfunction, "malfunction"},
                                              {lamps->red_stop, "red stop"},
                                              {lamps->amber_warning, "amber warning"},
                                              {lamps->protect, "protect"}};
  for (const auto& [lamp, name] : all) {
    if (lamp == Lamp::on) text += fmt::format("{}{}", text.empty() ? "" : ", ", name);
  }
  return text;
}

}  // namespace

void FaultBoard::take(const j1939_ReceivedMessage& message, SteadyTime now) {
  const bool active = message.pgn == j1939::pgn::kActiveFaults;
  if ((!active && message.pgn != j1939::pgn::kPreviousFaults) || message.source >= told_.size()) return;
  Told& told = told_[message.source][active ? 1 : 0];
  const Bytes bytes(message.data._buffer, message.data._length);
  const bool same = std::equal(told.message.begin(), told.message.end(), bytes.begin(), bytes.end());
  if (same && told.published && now < *told.published + kAgain) return;
  j1939_FaultList list = {};
  if (!j1939::dds::fault_list(bytes, message.source, active, message.receive_time, memory_, list)) return;
  if (active && !same) tell_changes(told, message, now);
  told.message.assign(bytes.begin(), bytes.end());
  told.published = now;
  (void)writer_.write(list);
}

void FaultBoard::tell_changes(const Told& before, const j1939_ReceivedMessage& message, SteadyTime now) {
  const Bytes bytes(message.data._buffer, message.data._length);
  for (std::size_t i = 0; i < j1939::trouble_codes_in(bytes); ++i) {
    const j1939::TroubleCode code = j1939::trouble_code(bytes, i);
    if (has_fault(before.message, code)) continue;
    events_.publish({gateway_SEVERITY_WARNING, "fault_appeared", -1,
                     fault_text("appeared", message.source, code), std::nullopt},
                    now);
  }
  const std::string lamps = lamps_without_code(bytes);
  const std::string lamps_before = lamps_without_code(before.message);
  if (!lamps.empty() && lamps != lamps_before) {
    events_.publish({gateway_SEVERITY_WARNING, "fault_appeared", -1,
                     fmt::format("address {}: fault appeared: lamps on ({}), no code", message.source, lamps),
                     std::nullopt},
                    now);
  } else if (lamps.empty() && !lamps_before.empty()) {
    events_.publish(
        {gateway_SEVERITY_INFO, "fault_gone", -1,
         fmt::format("address {}: fault gone: lamps without a code ({})", message.source, lamps_before),
         std::nullopt},
        now);
  }
  for (std::size_t i = 0; i < j1939::trouble_codes_in(before.message); ++i) {
    const j1939::TroubleCode code = j1939::trouble_code(before.message, i);
    if (has_fault(bytes, code)) continue;
    events_.publish(
        {gateway_SEVERITY_INFO, "fault_gone", -1, fault_text("gone", message.source, code), std::nullopt},
        now);
  }
}

}  // namespace cansyncd
