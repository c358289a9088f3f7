#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "export.h"

struct cansync_ActualValues;
struct cansync_Interval;
struct cansync_MasterStatus;
struct cansync_SlaveStatus;
struct cansync_Timing;
struct gateway_BusStatus;
struct gateway_Event;
struct gateway_GatewayStatus;
struct gateway_RealtimeStatus;

/// Requests and replies as clients see them. State topics are the IDL's own structs: they are plain values
/// that can be copied (their texts: `text()`). Programs that look into them include <cansync/topics.h>.
namespace cansync::client {

using ActualValues = cansync_ActualValues;
using MasterStatus = cansync_MasterStatus;
using SlaveStatus = cansync_SlaveStatus;
using Timing = cansync_Timing;
using Interval = cansync_Interval;
using Event = gateway_Event;
using GatewayStatus = gateway_GatewayStatus;
using BusStatus = gateway_BusStatus;
using RealtimeStatus = gateway_RealtimeStatus;

/// Modes of the line, for `Client::mode`; the numbers stay.
enum class Mode : std::uint8_t {
  setup,      ///< sets the line up
  run,        ///< lets the line run
  stop,       ///< stops the line
  reset_can,  ///< leaves bus-off
  restart,    ///< starts the line anew, up to the configured state
};

/// A text of the IDL's structs, such as `SlaveStatus::name`; lives as long as the struct.
template <std::size_t N>
std::string_view text(const char (&in)[N]) noexcept {
  std::size_t length = 0;
  while (length < N && in[length] != '\0') ++length;
  return {in, length};
}

/// No daemon serves the bus; `what()` names domain, partition, interface and a remedy.
class CANSYNC_PUBLIC NoDaemon : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
  NoDaemon(const NoDaemon&) = default;
  NoDaemon& operator=(const NoDaemon&) = default;
  ~NoDaemon() override;
};

/// More than one daemon serves the bus: nothing is asked of any. `what()` names program, process and host of
/// each, and a remedy.
class CANSYNC_PUBLIC SeveralDaemons : public NoDaemon {
 public:
  using NoDaemon::NoDaemon;
  SeveralDaemons(const SeveralDaemons&) = default;
  SeveralDaemons& operator=(const SeveralDaemons&) = default;
  ~SeveralDaemons() override;
};

/// The bus is served with another protocol than this connection needs. `what()` names bus and both protocols.
class CANSYNC_PUBLIC OtherProtocol : public NoDaemon {
 public:
  /// `served_as`, `needs`: words of bus.protocol.
  OtherProtocol(const std::string& bus, const std::string& served_as, const std::string& needs);
  OtherProtocol(const OtherProtocol&) = default;
  OtherProtocol& operator=(const OtherProtocol&) = default;
  ~OtherProtocol() override;
  std::string bus;        ///< name of the bus
  std::string served_as;  ///< bus.protocol of the daemon
  std::string needs;      ///< what bus.protocol must be
};

/// DDS could not be set up, or this program's identity has no right to; `what()` names what failed, domain,
/// partition, interface and a remedy.
class CANSYNC_PUBLIC SetupError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
  SetupError(const SetupError&) = default;
  SetupError& operator=(const SetupError&) = default;
  ~SetupError() override;
};

/// Most requests of all kinds that a client may have open. One more is refused here, at once, with the
/// daemon's own words: wait for a reply first.
inline constexpr std::size_t kOpenRequests = 64;

/// How long after its monitoring time a request of the library has ended at the latest, whatever becomes of
/// its reply (`Options::grace`). When half of it is over the library cancels the request, so that it is not
/// done later: it ends as `timeout`, or as `no_reply` when nothing is heard of it. The time counts from the
/// submit; for transfers from the last sign that the daemon has them, which comes once a second while they
/// wait.
inline constexpr std::chrono::milliseconds kGrace{10000};

/// Least monitoring time of commands here; longer where they or the daemon name a longer one.
inline constexpr std::chrono::milliseconds kCommandTime{5000};

/// How a request ended. All but `no_reply` and `no_daemon` are those of the IDL (docs/dds-api.md); `retry`
/// says whether asking again helps.
enum class ReplyCode : std::uint8_t {
  done,
  refused,        ///< not accepted, nothing was sent; `reason` names field, value and allowed range
  slave_error,    ///< the slave answered with `error_code`
  timeout,        ///< no (final) answer of the slave within the monitoring time; a command: not sent
  no_answer,      ///< a write was not answered, or a control word or broadcast not seen on the bus; whether
                  ///< the slave took it is not known
  word_expected,  ///< the parameter is a word
  doubleword_expected,  ///< the parameter is a doubleword
  value_too_wide,       ///< the parameter is a word that cannot hold the value
  cancelled,
  master_stopped,
  slave_lost,  ///< the slave stopped answering; what was under way may have been taken or not
  no_reply,    ///< the daemon has gone, or gave no reply in time; whether it was done is not known
  replaced,    ///< a control word or broadcast that was not sent: a newer word, or a stop, took its place
  no_daemon,   ///< no daemon was there to be asked: nothing was sent
};

/// Why a request was refused; nothing was sent then. The numbers are those of the IDL; `retry` says whether
/// asking again helps.
enum class RefusalCause : std::uint8_t {
  none,                  ///< it was not refused
  unknown,               ///< no cause is known, as from an older daemon
  field,                 ///< a field is out of its range; `reason` names field, value and allowed range
  slave_not_configured,  ///< the slave is not one of this line's
  element_not_writable,  ///< only element 7 may be written
  value_too_wide,        ///< a word holds 0..65535
  length,                ///< of a transfer or a frame
  block_size,            ///< over the slave's limit, or no whole start addresses
  address,               ///< reserved, or the end lies over 32 bits
  action_reserved,       ///< action command 0 or 2..127
  no_slaves,             ///< empty group
  mapping,               ///< no register byte, or a word that names a value of the other telegram
  kind,                  ///< kind of request that the daemon does not know
  unknown_job,           ///< nothing is open under that number
  number_used,           ///< the number was used before; this library takes a new one for each request
  identity,              ///< the identity is another program's
  not_held,              ///< the slave is not held out: nothing to release
  profile,          ///< the drive profile forbids it: read-only, outside its limits, wider than its format
  read_only,        ///< the daemon changes neither drive nor line (access.read_only)
  right,            ///< this program lacks a right of DDS Security, or the daemon one of the system
  wrong_state,      ///< the line is not in setup or run
  slave_lost,       ///< the slave does not answer
  slave_held,       ///< the slave is held out: release it first
  slaves_missing,   ///< run needs slaves that have not reported
  bus_unavailable,  ///< the interface is missing or down, or its driver does not do it
  stopping,         ///< the daemon is about to end
  other_daemon,     ///< meant for another start of the daemon; a new request names the one that is there
  mapping_changed,  ///< reference values made for another mapping than the one in force
  stale,            ///< it was on its way for too long, or the clocks of both computers differ
  queue_full,       ///< of the line or the slave
  client_limit,     ///< open requests of this program, or their bytes
  shared_limit,     ///< clients, requests or bytes of all together, or the daemon takes none at the moment
};

/// Stable word for a cause, e.g. "slave_not_configured"; "none" when the request was not refused.
CANSYNC_PUBLIC std::string_view name(RefusalCause cause) noexcept;

/// Whether it helps to ask the same again.
enum class Retry : std::uint8_t {
  never,            ///< it was done, or will end the same way
  after_change,     ///< of the configuration, of a drive profile, or of rights
  when_state_over,  ///< when the state of line, slave or daemon is over that `reason` names
  soon,             ///< after some tens of milliseconds
  look_first,       ///< it may have been done: what only reads may be asked again, what changes something
                    ///< after a look at what the slave has
};

/// Stable word, e.g. "when_state_over".
CANSYNC_PUBLIC std::string_view name(Retry retry) noexcept;

/// Whether it helps to ask again what ended with this code and, when refused, this cause. One table; any
/// thread.
CANSYNC_PUBLIC Retry retry(ReplyCode code, RefusalCause cause) noexcept;

/// Stable word for a code, e.g. "slave_error".
CANSYNC_PUBLIC std::string_view name(ReplyCode code) noexcept;

/// Who said how a request ended.
enum class Speaker : std::uint8_t {
  nobody,  ///< there was no daemon, or it has gone
  client,  ///< this library: the request did not leave the program
  daemon,
  slave,  ///< its answer, or that there was none
};

/// Stable word for a speaker, e.g. "daemon".
CANSYNC_PUBLIC std::string_view name(Speaker speaker) noexcept;

/// Terminal reply of a request of any kind.
struct CANSYNC_PUBLIC Reply {
  ReplyCode code = ReplyCode::no_reply;
  std::string reason;                       ///< empty when done
  Speaker speaker = Speaker::nobody;        ///< whose reason it is
  RefusalCause cause = RefusalCause::none;  ///< of `refused`, and of nothing else
  /// False: `code` says what the program can do, `reason` what it can tell its user.
  bool ok() const noexcept { return code == ReplyCode::done; }
  /// Whether it helps to ask again.
  Retry retry() const noexcept { return client::retry(code, cause); }
};
using CommandReply = Reply;

/// Who refused and why, for example "daemon: slave 9: not configured; allowed 0..3"; empty when done.
CANSYNC_PUBLIC std::string describe(const Reply& reply);

/// Terminal reply of a parameter request (M 4.12, 4.14).
struct CANSYNC_PUBLIC ParameterReply : Reply {
  std::uint16_t error_code = 0;  ///< the slave's code; 0: none
  bool doubleword = false;       ///< format of the value on the bus
  std::uint32_t value = 0;       ///< raw
  std::uint32_t intervals = 0;   ///< from the first telegram to the answer
};

/// Terminal reply of an upload or download (M 4.24).
struct CANSYNC_PUBLIC TransferReply : Reply {
  std::uint16_t error_code = 0;          ///< the slave's code; 0: none
  std::uint32_t error_offset = 0;        ///< byte offset in the data where it failed
  std::uint32_t done = 0;                ///< bytes transferred and confirmed
  std::uint32_t intervals = 0;           ///< from the first telegram to the last answer
  std::uint32_t repeated_telegrams = 0;  ///< sent again after silence or a refusal
  std::uint32_t repeated_blocks = 0;     ///< begun anew after a failure
  std::vector<std::uint8_t> data;        ///< upload: what was read
};

/// Format of a parameter on the bus.
enum class ParameterFormat : std::uint8_t { word, doubleword, as_slave_says };

/// Reads or writes one parameter. Ranges are checked by the daemon, which refuses with a reason.
struct CANSYNC_PUBLIC ParameterRequest {
  bool write = false;
  std::uint32_t slave = 0;      ///< 0..31
  std::uint32_t number = 0;     ///< 0..4095
  std::uint32_t value = 0;      ///< write: raw value; a word takes 0..65535
  std::uint32_t sub_slave = 0;  ///< 0..65535; 0: the slave itself
  std::uint32_t element = 7;    ///< 0..7; 7 is the value, the only one that may be written
  ParameterFormat format = ParameterFormat::as_slave_says;
  std::uint32_t timeout_ms = 0;  ///< monitoring time; 0: the daemon's default
};

/// Uploads `length` bytes (slave to computer) or downloads `data` (computer to slave).
struct CANSYNC_PUBLIC TransferRequest {
  bool download = false;
  std::uint32_t slave = 0;              ///< 0..31
  std::uint32_t address = 0;            ///< start address; 0x00..0xFF are reserved
  std::uint32_t length = 0;             ///< upload: 1..16777216 bytes
  std::vector<std::uint8_t> data = {};  ///< download: 1..16777216 bytes
  std::uint32_t sub_slave = 0;          ///< 0..65535
  std::uint32_t block_size = 0;         ///< bytes per initialise, 1..4092; 0: the slave's limit
  std::uint32_t timeout_ms = 0;         ///< monitoring time per block; 0: the daemon's default
};

/// A group of slaves gets an action command.
struct CANSYNC_PUBLIC Broadcast {
  std::uint32_t priority = 2;    ///< 0 (before everything else), 1 or 2
  std::uint32_t slave_mask = 0;  ///< bit n: slave n
  std::uint32_t action = 0;      ///< 1 (control word in data_word) or 128..255
  std::uint32_t data_byte = 0;   ///< 0..255
  std::uint32_t data_word = 0;   ///< 0..65535
  std::uint32_t timeout_ms = 0;  ///< in which it is sent or ends as `timeout`; 0: the daemon's default
};

/// Polling codes and slave cursors besides a slave number 0..31.
inline constexpr std::int32_t kAutomatic = -128;
inline constexpr std::int32_t kNobody = -1;
inline constexpr std::int32_t kUnchanged = -2;

/// Which slave the reference value telegrams ask for actual values.
struct CANSYNC_PUBLIC Polling {
  std::int32_t one = kUnchanged;            ///< WRC1: slave 0..31 or a code
  std::int32_t two = kUnchanged;            ///< WRC2
  std::int32_t maximum_slave = kUnchanged;  ///< 0..31: automatic numbers rise up to it
};

/// Slave cursors of the command channel, one per kind of job.
struct CANSYNC_PUBLIC Cursors {
  std::int32_t control_word = kUnchanged;  ///< words that enable: slave 0..31 or a code
  std::int32_t parameter = kUnchanged;     ///< likewise
  std::int32_t transfer = kUnchanged;      ///< likewise, uploads and downloads
};

/// Register bytes of the words 0..3 of telegram 1, then of telegram 2 (M 3.1.1.1; 0x0D: low word of value 3).
using MappingBytes = std::array<std::uint8_t, 8>;

/// What settings made by clients, and reference values, hold for: one start of the daemon, and one mapping of
/// the reference values. All zero: the daemon is older than this.
struct Validity {
  std::array<std::uint8_t, 16> daemon = {};  ///< as MasterStatus.daemon: random, another one after each start
  std::uint64_t mapping_number = 0;          ///< 1 after the start, rises with each change
  friend bool operator==(const Validity&, const Validity&) = default;
};

/// Whether the values of a writer are still taken.
enum class ReferenceStanding : std::uint8_t {
  current,           ///< they are meant for the daemon and the mapping in force
  daemon_restarted,  ///< the daemon was started anew: settings that clients have made are lost
  mapping_changed,   ///< the mapping of the reference values was changed
};

}  // namespace cansync::client
