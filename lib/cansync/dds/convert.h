#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "cansync.h"
#include "cansync/channel/jobs.h"
#include "cansync/dds/topics.h"
#include "cansync/master.h"
#include "cansync/settings/settings.h"
#include "cansync/telegram/mapping.h"
#include "dds/bounded_text.h"
#include "dds/denial.h"
#include "dds/request_key.h"

/// Between the structs of the IDL and those of the core, in one file. Requests must have passed `check`
/// (validate.h); a field out of range is cut to its type and never read out of bounds. No function allocates
/// or throws.
namespace cansync::dds {

// --- requests of clients -> core ---

ParameterRequest to_core(const cansync_ParameterRequest& request, JobId id) noexcept;
/// `data` is the daemon's buffer for the transfer, as long as the request says.
TransferRequest to_core(const cansync_TransferRequest& request, JobId id,
                        std::span<std::uint8_t> data) noexcept;
/// For COMMAND_CONTROL_WORD.
ControlWordRequest to_control_word(const cansync_Command& command, JobId id) noexcept;
/// For COMMAND_BROADCAST.
BroadcastRequest to_broadcast(const cansync_Command& command, JobId id) noexcept;
ReferenceUpdate to_core(const cansync_ReferenceValues& values) noexcept;

/// A polling code or cursor of Command: 0..31 a slave, -128 automatic, -1 nobody; nothing for -2 (unchanged)
/// and every other number.
std::optional<Cursor> to_cursor(std::int32_t code) noexcept;
std::int32_t to_code(const Cursor& cursor) noexcept;

/// Eight register bytes; nothing when one is no register byte.
std::optional<ProcessMapping> to_mapping(const std::uint8_t (&bytes)[8]) noexcept;
void to_registers(const ProcessMapping& mapping, std::uint8_t (&bytes)[8]) noexcept;

// --- core -> replies ---

gateway_ReplyCode to_reply_code(Outcome outcome) noexcept;
/// The cause that goes with REPLY_REFUSED; none with every other code.
gateway_RefusalCause to_cause(Outcome outcome) noexcept;

/// Terminal replies of jobs; `reason` is filled by what the outcome and the slave's error code mean. The
/// transfer reply borrows `data` (uploads): it must live until the reply was written, and is never freed by
/// the reply.
cansync_ParameterReply parameter_reply(const RequestKey& key, const ParameterResult& result) noexcept;
cansync_TransferReply transfer_reply(const RequestKey& key, const TransferResult& result,
                                     std::span<std::uint8_t> data) noexcept;
cansync_CommandReply command_reply(const RequestKey& key, Outcome outcome) noexcept;

/// Refusals: nothing was sent.
cansync_ParameterReply parameter_refused(const RequestKey& key, const gateway::dds::Denial& denial) noexcept;
cansync_TransferReply transfer_refused(const RequestKey& key, const gateway::dds::Denial& denial) noexcept;
cansync_CommandReply command_refused(const RequestKey& key, const gateway::dds::Denial& denial) noexcept;

cansync_TransferProgress transfer_progress(const RequestKey& key, std::uint32_t done,
                                           std::uint32_t total) noexcept;

// --- core -> state ---

/// `names` gives factor and offset of each value; `now` is the running interval; `receive_time` is
/// CLOCK_REALTIME (ns) of the newest telegram.
cansync_ActualValues actual_values(SlaveNumber slave, std::string_view name, const ActualValues& values,
                                   const std::array<cansync_ValueName, kValues>& names, IntervalNumber now,
                                   std::int64_t receive_time) noexcept;

cansync_SlaveStatus slave_status(SlaveNumber slave, std::string_view name, const SlaveStatus& status,
                                 const ProcessMapping& mapping,
                                 const std::array<cansync_ValueName, kValues>& names) noexcept;

/// Fills what counters and settings tell of the master; the other fields of `out` stay as they are.
void fill_master_status(const MasterSettings& settings, const MasterCounters& counters, State state,
                        cansync_MasterStatus& out) noexcept;

}  // namespace cansync::dds
