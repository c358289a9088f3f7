#pragma once

#include <cstdint>
#include <span>

#include "cansync/telegram/mapping.h"
#include "cansync/telegram/numbers.h"
#include "cansync_slave.h"
#include "cansync_slave/received_values.h"
#include "dds/denial.h"
#include "dds/request_key.h"

/// Between the structs of the IDL and those of the core. No function allocates or throws; any thread.
namespace cansync_slave::dds {

/// `lost`: telegrams since the start that are in no sample.
cansync_slave_ReferencesReceived references_received(const ReceivedValues& received,
                                                     std::uint64_t lost) noexcept;
/// Of the slave that sent them, whose telegrams `mapping` makes values of.
cansync_slave_MonitoredValues monitored_values(cansync::SlaveNumber slave, const ReceivedValues& received,
                                               const cansync::ProcessMapping& mapping) noexcept;
/// The mapping of register bytes that `check` has found right.
cansync::ProcessMapping mapping_of(std::span<const std::uint8_t, 8> bytes) noexcept;
/// The reply to a command that ended so; `code` is not REPLY_REFUSED.
cansync_slave_SlaveCommandReply command_reply(const gateway::dds::RequestKey& key, gateway_ReplyCode code,
                                              const char* reason) noexcept;
/// The reply to one that was not taken.
cansync_slave_SlaveCommandReply command_refused(const gateway::dds::RequestKey& key,
                                                const gateway::dds::Denial& denial) noexcept;
/// The register bytes of words 0..3 of telegram 1, then of telegram 2.
void put_registers(const cansync::ProcessMapping& mapping, std::uint8_t (&bytes)[8]) noexcept;

}  // namespace cansync_slave::dds
