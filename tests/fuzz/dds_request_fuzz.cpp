// Requests as they come out of DDS: the checks of lib/dds, what is made of the requests that pass, and
// whether the master takes that. Enums hold any number here, as a client could send it; the allowed ranges
// stand here once more, as idl/cansync.idl has them.
#include <cstring>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "bytes.h"
#include "cansync/dds/convert.h"
#include "cansync/dds/validate.h"
#include "cansync/settings/settings_check.h"
#include "daemon/cansync/requests/gateway_requests.h"
#include "master_model.h"
#include "require.h"

namespace {

using namespace cansync;
using fuzz::Bytes;
using fuzz::JobLedger;
using fuzz::require;
using Fields = std::initializer_list<std::string_view>;

constexpr std::uint32_t kHour = 3'600'000;  // ms

/// Any bits in an enum or a number of the IDL. Few numbers are small by chance, and most limits are.
template <class T>
void fill(Bytes& in, T& out) {
  static_assert(sizeof(T) <= sizeof(std::uint64_t));
  const std::uint8_t how = in.byte();
  std::uint64_t bits = how >> 3;
  if ((how & 3) == 0) bits = in.number<std::uint64_t>();
  if ((how & 3) == 1) bits = in.byte();
  if ((how & 3) == 2) bits = in.number<std::uint16_t>();
  if ((how & 4) != 0) bits = 0 - bits;
  std::memcpy(&out, &bits, sizeof(T));
}

template <class Request>
void fill_head(Bytes& in, Request& out) {
  for (std::uint8_t& byte : out.client) byte = in.byte();
  fill(in, out.request);
  const auto name = in.take(in.below(sizeof(out.client_name)));  // DDS ends every string with a zero
  if (!name.empty()) std::memcpy(out.client_name, name.data(), name.size());
}

/// True when the request passed; a refusal begins with the field that is wrong, and fits its place in a
/// reply.
bool passed(const gateway::dds::Problem& problem, Fields fields) {
  if (!problem) return true;
  const std::string& reason = problem->reason;
  require(problem->cause > gateway_CAUSE_UNKNOWN, "a cause is told");
  require(!reason.empty() && reason.size() <= gateway_TEXT, "a reason is told, and fits its field");
  for (const std::string_view field : fields) {
    if (reason.starts_with(field) && reason.size() > field.size() &&
        reason[field.size()] == (field == "mapping" ? '[' : ' '))
      return false;
  }
  require(false, "a reason names a field of the request");
  return false;
}

MasterSettings settings(Bytes& in) {
  MasterSettings out;
  const auto configured = in.number<std::uint32_t>();
  for (unsigned i = 0; i < kSlaves; ++i) out.slaves[i].configured = ((configured >> i) & 1u) != 0;
  out.slaves[0].configured = true;
  out.slaves[0].block_limit = static_cast<std::uint16_t>(8 + in.below(1022) * 4);
  out.process.maximum_slave = *SlaveNumber::from(31);
  out.command_channel.address_step = in.flag() ? 4 : 1;
  out.command_channel.allow_reserved_addresses = in.flag();
  return out;
}

class Run {
 public:
  explicit Run(Bytes& in)
      : in_(in), settings_(settings(in)), limits_(dds::limits_of(settings_)), master_(settings_, ledger_) {
    require(cansync::check(settings_).empty(), "the settings are good");
    for (const auto step : {ControlCommand::handshake, ControlCommand::take_over_initialisation,
                            ControlCommand::start_synchronous, ControlCommand::enable_active})
      static_cast<void>(master_.control(step, true));
  }

  void go() {
    for (unsigned n = 0; n < 8 && !in_.empty(); ++n) {
      switch (in_.below(5)) {
        case 0:
          parameter();
          break;
        case 1:
          transfer();
          break;
        case 2:
          references();
          break;
        default:
          command();
          break;
      }
      require(ledger_.open(JobLedger::Kind::parameter) + ledger_.open(JobLedger::Kind::transfer) +
                      ledger_.open(JobLedger::Kind::command) ==
                  0,
              "what was cancelled has ended");
    }
  }

 private:
  bool is_configured(std::uint32_t slave) const {
    return slave < kSlaves && settings_.slaves[slave].configured;
  }

  /// The master takes what passed, and ends it when asked to.
  template <class Request>
  void submit(const Request& request, JobLedger::Kind kind) {
    require(master_.submit(request) == Refusal::none, "the master takes what passes");
    ledger_.accepted(request.id, kind);
    require(master_.cancel(request.id) == Refusal::none, "it is open");
  }

  void parameter() {
    cansync_ParameterRequest request = {};
    fill_head(in_, request);
    request.write = in_.flag();
    fill(in_, request.slave);
    fill(in_, request.sub_slave);
    fill(in_, request.number);
    fill(in_, request.element);
    if (in_.flag()) request.element = 7;
    fill(in_, request.format);
    fill(in_, request.value);
    fill(in_, request.timeout);
    if (!passed(dds::check(request, limits_),
                {"slave", "sub_slave", "number", "element", "format", "value", "timeout"}))
      return;
    require(is_configured(request.slave) && request.sub_slave <= 0xFFFF && request.number <= 4095 &&
                request.element <= 7 && request.timeout <= kHour &&
                static_cast<unsigned>(request.format) <= cansync_FORMAT_AS_SLAVE_SAYS,
            "what passes is in range");
    require(!request.write ||
                (request.element == 7 && (request.format != cansync_FORMAT_WORD || request.value <= 0xFFFF)),
            "what is written can be written");
    const ParameterRequest core = dds::to_core(request, ++id_);
    require(core.slave.value() == request.slave && core.number.value() == request.number &&
                core.element.value() == request.element && core.sub_slave.value == request.sub_slave &&
                core.value == request.value && core.write == request.write &&
                core.monitoring_time == std::chrono::milliseconds(request.timeout),
            "what passes is converted without loss");
    submit(core, JobLedger::Kind::parameter);
  }

  void transfer() {
    cansync_TransferRequest request = {};
    fill_head(in_, request);
    fill(in_, request.direction);
    fill(in_, request.slave);
    fill(in_, request.sub_slave);
    fill(in_, request.address);
    fill(in_, request.length);
    fill(in_, request.block_size);
    fill(in_, request.timeout);
    std::vector<std::uint8_t> data(in_.below(512));
    if (in_.flag()) request.length = static_cast<std::uint32_t>(data.size());
    request.data._buffer = data.empty() ? nullptr : data.data();
    request.data._length = request.data._maximum = static_cast<std::uint32_t>(data.size());
    if (!passed(dds::check(request, limits_),
                {"slave", "sub_slave", "direction", "length", "data", "address", "block_size", "timeout"}))
      return;
    const bool download = request.direction == cansync_DIRECTION_DOWNLOAD;
    require(download || request.direction == cansync_DIRECTION_UPLOAD, "what passes has a direction");
    require(is_configured(request.slave) && request.sub_slave <= 0xFFFF && request.length >= 1 &&
                request.length <= cansync_MAXIMUM_TRANSFER && request.block_size <= 4092 &&
                request.timeout <= kHour,
            "what passes is in range");
    require(request.data._length == (download ? request.length : 0),
            "a download has its data, an upload none");
    require(request.address >= 0x100 || settings_.command_channel.allow_reserved_addresses,
            "reserved addresses are asked for by leave alone");
    const TransferRequest core = dds::to_core(request, ++id_, data);
    require(core.slave.value() == request.slave && core.address == request.address &&
                core.block_size == request.block_size && core.sub_slave.value == request.sub_slave &&
                (core.direction == TransferRequest::Direction::download) == download,
            "what passes is converted without loss");
    if (request.length > 4096) return;
    std::vector<std::uint8_t> buffer(request.length);
    submit(dds::to_core(request, ++id_, buffer), JobLedger::Kind::transfer);
  }

  void command() {
    cansync_Command request = {};
    fill_head(in_, request);
    fill(in_, request.kind);
    if (in_.flag()) request.kind = static_cast<cansync_CommandKind>(in_.below(8));
    fill(in_, request.slave);
    fill(in_, request.control_word);
    fill(in_, request.priority);
    fill(in_, request.slave_mask);
    if (in_.flag()) request.slave_mask = limits_.configured.bits;
    fill(in_, request.action);
    fill(in_, request.data_byte);
    fill(in_, request.data_word);
    fill(in_, request.mode);
    request.force = in_.flag();
    for (std::int32_t* code :
         {&request.polling_one, &request.polling_two, &request.maximum_slave, &request.cursor_control_word,
          &request.cursor_parameter, &request.cursor_transfer})
      fill(in_, *code);
    for (std::uint8_t& byte : request.mapping) byte = in_.byte();
    check_codes(request);
    if (!passed(dds::check(request, limits_),
                {"kind", "slave", "control_word", "priority", "slave_mask", "action", "data_byte",
                 "data_word", "mode", "polling_one", "polling_two", "maximum_slave", "cursor_control_word",
                 "cursor_parameter", "cursor_transfer", "mapping"}))
      return;
    const auto core = cansyncd::to_request(request, ++id_);
    require(core.has_value(), "what passes is a request to the master");
    const auto words = cansyncd::describe(*core, config_);
    require(words && !words->empty(), "each command can be put into words");
    std::visit([&](const auto& made) { take(request, made); }, *core);
  }

  /// Codes of slaves and of mappings go there and back, also those that do not pass.
  static void check_codes(const cansync_Command& request) {
    for (const std::int32_t code : {request.polling_one, request.cursor_transfer})
      if (const auto cursor = dds::to_cursor(code)) require(dds::to_code(*cursor) == code, "there and back");
    if (const auto mapping = dds::to_mapping(request.mapping)) {
      std::uint8_t bytes[8] = {};
      dds::to_registers(*mapping, bytes);
      require(std::memcmp(bytes, request.mapping, sizeof bytes) == 0, "there and back");
    }
  }

  void take(const cansync_Command& request, const ControlWordRequest& core) {
    require(request.kind == cansync_COMMAND_CONTROL_WORD && is_configured(request.slave), "its kind");
    require(core.slave.value() == request.slave && core.control_word == request.control_word, "without loss");
    submit(core, JobLedger::Kind::command);
  }
  void take(const cansync_Command& request, const BroadcastRequest& core) {
    require(request.kind == cansync_COMMAND_BROADCAST, "its kind");
    require(core.priority == request.priority && core.priority <= 2 &&
                core.action.slaves.bits == request.slave_mask && core.action.command == request.action &&
                core.action.data_byte == request.data_byte && core.action.data_word == request.data_word,
            "without loss");
    require(core.action.command == 1 || core.action.command >= 128, "no reserved command");
    const SlaveMask slaves = core.action.slaves;  // all: also those that nobody has configured
    require(!slaves.empty() &&
                (slaves.bits == SlaveMask::all().bits || (slaves.bits & ~limits_.configured.bits) == 0),
            "for configured slaves, or for all");
    submit(core, JobLedger::Kind::command);
  }
  void take(const cansync_Command& request, const cansyncd::ModeRequest& core) {
    require(request.kind == cansync_COMMAND_MODE && core.force == request.force, "its kind");
    require(static_cast<unsigned>(request.mode) <= cansync_MODE_RESTART, "a mode that there is");
  }
  void take(const cansync_Command& request, const cansyncd::SetPolling& core) {
    require(request.kind == cansync_COMMAND_POLLING, "its kind");
    check(core.polling[0], request.polling_one);
    check(core.polling[1], request.polling_two);
    require(core.maximum_slave.has_value() == (request.maximum_slave != -2), "what is unchanged stays");
    for (const Channel channel : {Channel::one, Channel::two})
      if (const auto& cursor = core.polling[index(channel)])
        require(master_.set_polling(channel, *cursor) == Refusal::none, "the master takes what passes");
    if (core.maximum_slave) master_.set_maximum_slave(*core.maximum_slave);
  }
  void take(const cansync_Command& request, const cansyncd::SetCursors& core) {
    require(request.kind == cansync_COMMAND_CHANNEL_CURSORS, "its kind");
    check(core.control_word, request.cursor_control_word);
    check(core.parameter, request.cursor_parameter);
    check(core.transfer, request.cursor_transfer);
    const Cursor none;
    require(master_.set_command_cursors(core.control_word.value_or(none), core.parameter.value_or(none),
                                        core.transfer.value_or(none)) == Refusal::none,
            "the master takes what passes");
  }
  void take(const cansync_Command& request, const cansyncd::SetReferenceMapping& core) {
    require(request.kind == cansync_COMMAND_REFERENCE_MAPPING, "its kind");
    require(master_.set_reference_mapping(core.mapping) == Refusal::none, "the master takes what passes");
  }
  void take(const cansync_Command& request, const cansyncd::SetActualMapping& core) {
    require(request.kind == cansync_COMMAND_ACTUAL_MAPPING && core.slave.value() == request.slave,
            "its kind");
    require(master_.set_actual_mapping(core.slave, core.mapping) == Refusal::none,
            "the master takes what passes");
  }
  void take(const cansync_Command& request, const cansyncd::ReleaseSlave& core) {
    require(request.kind == cansync_COMMAND_RELEASE && core.slave.value() == request.slave &&
                is_configured(request.slave) && core.force == request.force,
            "its kind");
    static_cast<void>(master_.release(core.slave, core.force));  // there may be nothing to release
  }
  template <class Other>
  void take(const cansync_Command&, const Other&) {
    require(false, "no command is anything else");
  }

  void check(const std::optional<Cursor>& cursor, std::int32_t code) const {
    require(cursor.has_value() == (code != -2), "what is unchanged stays");
    if (!cursor) return;
    require(dds::to_code(*cursor) == code, "without loss");
    require(code == -128 || code == -1 || is_configured(static_cast<std::uint32_t>(code)),
            "a configured slave, automatic or nobody");
  }

  void references() {
    cansync_ReferenceValues values = {};
    values.telegram = in_.byte() & 3;
    for (std::int32_t& value : values.value) value = in_.number<std::int32_t>();
    values.valid = in_.byte();
    fill(in_, values.from_interval);
    fill(in_, values.release_intervals);
    values.mapping_number = master_.mapping_number();
    const ReferenceUpdate core = dds::to_core(values);
    if (!passed(dds::check(values, limits_), {"telegram", "valid", "release_intervals"})) return;
    require(values.telegram >= 1 && values.telegram <= 2 && values.valid >= 1 && values.valid <= 15 &&
                values.release_intervals <= limits_.release_limit,
            "what passes is in range");
    require(index(core.channel) + 1u == values.telegram && core.valid_mask == values.valid, "without loss");
    const Refusal refusal = master_.submit(core);
    require(
        refusal == Refusal::none || refusal == Refusal::interval_passed || refusal == Refusal::value_too_wide,
        "only its interval, or a value for its word may be wrong");
    if (refusal != Refusal::none)
      static_cast<void>(passed(gateway::dds::Denial{dds::to_cause(refusal), dds::explain(refusal, limits_)},
                               {"from_interval:", "value:"}));
  }

  Bytes& in_;
  MasterSettings settings_;
  dds::Limits limits_;
  JobLedger ledger_;
  Master master_;
  cansyncd::Config config_;
  JobId id_ = 0;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Bytes in(data, size);
  Run(in).go();
  return 0;
}
