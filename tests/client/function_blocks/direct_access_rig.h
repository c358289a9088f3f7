#pragma once

#include <cansync/function_blocks/layer2/can_status.h>

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "frame_rig.h"

/// Two message objects that SFB 402 sets up, one that sends and one that receives.
namespace cansync::client::function_blocks {

inline constexpr INT kSends = 3;
inline constexpr INT kReceives = 5;

class DirectAccess : public FrameBlockTest {
 protected:
  void SetUp() override {
    configure.Baudrate = 500'000;
    configure.RxIntOB = 40;
    configure.RxIntPrm = 0x1234;
    configure.TxIntOB = 41;
    configure.TxIntPrm = 0x4321;
    ASSERT_TRUE(call_until(configure, [&] { return configure.RetVal == can_status::done; }))
        << configure.error();
    connection.on_interrupt(40, [&](const Interrupt& one) { received.push_back(one); });
    connection.on_interrupt(41, [&](const Interrupt& one) { sent.push_back(one); });
    connection.load_data_block(10, data_block(table));
    objects.DBNr = 10;
    objects.NbObj = 2;
    send.ObjID = kSends;
    send.MsgID = 0x123;
    send.DLC = 2;
    send.TxData = bytes;
    receive.ObjID = kReceives;
    receive.RxData = target;
  }
  /// Both objects are set up.
  void begin() {
    objects.call();
    ASSERT_EQ(objects.RetVal, can_status::done) << objects.error();
    ASSERT_TRUE(call_until(state, [&] { return objects.open() == 0; }));
    ASSERT_EQ(objects.error(), "");
    daemon->objects.clear();
    daemon->answers = false;
  }
  /// A rising edge of Act, and what the call said.
  WORD start() {
    send.Act = false;
    send.call();
    send.Act = true;
    send.call();
    send.Act = false;
    return send.Status;
  }
  /// The daemon has been asked so often since `begin`.
  bool asked(std::size_t times) {
    return call_until(state, [&] { return daemon->objects.size() >= times; });
  }
  void answer(std::size_t which, gateway_ReplyCode code, gateway_RefusalCause cause = gateway_CAUSE_NONE) {
    daemon->reply(daemon->objects.at(which), {.code = code, .cause = cause, .job_number = which + 1});
  }
  /// As the daemon tells of the object that receives.
  void full(std::uint64_t number, std::uint8_t first, bool overrun = false, std::int64_t time = 0) {
    layer2_ObjectStatus status = {.number = kReceives, .configured = true, .full = true, .overrun = overrun};
    status.content = FakeFrameDaemon::frame(0x1A5, {first, 2, 3}).received;
    status.received = number;
    status.time = time;
    daemon->tell(status);
  }
  /// As the daemon tells of the object that sends, whose job is its `number`th.
  void told(std::uint64_t frames, layer2_ObjectJob job, layer2_ObjectJobEnd end = layer2_OBJECT_END_DONE,
            std::uint64_t number = 1) {
    layer2_ObjectStatus status = {
        .number = kSends, .configured = true, .transmit = true, .job = job, .ended_as = end};
    status.sent = 100 + frames;  // of other jobs, too
    status.job_number = number;
    status.job_sent = frames;
    daemon->tell(status);
  }
  WORD retval(INT& input, INT value) {
    const INT before = std::exchange(input, value);
    objects.call();
    input = before;
    return objects.RetVal;
  }
  WORD with(const CanObjCfgDef& entry) {
    connection.load_data_block(11, data_block(std::span(&entry, 1)));
    objects.DBNr = 11;
    objects.NbObj = 1;
    objects.call();
    return objects.RetVal;
  }

  std::vector<CanObjCfgDef> table = {
      {.ObjID = kSends, .MsgID = 0x100, .Dir = true, .EnableInt = true},
      {.ObjID = kReceives, .MsgID = 0x1A0, .Mask = 0x7F0, .EnableInt = true},
  };
  CAN_CFG configure{connection};
  CAN_CFGO objects{connection};
  CAN_TX send{connection};
  CAN_RX receive{connection};
  CAN_STAT state{connection};
  std::array<BYTE, 8> bytes = {0x11, 0x22};
  std::array<BYTE, 8> target = {};
  std::vector<Interrupt> received;
  std::vector<Interrupt> sent;
};

}  // namespace cansync::client::function_blocks
