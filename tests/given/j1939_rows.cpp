// What may be given to a bus of J1939.
#include <array>
#include <cstdint>
#include <string>

#include "daemon/j1939/segment/j1939_segment.h"
#include "j1939.h"
#include "j1939/dds/topics.h"
#include "row_on.h"
#include "rows.h"

namespace given {
namespace {

using std::chrono::milliseconds;

const std::string kBus = R"([bus]
interface = "sim"
protocol = "j1939"
bit_rate = 250000
[dds]
request_max_age_ms = 0
[recorder]
folder = ""
[address]
preferred = 128
[name]
identity = 1234
[[ecu]]
number = 0
address = 33
identity = 1
pgn = 0xFEEB
data = [1, 2, 3, 4]
)";
constexpr std::uint8_t kEcu = 33;
const std::string kProvided = R"([[provide]]
number = 0
pgn = 0xFF20
data = [1]
period_ms = 20
)";

class J1939Row : public RowOn {
 public:
  bool is_job() const override { return true; }
  void end(Giver giver) override { program(giver).cancel(newest_); }
  void collect() override { collect_answers<j1939_MessageReply>(); }
  void restart() override {
    RowOn::restart();
    claim();
  }

 protected:
  explicit J1939Row(const std::string& file = {}, const std::string& changed = {})
      : RowOn({make_daemon<DeadlineDaemon<cansyncd::J1939Parts>>, kBus}, file, changed) {
    claim();
  }

  void ask(Giver giver, j1939_MessageRequest request) {
    request.priority = 6;
    request.timeout = 2000;
    const std::uint64_t number = program(giver).ask<j1939_MessageReply>(request);
    if (giver == Giver::first) newest_ = number;
  }
  /// A message whose first byte says whose it is.
  void send(Giver giver, std::uint32_t pgn, std::uint32_t size) {
    std::array<std::uint8_t, 64> bytes = {};
    bytes[0] = giver == Giver::first ? 1 : 2;
    j1939_MessageRequest request = {};
    request.kind = j1939_MESSAGE_SEND;
    request.pgn = pgn;
    request.destination = j1939::kGlobalAddress;
    request.data._buffer = bytes.data();
    request.data._length = request.data._maximum = size;
    ask(giver, request);
  }
  void ask_for(Giver giver, std::uint32_t pgn) {
    j1939_MessageRequest request = {};
    request.kind = j1939_MESSAGE_ASK;
    request.pgn = pgn;
    request.destination = kEcu;
    ask(giver, request);
  }
  /// Frames of a group, by PDU format and group extension, or destination.
  static bool is_of(const can::Frame& frame, std::uint32_t pgn) {
    constexpr std::uint32_t kPgn = 0x3FFFF;
    return (frame.id >> 8U & kPgn) == pgn;
  }

 private:
  /// Looks who has the address, and takes it.
  void claim() { run(milliseconds(600)); }

  std::uint64_t newest_ = 0;
};

class Message final : public J1939Row {
 public:
  Message() : J1939Row({}, "[send]\nqueue = 2\n") {}
  void give(Giver giver) override { send(giver, kGroup, 1); }
  std::string on_bus() override {
    return frames(
        [](const can::Frame& frame) { return is_of(frame, kGroup) ? whose(frame.data[0]) : std::string(); });
  }

 private:
  static constexpr std::uint32_t kGroup = 0xFF10;
};

/// A message of three packets for all.
class LongMessage final : public J1939Row {
 public:
  LongMessage() : J1939Row({}, "[transport]\nbroadcast_interval_ms = 100\n") {}
  void give(Giver giver) override { send(giver, kGroup, 20); }
  std::string on_bus() override {
    return frames([](const can::Frame& frame) {
      constexpr std::uint32_t kPackets = 0xEBFF;
      if (!is_of(frame, kPackets)) return std::string();
      if (frame.data[0] == 1) return whose(frame.data[1]) + " begun";
      return std::string(frame.data[0] == 3 ? "ended" : "");
    });
  }

 private:
  static constexpr std::uint32_t kGroup = 0xFF11;
};

/// A request for a group of another node.
class GroupRequest : public J1939Row {
 public:
  explicit GroupRequest(std::uint32_t group = 0xFEEB) : J1939Row({}, "[send]\nqueue = 2\n"), group_(group) {}
  void give(Giver giver) override { ask_for(giver, group_); }
  std::string on_bus() override {
    return frames([&](const can::Frame& frame) {
      constexpr std::uint32_t kRequest = 0xEA00 + kEcu;
      const std::uint32_t asked = frame.data[0] + frame.data[1] * 0x100U + frame.data[2] * 0x10000U;
      return is_of(frame, kRequest) && asked == group_ ? std::string("request") : std::string();
    });
  }

 private:
  const std::uint32_t group_;
};

/// A request that makes another node erase its faults (DM11).
class Erasure final : public GroupRequest {
 public:
  Erasure() : GroupRequest(0xFED3) {}
};

/// A group that the file gives, sent again and again.
class ProvidedGroup final : public J1939Row {
 public:
  ProvidedGroup() : J1939Row(kProvided) {}
  bool is_job() const override { return false; }
  void give(Giver /*giver*/) override {}
  void end(Giver /*giver*/) override {}
  std::string on_bus() override {
    return frames([](const can::Frame& frame) { return is_of(frame, 0xFF20) ? "first" : ""; });
  }
};

}  // namespace

void add_j1939_rows(Rows& rows) {
  rows.add<Message>("j1939.message");
  rows.add<LongMessage>("j1939.long_message");
  rows.add<GroupRequest>("j1939.request");
  rows.add<Erasure>("j1939.erasure");
  rows.add<ProvidedGroup>("j1939.provided");
}

}  // namespace given
