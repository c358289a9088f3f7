#include "cansync/dds/validate.h"

#include <fmt/format.h>

#include <algorithm>

#include "cansync/dds/ranges.h"
#include "dds/enumerator.h"
#include "text/counts.h"

namespace cansync::dds {
namespace {

using gateway::dds::Denial;

constexpr std::uint32_t kLongestBlock = 4092;  // a multiple of 6 and 4 below 4096
constexpr std::uint32_t kReservedAddresses = 0x100;

Problem check_value(const cansync_ParameterRequest& request) {
  if (!request.write) return std::nullopt;
  if (request.element != kValueElement.value()) {
    return Denial{
        gateway_CAUSE_ELEMENT_NOT_WRITABLE,
        fmt::format("element {}: cannot be written; allowed 7 (the value), the others can only be read",
                    request.element)};
  }
  if (request.format == cansync_FORMAT_WORD && request.value > 0xFFFF) {
    return Denial{
        gateway_CAUSE_VALUE_TOO_WIDE,
        fmt::format("value {}: too wide for a word; allowed 0..65535, or format doubleword", request.value)};
  }
  return std::nullopt;
}

Problem check_length(const cansync_TransferRequest& request) {
  const bool download = request.direction == cansync_DIRECTION_DOWNLOAD;
  if (request.length == 0 || request.length > cansync_MAXIMUM_TRANSFER) {
    return Denial{gateway_CAUSE_LENGTH, fmt::format("length {}: out of range; allowed 1..{} bytes",
                                                    request.length, cansync_MAXIMUM_TRANSFER)};
  }
  if (download && request.data._length != request.length) {
    return Denial{gateway_CAUSE_LENGTH,
                  fmt::format("length {}: does not fit the data; allowed {}, the bytes of data",
                              request.length, request.data._length)};
  }
  if (!download && request.data._length != 0) {
    return Denial{gateway_CAUSE_LENGTH, fmt::format("data of {}: not with an upload; allowed 0 bytes",
                                                    text::counted(request.data._length, "byte"))};
  }
  return std::nullopt;
}

Problem check_address(const cansync_TransferRequest& request, const Limits& limits) {
  if (request.address < kReservedAddresses && !limits.allow_reserved_addresses) {
    return Denial{
        gateway_CAUSE_ADDRESS,
        fmt::format(
            "address 0x{:X}: 0x00..0xFF belong to the slave's operating system; allowed 0x100..0xFFFFFFFF, or "
            "set allow_reserved_addresses",
            request.address)};
  }
  const std::uint64_t last = request.address + (std::uint64_t{request.length} - 1) / limits.address_step;
  if (last > 0xFFFFFFFFu) {
    return Denial{
        gateway_CAUSE_ADDRESS,
        fmt::format("address 0x{:X}: with length {} the end lies at 0x{:X}; allowed up to 0xFFFFFFFF",
                    request.address, request.length, last)};
  }
  return std::nullopt;
}

Problem check_block_size(const cansync_TransferRequest& request, const Limits& limits) {
  if (request.block_size == 0) return std::nullopt;
  const std::uint32_t most = std::min<std::uint32_t>(limits.block_limit[request.slave], kLongestBlock);
  if (request.block_size > most) {
    return Denial{gateway_CAUSE_BLOCK_SIZE,
                  fmt::format("block_size {}: over the limit of slave {}; allowed 1..{}, 0 = {}",
                              request.block_size, request.slave, most, most)};
  }
  if (request.block_size % limits.address_step != 0) {
    return Denial{
        gateway_CAUSE_BLOCK_SIZE,
        fmt::format("block_size {}: no whole start addresses; allowed multiples of {} up to {}, 0 = {}",
                    request.block_size, limits.address_step, most, most)};
  }
  return std::nullopt;
}

}  // namespace

Limits limits_of(const MasterSettings& settings) noexcept {
  Limits limits;
  limits.configured = settings.configured();
  for (unsigned slave = 0; slave < kSlaves; ++slave)
    limits.block_limit[slave] = settings.slaves[slave].block_limit;
  limits.allow_reserved_addresses = settings.command_channel.allow_reserved_addresses;
  limits.address_step = settings.command_channel.address_step;
  limits.release_limit = settings.process.release_limit;
  limits.ahead_limit = settings.process.ahead_limit;
  limits.parameter_queue = settings.command_channel.parameter_queue;
  limits.transfer_queue = settings.command_channel.transfer_queue;
  return limits;
}

Problem check(const cansync_ParameterRequest& request, const Limits& limits) {
  if (Problem problem = configured_slave("slave", request.slave, limits)) return problem;
  if (Problem problem = in_range("sub_slave", request.sub_slave, 0, 0xFFFF)) return problem;
  if (Problem problem = in_range("number", request.number, 0, ParameterNumber::max)) return problem;
  if (Problem problem = in_range("element", request.element, 0, Element::max)) return problem;
  if (Problem problem = in_range("format", gateway::dds::raw_number_of(request.format), 0,
                                 static_cast<std::int64_t>(cansync_FORMAT_AS_SLAVE_SAYS))) {
    return problem;
  }
  if (Problem problem = timeout_in_range(request.timeout)) return problem;
  return check_value(request);
}

Problem check(const cansync_TransferRequest& request, const Limits& limits) {
  if (Problem problem = configured_slave("slave", request.slave, limits)) return problem;
  if (Problem problem = in_range("sub_slave", request.sub_slave, 0, 0xFFFF)) return problem;
  if (Problem problem = in_range("direction", gateway::dds::raw_number_of(request.direction), 0,
                                 static_cast<std::int64_t>(cansync_DIRECTION_DOWNLOAD))) {
    return problem;
  }
  if (Problem problem = check_length(request)) return problem;
  if (Problem problem = check_address(request, limits)) return problem;
  if (Problem problem = check_block_size(request, limits)) return problem;
  return timeout_in_range(request.timeout);
}

Problem check(const cansync_ReferenceValues& values, const Limits& limits) {
  if (Problem problem = in_range("telegram", values.telegram, 1, 2)) return problem;
  if (values.valid == 0 || values.valid > 15) {
    return Denial{
        gateway_CAUSE_FIELD,
        fmt::format("valid {}: out of range; allowed 1..15, bit n = value[n] is new", values.valid)};
  }
  return in_range("release_intervals", values.release_intervals, 0, limits.release_limit);
}

gateway_RefusalCause to_cause(Refusal refusal) noexcept {
  switch (refusal) {
    case Refusal::none:
      break;
    case Refusal::slave_not_configured:
      return gateway_CAUSE_SLAVE_NOT_CONFIGURED;
    case Refusal::element_not_writable:
      return gateway_CAUSE_ELEMENT_NOT_WRITABLE;
    case Refusal::value_too_wide:
      return gateway_CAUSE_VALUE_TOO_WIDE;
    case Refusal::length_zero:
      return gateway_CAUSE_LENGTH;
    case Refusal::block_size:
      return gateway_CAUSE_BLOCK_SIZE;
    case Refusal::address_reserved:
    case Refusal::address_overflow:
      return gateway_CAUSE_ADDRESS;
    case Refusal::command_reserved:
      return gateway_CAUSE_ACTION_RESERVED;
    case Refusal::no_slaves:
      return gateway_CAUSE_NO_SLAVES;
    case Refusal::priority:
    case Refusal::interval_passed:
    case Refusal::release_too_long:
    case Refusal::nothing_valid:
    case Refusal::beyond_limit:
      return gateway_CAUSE_FIELD;
    case Refusal::queue_full:
      return gateway_CAUSE_QUEUE_FULL;
    case Refusal::wrong_state:
    case Refusal::listening:
    case Refusal::other_master:
      return gateway_CAUSE_WRONG_STATE;
    case Refusal::slaves_missing:
      return gateway_CAUSE_SLAVES_MISSING;
    case Refusal::unknown_job:
      return gateway_CAUSE_UNKNOWN_JOB;
    case Refusal::mapping:
      return gateway_CAUSE_MAPPING;
    case Refusal::not_permitted:
      return gateway_CAUSE_RIGHT;
    case Refusal::bus_unavailable:
      return gateway_CAUSE_BUS_UNAVAILABLE;
    case Refusal::slave_lost:
      return gateway_CAUSE_SLAVE_LOST;
    case Refusal::slave_held:
      return gateway_CAUSE_SLAVE_HELD;
    case Refusal::not_held:
      return gateway_CAUSE_NOT_HELD;
    case Refusal::too_old:
      return gateway_CAUSE_STALE;
    case Refusal::mapping_changed:
      return gateway_CAUSE_MAPPING_CHANGED;
    case Refusal::lead_axis:
      return gateway_CAUSE_RIGHT;
  }
  return gateway_CAUSE_NONE;
}

std::string explain(Refusal refusal, const Limits& limits) {
  switch (refusal) {
    case Refusal::queue_full:
      return fmt::format("queue full: at most {} and {} may be open; try again when one has ended",
                         text::counted(limits.parameter_queue, "parameter job"),
                         text::counted(limits.transfer_queue, "transfer"));
    case Refusal::wrong_state:
      return "state: not allowed in the master's state; allowed in setup and run, see mode";
    case Refusal::listening:
      return "state: the master still listens whether another one sends; wait, or use force";
    case Refusal::other_master:
      return "state: another master sends on this bus; switch it off and wait 3 s, or use force";
    case Refusal::slaves_missing:
      return "slaves: not every configured slave is ready; wait for them, or use force";
    case Refusal::unknown_job:
      return "request: no such job is open; it has ended already, or was never taken";
    case Refusal::interval_passed:
      return fmt::format(
          "from_interval: passed, or too far ahead; allowed up to {} intervals ahead, 0 = the next",
          limits.ahead_limit);
    case Refusal::value_too_wide:
      return "value: too wide; a word takes 0..65535, a reference value sent as its low word alone "
             "-32768..65535";
    case Refusal::slave_not_configured:
      return fmt::format("slave: not configured; allowed {}", list_of(limits.configured));
    default:
      return std::string(name(refusal));
  }
}

}  // namespace cansync::dds
