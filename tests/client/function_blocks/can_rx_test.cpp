// SFB 400 CAN_RX, section 4.2.2 of the manual of the Saia PCD's CAN functions: each row of its table, and the
// rules beside it.
#include "direct_access_rig.h"

namespace cansync::client::function_blocks {
namespace {

class CanRx : public DirectAccess {
 protected:
  void SetUp() override {
    DirectAccess::SetUp();
    begin();
  }
  /// It is open, as the daemon has said.
  void open() {
    receive.ReleaseRx = true;
    receive.call();
    ASSERT_TRUE(asked(1));
    answer(0, gateway_REPLY_DONE);
  }
  /// The reply to a request takes a frame out of the object.
  void fetched(std::size_t which, std::uint8_t first, std::int64_t time) {
    daemon->reply(daemon->objects.at(which), {.code = gateway_REPLY_DONE,
                                              .time = time,
                                              .fresh = true,
                                              .content = FakeFrameDaemon::frame(0x1A5, {first}).received});
  }
  bool comes() {
    return call_until(receive, [&] { return BOOL{receive.NDR}; });
  }
};

// "After configuration an object is closed; the first call with ReleaseRx = 1 opens it."
TEST_F(CanRx, L40IsOpenedByTheFirstRelease) {
  receive.call();
  EXPECT_EQ(receive.Status, can_status::no_data);
  EXPECT_FALSE(receive.NDR || receive.Error);
  receive.ReleaseRx = true;
  receive.call();
  EXPECT_EQ(receive.Status, can_status::no_data);
  receive.call();
  ASSERT_TRUE(asked(1));
  answer(0, gateway_REPLY_DONE);
  receive.call();
  full(1, 0x77);
  ASSERT_TRUE(comes());
  ASSERT_TRUE(asked(2));
  EXPECT_EQ(daemon->objects.size(), 2u) << "calls on an open object ask for nothing";
  EXPECT_EQ(daemon->objects[0].action, layer2_OBJECT_READ);
  EXPECT_EQ(daemon->objects[0].number, kReceives);
  EXPECT_TRUE(daemon->objects[0].release);
  EXPECT_FALSE(daemon->objects[0].ask);
}

TEST_F(CanRx, L40NewDataOnceWithEveryOutput) {
  open();
  full(1, 0x77);
  ASSERT_TRUE(comes());
  EXPECT_EQ(receive.Status, can_status::done);
  EXPECT_FALSE(receive.Error);
  EXPECT_EQ(receive.MsgID, 0x1A5u) << "of the frame, not of the object";
  EXPECT_EQ(receive.DLC, 3);
  EXPECT_EQ(target, (std::array<BYTE, 8>{0x77, 2, 3}));
  full(1, 0x77);
  receive.call();
  EXPECT_FALSE(receive.NDR) << "one call a frame";
  EXPECT_EQ(receive.Status, can_status::no_data);
}

// "ReleaseRx = 1 re-opens at once; ReleaseRx = 0 leaves the object locked until a later call with 1."
TEST_F(CanRx, L40TheCallThatDeliversOpensOrLocks) {
  open();
  full(1, 1);
  ASSERT_TRUE(comes());
  ASSERT_TRUE(asked(2));
  EXPECT_TRUE(daemon->objects[1].release);
  answer(1, gateway_REPLY_DONE);
  receive.ReleaseRx = false;
  full(2, 2);
  ASSERT_TRUE(comes());
  ASSERT_TRUE(asked(3));
  EXPECT_FALSE(daemon->objects[2].release);
  answer(2, gateway_REPLY_DONE);
  full(3, 3);
  ASSERT_TRUE(call_until(state, [&] { return connection.daemon_present(); }));
  receive.call();
  EXPECT_FALSE(receive.NDR) << "locked";
  receive.ReleaseRx = true;
  ASSERT_TRUE(call_until(receive, [&] { return daemon->objects.size() == 4; }));
  EXPECT_TRUE(daemon->objects[3].release);
}

TEST_F(CanRx, L41AnOverrunComesWithTheData) {
  open();
  full(1, 1, true);
  ASSERT_TRUE(comes());
  EXPECT_TRUE(receive.Error);
  EXPECT_EQ(receive.Status, can_status::full);
  EXPECT_EQ(target[0], 1) << "the older one";
  ASSERT_TRUE(asked(2));
  daemon->reply(daemon->objects[1], {.fresh = true, .overrun = true});
  full(2, 2);
  ASSERT_TRUE(comes());
  EXPECT_EQ(receive.Status, can_status::done) << "told once";
  ASSERT_TRUE(asked(3));
  daemon->reply(daemon->objects[2], {.fresh = true, .overrun = true});
  full(3, 3);
  ASSERT_TRUE(comes());
  EXPECT_EQ(receive.Status, can_status::full)
      << "one that came before the object was fetched is told with the next";
}

TEST_F(CanRx, L42ARemoteFrameWithEachReleaseOfAnRtrObject) {
  receive.ReleaseRx = receive.RTR = true;
  receive.call();
  ASSERT_TRUE(asked(1));
  EXPECT_TRUE(daemon->objects[0].release && daemon->objects[0].ask);
  answer(0, gateway_REPLY_DONE);
  receive.ReleaseRx = false;
  receive.call();
  receive.call();
  EXPECT_EQ(receive.Status, can_status::no_data);
  receive.ReleaseRx = true;
  ASSERT_TRUE(call_until(receive, [&] { return daemon->objects.size() == 2; })) << "released anew";
  EXPECT_TRUE(daemon->objects[1].ask);
  daemon->reply(daemon->objects[1], {.code = gateway_REPLY_REFUSED, .cause = gateway_CAUSE_QUEUE_FULL});
  receive.ReleaseRx = false;
  full(1, 9);
  ASSERT_TRUE(comes()) << "that it asks already is no error";
  EXPECT_EQ(receive.Status, can_status::done);
}

// A cycle that is faster than the daemon tells of its objects: the answer is brought by the next request for it.
TEST_F(CanRx, L42AnAnswerThatAReplyBringsIsDataOnce) {
  receive.ReleaseRx = receive.RTR = true;
  receive.call();
  ASSERT_TRUE(asked(1));
  answer(0, gateway_REPLY_DONE);
  ASSERT_TRUE(call_until(receive, [&] { return daemon->objects.size() == 2; }));
  fetched(1, 0x33, 100);
  ASSERT_TRUE(comes());
  EXPECT_EQ(target[0], 0x33);
  full(1, 0x33, false, 100);  // told late
  ASSERT_TRUE(asked(3));
  daemon->reply(daemon->objects[2], {.code = gateway_REPLY_DONE});
  full(2, 0x44, false, 200);
  ASSERT_TRUE(comes());
  EXPECT_EQ(target[0], 0x44) << "each once";
  // The request that is to fetch this one finds the next in its place.
  ASSERT_TRUE(asked(4));
  fetched(3, 0x55, 300);
  ASSERT_TRUE(comes());
  EXPECT_EQ(target[0], 0x55);
}

// "An open object cannot be released with other settings before it received something".
TEST_F(CanRx, L42AnOpenObjectDoesNotAsk) {
  open();
  receive.RTR = true;
  receive.call();
  receive.call();
  full(1, 1);
  ASSERT_TRUE(comes());
  ASSERT_TRUE(asked(2));
  EXPECT_EQ(daemon->objects.size(), 2u);
  EXPECT_TRUE(daemon->objects[1].ask) << "the call that delivers may";
}

TEST_F(CanRx, L60EachErrorOfCanRx) {
  receive.PortID = 2;
  receive.call();
  EXPECT_EQ(receive.Status, can_status::wrong_port);
  EXPECT_TRUE(receive.Error);
  receive.PortID = 0;
  for (const INT number : {INT{-1}, INT{32}}) {
    receive.ObjID = number;
    receive.call();
    EXPECT_EQ(receive.Status, can_status::wrong_identifier);
  }
  receive.ObjID = kSends;
  receive.call();
  EXPECT_EQ(receive.Status, can_status::denied) << "it sends";
  receive.ObjID = kReceives;
  open();
  receive.RxData = std::span(target).first(2);
  full(1, 1);
  ASSERT_TRUE(call_until(receive, [&] { return receive.Status == can_status::wrong_parameter; }))
      << "8190, not 8186 as in SFB 410";
  EXPECT_FALSE(receive.NDR);
  receive.RxData = target;
  receive.call();
  EXPECT_TRUE(receive.NDR) << "it has waited";
  ASSERT_TRUE(asked(2));
  answer(1, gateway_REPLY_REFUSED, gateway_CAUSE_WRONG_STATE);
  ASSERT_TRUE(call_until(receive, [&] { return receive.Status == can_status::denied; }));
  daemon.reset();
  ASSERT_TRUE(repeat_until([&] { receive.call(); }, [&] { return receive.Status == can_status::refused; }));
}

// What a routine uses of the program may be gone by then.
TEST_F(CanRx, NoRoutineIsCalledWhileTheConnectionEnds) {
  open();
  const CanIOEntry entry = {.MsgID = 0x301};
  connection.load_data_block(20, data_block(std::span(&entry, 1)));
  CAN_DMAP mapping(connection);
  mapping.DBNr = 20;
  mapping.NbEntries = 1;
  mapping.MsgID = 0x300;
  mapping.Mask = 0x700;
  mapping.call();
  ASSERT_EQ(mapping.RetVal, can_status::done) << mapping.error();
  ASSERT_TRUE(call_until(state, [&] { return !daemon->controls.empty(); }));
  full(1, 0x42);
  { const FrameConnection gone = std::move(connection); }
  EXPECT_TRUE(received.empty());
}

// Param, ObjID and PortID of the routine; a call after it has the data.
TEST_F(CanRx, L43TheRoutineIsCalledAndTheNextCallHasTheData) {
  open();
  full(1, 0x42);
  ASSERT_TRUE(call_until(state, [&] { return !received.empty(); }));
  EXPECT_EQ(received.size(), 1u);
  EXPECT_EQ(received[0].parameter, 0x1234);
  EXPECT_EQ(received[0].object, kReceives);
  EXPECT_EQ(received[0].port, 0);
  receive.call();
  EXPECT_TRUE(receive.NDR);
  EXPECT_EQ(target[0], 0x42);
}

}  // namespace
}  // namespace cansync::client::function_blocks
