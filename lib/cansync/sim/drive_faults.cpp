#include "cansync/sim/drive_faults.h"

#include <array>
#include <variant>

#include "cansync/telegram/reply_payload.h"
#include "cansync/telegram/telegram.h"

namespace sim {
namespace {

namespace identifier = cansync::identifier;

constexpr std::array<ChannelName, 7> kChannelNames = {{
    {"action", identifier::action, identifier::channel_bits | identifier::number_bits},
    {"wrc1", identifier::reference_one, identifier::channel_bits},
    {"wrc2", identifier::reference_two, identifier::channel_bits},
    {"rdc1", identifier::actual_one, identifier::channel_bits},
    {"rdc2", identifier::actual_two, identifier::channel_bits},
    {"command", identifier::command, identifier::channel_bits},
    {"response", identifier::response, identifier::channel_bits},
}};

class DriveFaults final : public FaultProtocol {
 public:
  std::string_view node_word() const noexcept override { return "slave"; }
  std::span<const ChannelName> channels() const noexcept override { return kChannelNames; }

  /// The slave number in an identifier of one of the channels that carry one.
  std::optional<NodeNumber> node_of(const can::Frame& frame) const noexcept override {
    if (!frame.is_standard_data()) return std::nullopt;
    switch (identifier::channel_of(frame.id)) {
      case identifier::reference_one:
      case identifier::reference_two:
      case identifier::actual_one:
      case identifier::actual_two:
      case identifier::command:
      case identifier::response:
        return static_cast<NodeNumber>(identifier::participant_of(frame.id));
      default:
        return std::nullopt;
    }
  }

  bool is_answer(const can::Frame& frame) const noexcept override {
    return frame.is_standard_data() && identifier::channel_of(frame.id) == identifier::response;
  }

  /// The next parameter, or the next block.
  void make_wrong(can::Frame& answer) const noexcept override {
    auto decoded = cansync::decode(answer);
    auto* telegram = std::get_if<cansync::Telegram>(&decoded);
    if (telegram == nullptr) return;
    if (auto* parameter = std::get_if<cansync::ParameterReply>(telegram)) {
      parameter->number = *cansync::ParameterNumber::from((parameter->number.value() + 1u) % 4096u);
    } else if (auto* transfer = std::get_if<cansync::TransferReply>(telegram)) {
      transfer->offset =
          *cansync::BlockOffset::from((transfer->offset.value() + cansync::kTransferBytes) % 4096u);
    }
    answer = cansync::encode(*telegram);
  }

  void make_busy(can::Frame& answer) const noexcept override {
    auto decoded = cansync::decode(answer);
    auto* telegram = std::get_if<cansync::Telegram>(&decoded);
    if (telegram == nullptr) return;
    if (auto* parameter = std::get_if<cansync::ParameterReply>(telegram)) put_busy(*parameter);
    if (auto* transfer = std::get_if<cansync::TransferReply>(telegram)) put_busy(*transfer);
    answer = cansync::encode(*telegram);
  }
};

}  // namespace

const FaultProtocol& drive_faults() noexcept {
  static const DriveFaults faults;
  return faults;
}

}  // namespace sim
