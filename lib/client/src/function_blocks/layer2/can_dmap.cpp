#include <cansync/function_blocks/layer2/can_dmap.h>
#include <cansync/function_blocks/layer2/can_status.h>
#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "client/src/function_blocks/layer2/block_table.h"
#include "client/src/function_blocks/layer2/saia_checks.h"
#include "client/src/layer2/frame_side.h"
#include "layer2/data_mapping.h"
#include "text/counts.h"

namespace cansync::client::function_blocks {
namespace {

constexpr std::size_t kEntryBytes = 12;
/// As many [[mapped]] sections the daemon takes.
constexpr INT kMostEntries = 512;

/// The table of Saia 4.2.4. Numbers that no field has room for become ones that are out of range, too.
std::vector<layer2::MappedBytes> entries_of(const BlockTable& table, std::size_t count) {
  const auto byte = [](INT value) { return static_cast<std::uint8_t>(std::clamp<INT>(value, 0, 0x7F)); };
  std::vector<layer2::MappedBytes> entries;
  for (std::size_t i = 0; i < count; ++i) {
    const INT offset = table.word(i, 4);
    entries.push_back({.identifier = table.double_word(i, 0),
                       .offset = offset < 0 ? std::uint8_t{0x7F} : byte(offset),
                       .address = static_cast<std::uint16_t>(table.word(i, 6)),
                       .size = byte(table.word(i, 8)),
                       .output = (table.byte(i, 10) & 1) != 0});
  }
  return entries;
}

/// Status and meaning of what is wrong with an entry.
std::pair<WORD, const char*> meaning_of(layer2::MappingProblem problem) {
  using layer2::MappingProblem;
  switch (problem) {
    case MappingProblem::identifier:
      return {can_status::wrong_configuration, "MsgID is too large for IDE"};
    case MappingProblem::not_in_rule:
      return {can_status::wrong_configuration, "MsgID and Mask of the block do not take its MsgID"};
    case MappingProblem::bytes:
      return {can_status::wrong_configuration, "MsgOffset and Size must lie in 8 bytes, Size from 1 on"};
    case MappingProblem::bytes_taken:
      return {can_status::wrong_configuration, "another entry maps the same byte of the telegram"};
    case MappingProblem::address:
      return {can_status::address_taken, "VA and Size must lie in 0..1023"};
    case MappingProblem::address_taken:
      return {can_status::address_taken, "another entry fills the same byte of the image"};
    case MappingProblem::messages:
      return {can_status::no_memory, "there are more than 128 telegrams of one direction"};
    case MappingProblem::interval:
    case MappingProblem::none:
      break;
  }
  return {can_status::internal, "it cannot be"};
}

std::string sections_of(const layer2::MappingSettings& settings,
                        const std::vector<layer2::MappedBytes>& entries) {
  std::string text = fmt::format(
      "[mapping]\nidentifier = {}\nmask = {}\nextended = {}\ninterval_ms = {}\non_change = {}\n",
      settings.rule.identifier, settings.rule.mask, settings.rule.extended,
      std::chrono::duration_cast<std::chrono::milliseconds>(settings.interval).count(), settings.on_change);
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const layer2::MappedBytes& entry = entries[i];
    text += fmt::format(
        "[[mapped]]\nnumber = {}\nidentifier = {}\noffset = {}\naddress = {}\nsize = {}\noutput = {}\n", i,
        entry.identifier, entry.offset, entry.address, entry.size, entry.output);
  }
  return text;
}

}  // namespace

struct CAN_DMAP::Asked {
  UINT open = 0;
  std::string error;
};

CAN_DMAP::CAN_DMAP(FrameConnection& connection)
    : connection_(&connection), asked_(std::make_shared<Asked>()) {}
CAN_DMAP::~CAN_DMAP() = default;

UINT CAN_DMAP::open() const noexcept {
  return asked_->open;
}

const std::string& CAN_DMAP::error() const noexcept {
  return asked_->error;
}

void CAN_DMAP::call() {
  connection_->side().look();
  asked_->error.clear();
  RetVal = configure();
}

WORD CAN_DMAP::configure() {
  detail::FrameSide& side = connection_->side();
  if (PortID != 0) return refuse(can_status::wrong_port, kOnlyPort);
  if (NbEntries < 0)
    return refuse(can_status::wrong_parameter, "client: NbEntries: allowed 0..512, 0 to end it");
  if (!side.daemon_present()) return refuse(can_status::refused, "client: no daemon serves the bus");
  if (!side.begun()) return refuse(can_status::refused, "client: call CAN_CFG first");
  if (NbEntries == 0) return ask("[mapping]\n", false);
  if (DBNr < 1) return refuse(can_status::block_number, kBlockNumbers);
  const auto* block = side.data_block(DBNr);
  if (block == nullptr) return refuse(can_status::block_number, not_loaded(DBNr));
  const BlockTable table(*block, kEntryBytes);
  if (!table.known())
    return refuse(can_status::wrong_parameter, "client: DBNr: the block has another DBVersion than 0");
  if (static_cast<std::size_t>(NbEntries) > table.count())
    return refuse(can_status::wrong_parameter,
                  fmt::format("client: NbEntries {}: the table has {}", NbEntries,
                              text::counted(table.count(), "entry", "entries")));
  if (NbEntries > kMostEntries)
    return refuse(can_status::no_memory,
                  fmt::format("client: NbEntries {}: allowed 0..{}", NbEntries, kMostEntries));
  return map(table);
}

WORD CAN_DMAP::map(const BlockTable& table) {
  const auto entries = entries_of(table, static_cast<std::size_t>(NbEntries));
  const bool sends =
      std::any_of(entries.begin(), entries.end(), [](const auto& entry) { return entry.output; });
  if (sends && TxTime < 1)
    return refuse(can_status::wrong_parameter,
                  fmt::format("client: TxTime {} ms: allowed 1..32767, for there are outputs", TxTime));
  const DWORD largest = IDE ? can::kExtendedIdentifierMask : can::kStandardIdentifierMask;
  if (MsgID > largest) return refuse(can_status::wrong_parameter, wrong_identifier(MsgID, IDE));
  layer2::MappingSettings settings;
  settings.rule = {.identifier = MsgID, .mask = Mask & largest, .extended = IDE};
  settings.interval = std::chrono::milliseconds(sends ? TxTime : 10);
  settings.on_change = TxChange;
  if (const auto fault = layer2::DataMapping::check(settings, entries);
      fault.problem != layer2::MappingProblem::none) {
    const auto [code, meaning] = meaning_of(fault.problem);
    return refuse(code, fmt::format("client: entry {} of the table: {}", fault.entry, meaning));
  }
  return ask(sections_of(settings, entries), true);
}

WORD CAN_DMAP::ask(const std::string& sections, bool mapped) {
  detail::FrameSide& side = connection_->side();
  const bool begun = side.map({.toml = sections,
                               .entries = mapped,
                               .ended = [asked = asked_](const detail::FrameSide::Result& result) {
                                 --asked->open;
                                 if (!result.replied || result.code != gateway_REPLY_DONE)
                                   asked->error = "daemon: " + result.reason;
                               }});
  if (!begun) return refuse(can_status::internal, not_asked(side.full(), side.problem()));
  ++asked_->open;
  return can_status::done;
}

WORD CAN_DMAP::refuse(WORD code, std::string reason) {
  asked_->error = std::move(reason);
  return code;
}

}  // namespace cansync::client::function_blocks
