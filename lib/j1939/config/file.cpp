#include "j1939/config/file.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "can/frame_length.h"
#include "j1939/config/options.h"
#include "j1939/transport.h"

namespace cansyncd {
namespace {

/// `key` says what a node sends.
void check_group(j1939::Pgn number, const std::string& key, Findings& findings) {
  if (!j1939::is_pgn(number))
    findings.problem(
        key, fmt::format("found 0x{:X}, whose lowest byte is the destination's place below PDU format 240; "
                         "allowed: 0x{:X}",
                         number, number & ~0xFFu));
  if (j1939::is_reserved(number))
    findings.problem(
        key, fmt::format("found 0x{:X}, which the transport protocol or the address claim themselves send; "
                         "allowed: all but 0xC700, 0xC800, 0xEB00, 0xEC00, 0xEE00",
                         number));
}

void finish_pgn_ranges(J1939Draft& draft, Findings& findings) {
  for (std::size_t n = 0; n < draft.ranges.size(); ++n) {
    const J1939Draft::Range& found = draft.ranges[n];
    if (!found.given) continue;
    const j1939::Pgn first = found.first.value_or(0);
    const j1939::PgnRange range{first, found.last.value_or(found.first.value_or(j1939::kLargestPgn)),
                                found.source};
    draft.config.receive.push_back(range);
    if (range.last < range.first)
      findings.problem(fmt::format("receive.{}.first", n),
                       fmt::format("found 0x{:X}, which is after last, 0x{:X}; allowed: 0..0x{:X}",
                                   range.first, range.last, range.last));
  }
  if (draft.config.receive.empty()) draft.config.receive.push_back({});
}

void finish_provided(J1939Draft& draft, Findings& findings) {
  for (std::size_t n = 0; n < draft.provided.size(); ++n) {
    const J1939Draft::Offer& found = draft.provided[n];
    if (!found.given) continue;
    for (std::size_t other = 0; other < n; ++other) {
      if (!draft.provided[other].given || draft.provided[other].provided.number != found.provided.number)
        continue;
      findings.problem(fmt::format("provide.{}.pgn", n),
                       fmt::format("found 0x{:05X}, which provide.{} has; allowed: each group once",
                                   found.provided.number, other));
    }
    draft.config.provided.push_back(found.provided);
    check_group(found.provided.number, fmt::format("provide.{}.pgn", n), findings);
    if (found.provided.period > j1939::Time{0} && found.provided.data.empty())
      findings.problem(fmt::format("provide.{}.period_ms", n),
                       "found without data; allowed: with the bytes that are sent (data)");
  }
}

/// Of a group, as `can::share_of_bus`, without stuff bits.
std::int64_t share_of(const j1939::Provided& group, std::uint32_t bits_per_second) {
  constexpr unsigned kPacketBits = can::unstuffed_bits(8) + can::kExtendedBits;
  if (group.period <= j1939::Time{0}) return 0;
  const std::size_t bytes = group.data.size();
  const unsigned bits = bytes > 8
                            ? (1 + j1939::packets_of(bytes)) * kPacketBits
                            : can::unstuffed_bits(static_cast<std::uint8_t>(bytes)) + can::kExtendedBits;
  return can::share_of_bus(bits, group.period, bits_per_second);
}

/// What is sent to all again and again must have room on the bus.
void check_load(const J1939Draft& draft, Findings& findings) {
  const std::uint32_t rate = draft.config.bus.bits_per_second;
  std::int64_t share = 0;
  std::int64_t most = 0;
  std::size_t number = 0;
  for (std::size_t n = 0; n < draft.provided.size(); ++n) {
    if (!draft.provided[n].given) continue;
    const std::int64_t its = share_of(draft.provided[n].provided, rate);
    share += its;
    if (std::exchange(most, std::max(most, its)) < its) number = n;
  }
  if (share <= can::kWholeBus) return;
  const auto period =
      std::chrono::duration_cast<std::chrono::milliseconds>(draft.provided[number].provided.period);
  findings.problem(
      fmt::format("provide.{}.period_ms", number),
      fmt::format(
          "found {} ms, but the groups with a period together take {} % of the bus at {} bit/s, without any other "
          "message; allowed: up to 100 %: longer periods, or fewer of them",
          period.count(), share * 100 / can::kWholeBus, rate));
}

void finish_ecus(J1939Draft& draft, Findings& findings) {
  for (unsigned n = 0; n < draft.ecus.size(); ++n) {
    J1939Draft::Ecu& found = draft.ecus[n];
    if (!found.given) continue;
    found.ecu.number = n;
    // Those who were given no identity of their own still need different NAMEs.
    found.ecu.name.identity = found.identity.value_or(1000 + n);
    draft.config.ecus.push_back(found.ecu);
    check_group(found.ecu.group, fmt::format("ecu.{}.pgn", n), findings);
    if (found.ecu.destination == j1939::kNullAddress)
      findings.problem(fmt::format("ecu.{}.destination", n), "found 254; allowed: 0..253, or 255 for all");
  }
}

void check_address(const J1939Config& config, Findings& findings) {
  if (config.first_other > config.last_other)
    findings.problem("address.first_other",
                     fmt::format("found {}, which is after address.last_other, {}; allowed: 0..{}",
                                 config.first_other, config.last_other, config.last_other));
}

}  // namespace

J1939File build_j1939_config(config::Settings settings, const std::string& path) {
  return build_file(std::move(settings), path, j1939_option_rows(),
                    [](J1939Draft& draft, Findings& findings) {
                      check_address(draft.config, findings);
                      finish_pgn_ranges(draft, findings);
                      finish_provided(draft, findings);
                      check_load(draft, findings);
                      finish_ecus(draft, findings);
                    });
}

J1939File load_j1939_config(const config::Source& source, std::span<const std::string> overrides) {
  return build_j1939_config(config::read_settings(source, overrides, j1939_options()), source.path);
}

}  // namespace cansyncd
