#include <cansync/function_blocks/layer2/can_cfgo.h>
#include <cansync/function_blocks/layer2/can_status.h>
#include <fmt/format.h>

#include <map>
#include <utility>

#include "client/src/function_blocks/layer2/block_table.h"
#include "client/src/function_blocks/layer2/saia_checks.h"
#include "client/src/layer2/frame_side.h"
#include "text/counts.h"

namespace cansync::client::function_blocks {
namespace {

constexpr std::size_t kEntryBytes = 16;
constexpr std::uint32_t kLongestTimeout = 3'600'000;

/// Entry `number` of the table of Saia 4.2.2, its object left out.
layer2_ObjectSettings settings_of(const BlockTable& table, std::size_t number) {
  layer2_ObjectSettings settings = {};
  const std::uint8_t bits = table.byte(number, 10);
  settings.identifier = table.double_word(number, 2);
  settings.mask = table.double_word(number, 6);
  settings.extended = (bits & 1) != 0;
  settings.transmit = (bits & 2) != 0;
  settings.tell = (bits & 4) != 0;
  settings.timeout = table.double_word(number, 12);
  return settings;
}

/// What is wrong with settings of object `number`; code 0000: nothing.
detail::JobStatus check(detail::FrameSide& side, INT number, const layer2_ObjectSettings& one) {
  if (!is_object(number)) return {.code = can_status::wrong_identifier, .reason = no_object(number)};
  if (one.identifier > (one.extended ? can::kExtendedIdentifierMask : can::kStandardIdentifierMask))
    return {.code = can_status::wrong_identifier, .reason = wrong_identifier(one.identifier, one.extended)};
  if (side.reserved(static_cast<unsigned>(number)))
    return {.code = can_status::denied,
            .reason = fmt::format(
                "client: ObjID {}: it belongs to the mapping (28, 29) or the queues (30, 31)", number)};
  if (one.timeout > kLongestTimeout)
    return {.code = can_status::wrong_parameter,
            .reason = fmt::format("client: Timeout {} ms: allowed 0..{}, 0 for none",
                                  static_cast<DINT>(one.timeout), kLongestTimeout)};
  const auto& beginning = side.beginning();
  if (one.tell && !(one.transmit ? beginning.send : beginning.receive).enabled)
    return {.code = can_status::wrong_parameter,
            .reason = fmt::format("client: EnableInt of ObjID {}: CAN_CFG was given no {}", number,
                                  one.transmit ? "TxIntOB" : "RxIntOB")};
  return {};
}

}  // namespace

struct CAN_CFGO::Asked {
  UINT open = 0;
  std::string error;
};

CAN_CFGO::CAN_CFGO(FrameConnection& connection)
    : connection_(&connection), asked_(std::make_shared<Asked>()) {}
CAN_CFGO::~CAN_CFGO() = default;

UINT CAN_CFGO::open() const noexcept {
  return asked_->open;
}

const std::string& CAN_CFGO::error() const noexcept {
  return asked_->error;
}

void CAN_CFGO::call() {
  connection_->side().look();
  asked_->error.clear();
  RetVal = configure();
}

WORD CAN_CFGO::configure() {
  detail::FrameSide& side = connection_->side();
  if (PortID != 0) return refuse(can_status::wrong_port, kOnlyPort);
  if (DBNr < 1) return refuse(can_status::block_number, kBlockNumbers);
  const auto* block = side.data_block(DBNr);
  if (block == nullptr) return refuse(can_status::block_missing, not_loaded(DBNr));
  const BlockTable table(*block, kEntryBytes);
  if (!table.known())
    return refuse(can_status::wrong_parameter, "client: DBNr: the block has another DBVersion than 0");
  if (Offset < 0 || NbObj < 1 || static_cast<std::size_t>(Offset + NbObj) > table.count())
    return refuse(can_status::wrong_parameter,
                  fmt::format("client: Offset {}, NbObj {}: the table has {}; allowed are Offset from 0 and "
                              "NbObj from 1 on within it",
                              Offset, NbObj, text::counted(table.count(), "entry", "entries")));
  if (!side.daemon_present()) return refuse(can_status::refused, "client: no daemon serves the bus");
  if (!side.begun()) return refuse(can_status::refused, "client: call CAN_CFG first");
  std::map<INT, layer2_ObjectSettings> objects;  // of two for one object the later counts
  for (INT entry = Offset; entry < Offset + NbObj; ++entry) {
    layer2_ObjectSettings one = settings_of(table, static_cast<std::size_t>(entry));
    const INT number = table.word(static_cast<std::size_t>(entry), 0);
    if (auto wrong = check(side, number, one); wrong.code != can_status::done)
      return refuse(wrong.code, std::move(wrong.reason));
    one.number = static_cast<std::uint8_t>(number);
    objects[number] = one;
  }
  std::vector<layer2_ObjectSettings> settings;
  settings.reserve(objects.size());
  for (const auto& [number, one] : objects) settings.push_back(one);
  const bool begun =
      side.objects().configure(settings, [asked = asked_](const detail::FrameSide::Result& result) {
        --asked->open;
        if (!result.replied || result.code != gateway_REPLY_DONE) asked->error = "daemon: " + result.reason;
      });
  if (!begun) return refuse(can_status::refused, not_asked(side.full(), side.problem()));
  ++asked_->open;
  return can_status::done;
}

WORD CAN_CFGO::refuse(WORD code, std::string reason) {
  asked_->error = std::move(reason);
  return code;
}

}  // namespace cansync::client::function_blocks
