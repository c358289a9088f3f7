// SFB 402 CAN_CFGO and 401 CAN_TX, section 4.2.2 of the manual of the Saia PCD's CAN functions:
// each row of their tables of inputs, outputs and codes, and the rules beside them.
#include "direct_access_rig.h"

namespace cansync::client::function_blocks {
namespace {

// Bytes 0 ObjID, 2 MsgID, 6 Mask, 10.0 IDE, 10.1 Dir, 10.2 EnableInt, 12 Timeout, behind a header of four
// words.
TEST_F(DirectAccess, L34TheTableIsThatOfTheManual) {
  const std::vector<std::uint8_t> block = {0,    0,    0,    0,    0,    0,    0,    0,     //
                                           0,    3,    0x12, 0x34, 0x56, 0x78, 0x1F, 0xFF,  //
                                           0xFF, 0xF0, 0x07, 0,    0,    0,    0x01, 0x2C};
  const CanObjCfgDef entry = {.ObjID = 3,
                              .MsgID = 0x12345678,
                              .Mask = 0x1FFFFFF0,
                              .IDE = true,
                              .Dir = true,
                              .EnableInt = true,
                              .Timeout = 300};
  EXPECT_EQ(data_block(std::span(&entry, 1)), block);
  connection.load_data_block(12, block);
  objects.DBNr = 12;
  objects.NbObj = 1;
  objects.call();
  ASSERT_EQ(objects.RetVal, can_status::done) << objects.error();
  ASSERT_TRUE(call_until(state, [&] { return daemon->settings.size() == 1; }));
  const layer2_ObjectSettings& one = daemon->settings.front();
  EXPECT_EQ(one.number, 3);
  EXPECT_EQ(one.identifier, 0x12345678u);
  EXPECT_EQ(one.mask, 0x1FFFFFF0u);
  EXPECT_TRUE(one.extended && one.transmit && one.tell);
  EXPECT_EQ(one.timeout, 300u);
}

TEST_F(DirectAccess, L34EachReturnValueOfCanCfgo) {
  EXPECT_EQ(retval(objects.PortID, 1), can_status::wrong_port);
  EXPECT_EQ(retval(objects.DBNr, 0), can_status::block_number);
  EXPECT_EQ(retval(objects.DBNr, 99), can_status::block_missing);
  for (const INT offset : {INT{-1}, INT{1}, INT{2}})
    EXPECT_EQ(retval(objects.Offset, offset), can_status::wrong_parameter);
  for (const INT number : {INT{-1}, INT{0}, INT{3}})
    EXPECT_EQ(retval(objects.NbObj, number), can_status::wrong_parameter);
  EXPECT_EQ(with({.ObjID = 32}), can_status::wrong_identifier);
  EXPECT_EQ(with({.ObjID = -1}), can_status::wrong_identifier);
  EXPECT_EQ(with({.MsgID = 0x800}), can_status::wrong_identifier);
  EXPECT_EQ(with({.MsgID = 0x20000000, .IDE = true}), can_status::wrong_identifier);
  EXPECT_EQ(with({.Timeout = -1}), can_status::wrong_parameter);
  connection.load_data_block(12, {0, 1, 0, 0, 0, 0, 0, 0});
  EXPECT_EQ(retval(objects.DBNr, 12), can_status::wrong_parameter) << "another version";
  configure.RxIntOB = 0;
  configure.call();
  EXPECT_EQ(with({.EnableInt = true}), can_status::wrong_parameter) << "no routine";
  CAN_CFGQ queues(connection);
  queues.RxQueueDepth = queues.TxQueueDepth = 1;
  queues.call();
  for (const INT number : {INT{30}, INT{31}})
    EXPECT_EQ(with({.ObjID = number}), can_status::denied) << "of the queues";
  EXPECT_EQ(with({.ObjID = 29}), can_status::done);
  daemon.reset();
  ASSERT_TRUE(repeat_until([&] { objects.call(); }, [&] { return objects.RetVal == can_status::refused; }));
}

// "if an ObjID occurs twice the later entry wins"; Offset counts entries.
TEST_F(DirectAccess, L34TheLaterEntryWinsFromOffsetOn) {
  const std::vector<CanObjCfgDef> twice = {
      {.ObjID = 1, .MsgID = 1}, {.ObjID = 2, .MsgID = 2}, {.ObjID = 2, .MsgID = 3}};
  connection.load_data_block(10, data_block(twice));
  objects.Offset = 1;
  objects.call();
  ASSERT_EQ(objects.RetVal, can_status::done) << objects.error();
  ASSERT_TRUE(call_until(state, [&] { return !daemon->settings.empty(); }));
  ASSERT_EQ(daemon->settings.size(), 1u);
  EXPECT_EQ(daemon->settings[0].number, 2);
  EXPECT_EQ(daemon->settings[0].identifier, 3u);
}

TEST_F(DirectAccess, L34WhatTheDaemonRefusesIsNotSetUp) {
  daemon->answers = false;
  objects.call();
  EXPECT_EQ(objects.open(), 1u);
  ASSERT_TRUE(asked(1));
  daemon->reply(daemon->objects[0],
                {.code = gateway_REPLY_REFUSED, .reason = "read-only", .cause = gateway_CAUSE_READ_ONLY});
  ASSERT_TRUE(call_until(state, [&] { return objects.open() == 0; }));
  EXPECT_EQ(objects.error(), "daemon: read-only");
  EXPECT_EQ(start(), can_status::denied);
}

// SFB 403 takes them back: neither sends nor receives any more.
TEST_F(DirectAccess, L34CanCfgTakesThemBack) {
  begin();
  configure.call();
  EXPECT_EQ(start(), can_status::denied);
  receive.call();
  EXPECT_EQ(receive.Status, can_status::denied);
  ASSERT_TRUE(asked(1));
  ASSERT_EQ(daemon->settings.size(), 2u);
  for (const auto& one : daemon->settings) EXPECT_FALSE(one.transmit || one.tell);
}

// Rows 8181, 0000 with Done in one call, 0000 without a job; the event of the object.
TEST_F(DirectAccess, L35AJobFromItsEdgeToDone) {
  begin();
  send.call();
  EXPECT_EQ(send.Status, can_status::done);
  EXPECT_FALSE(send.Done || send.Error) << "no job pending";
  EXPECT_EQ(start(), can_status::in_execution);
  EXPECT_FALSE(send.Done || send.Error);
  ASSERT_TRUE(asked(1));
  const layer2_ObjectRequest& wanted = daemon->objects[0];
  EXPECT_EQ(wanted.action, layer2_OBJECT_SEND);
  EXPECT_EQ(wanted.number, kSends);
  EXPECT_EQ(wanted.content.identifier, 0x123u) << "in place of the object's";
  EXPECT_EQ(wanted.content.length, 2);
  EXPECT_EQ(wanted.content.data[1], 0x22);
  send.call();
  EXPECT_EQ(send.Status, can_status::in_execution);
  answer(0, gateway_REPLY_DONE);
  ASSERT_TRUE(call_until(send, [&] { return BOOL{send.Done}; }));
  EXPECT_EQ(send.Status, can_status::done);
  send.call();
  EXPECT_FALSE(send.Done || send.Error) << "once";
  EXPECT_EQ(send.Status, can_status::done);
  ASSERT_EQ(sent.size(), 1u);
  EXPECT_EQ(sent[0].parameter, 0x4321);
  EXPECT_EQ(sent[0].object, kSends);
}

TEST_F(DirectAccess, L35WithoutAnEdgeInputsAreIgnored) {
  begin();
  EXPECT_EQ(start(), can_status::in_execution);
  send.DLC = 9;
  send.MsgID = 0xFFFFFFFF;
  send.call();
  EXPECT_EQ(send.Status, can_status::in_execution);
  send.DLC = 2;
  send.MsgID = 0x123;
  EXPECT_EQ(start(), can_status::full) << "its job is pending";
  EXPECT_TRUE(send.Error);
  send.call();
  EXPECT_EQ(send.Status, can_status::in_execution) << "and goes on";
  ASSERT_TRUE(asked(1));
  answer(0, gateway_REPLY_DONE);
  ASSERT_TRUE(call_until(state, [&] { return sent.size() == 1; }));
  send.Act = true;
  send.call();
  EXPECT_EQ(send.Status, can_status::done) << "Done in the call with the edge is that of the job before";
  EXPECT_TRUE(send.Done);
  send.call();
  EXPECT_EQ(send.Status, can_status::in_execution);
  EXPECT_FALSE(send.Done);
}

// The daemon takes both by ways of their own.
TEST_F(DirectAccess, L35AJobWaitsForTheSettings) {
  daemon->answers = false;
  objects.call();
  EXPECT_EQ(start(), can_status::in_execution);
  ASSERT_TRUE(asked(1));
  EXPECT_EQ(daemon->objects[0].action, layer2_OBJECT_CONFIGURE);
  for (int cycle = 0; cycle < 20; ++cycle) send.call();
  daemon->take();
  EXPECT_EQ(daemon->objects.size(), 1u);
  EXPECT_EQ(send.Status, can_status::in_execution);
  answer(0, gateway_REPLY_DONE);
  ASSERT_TRUE(asked(2));
  EXPECT_EQ(daemon->objects[1].action, layer2_OBJECT_SEND);
}

TEST_F(DirectAccess, L35EachWrongInput) {
  EXPECT_EQ(start(), can_status::denied) << "not set up";
  begin();
  for (const INT length : {INT{-1}, INT{9}}) {
    send.DLC = length;
    EXPECT_EQ(start(), can_status::wrong_length);
    EXPECT_TRUE(send.Error);
  }
  send.DLC = 2;
  send.TxData = std::span(bytes).first(1);
  EXPECT_EQ(start(), can_status::wrong_parameter) << "8190, not 8186 as in SFB 410";
  send.TxData = bytes;
  send.MsgID = 0x800;
  EXPECT_EQ(start(), can_status::wrong_identifier);
  for (const INT number : {INT{-1}, INT{32}}) {
    send.ObjID = number;
    EXPECT_EQ(start(), can_status::wrong_identifier);
  }
  send.ObjID = kReceives;
  EXPECT_EQ(start(), can_status::denied) << "it receives";
  send.ObjID = kSends;
  send.PortID = 1;
  EXPECT_EQ(start(), can_status::wrong_port);
  EXPECT_TRUE(daemon->objects.empty());
}

TEST_F(DirectAccess, L35WhatTheDaemonRefusesOrTheBusDoesNotTake) {
  begin();
  const auto ended = [&](gateway_ReplyCode code, gateway_RefusalCause cause = gateway_CAUSE_NONE) {
    daemon->objects.clear();
    EXPECT_EQ(start(), can_status::in_execution);
    EXPECT_TRUE(asked(1));
    answer(0, code, cause);
    EXPECT_TRUE(call_until(send, [&] { return send.Status != can_status::in_execution; }));
    EXPECT_FALSE(send.Done);
    return send.Status;
  };
  EXPECT_EQ(ended(gateway_REPLY_REFUSED, gateway_CAUSE_WRONG_STATE), can_status::denied);
  EXPECT_EQ(ended(gateway_REPLY_REFUSED, gateway_CAUSE_QUEUE_FULL), can_status::full);
  EXPECT_EQ(ended(gateway_REPLY_REFUSED, gateway_CAUSE_RIGHT), can_status::refused);
  EXPECT_EQ(ended(gateway_REPLY_NO_ANSWER), can_status::refused);
  EXPECT_TRUE(send.Error);
  daemon->status.running = false;
  daemon->tell();
  ASSERT_TRUE(call_until(send, [&] { return send.Status == can_status::refused; }));
  EXPECT_NE(send.error().find("stop"), std::string::npos) << send.error();
}

TEST_F(DirectAccess, L36AbortEndsTheJobAndNothingElse) {
  begin();
  EXPECT_EQ(start(), can_status::in_execution);
  send.Act = send.Abort = true;
  ASSERT_TRUE(call_until(send, [&] { return daemon->objects.size() == 2; }));
  EXPECT_EQ(daemon->objects[1].action, layer2_OBJECT_ABORT);
  send.call();
  EXPECT_EQ(send.Status, can_status::in_execution) << "the daemon has not answered";
  answer(1, gateway_REPLY_DONE);
  answer(0, gateway_REPLY_CANCELLED);
  ASSERT_TRUE(call_until(send, [&] { return send.Status == can_status::aborted; }));
  EXPECT_FALSE(send.Done || send.Error);
  send.call();
  EXPECT_EQ(send.Status, can_status::done);
  EXPECT_EQ(daemon->objects.size(), 2u) << "the edge beside Abort gives no job";
}

TEST_F(DirectAccess, L37TimeoutIsToldWithoutAnEvent) {
  begin();
  EXPECT_EQ(start(), can_status::in_execution);
  ASSERT_TRUE(asked(1));
  answer(0, gateway_REPLY_TIMEOUT);
  ASSERT_TRUE(call_until(send, [&] { return send.Status == can_status::timed_out; }));
  EXPECT_TRUE(send.Error);
  EXPECT_FALSE(send.Done);
  EXPECT_TRUE(sent.empty());
}

TEST_F(DirectAccess, L37AHeldJobTimesOut) {
  table[0].Timeout = 1;
  connection.load_data_block(10, data_block(table));
  begin();
  send.RTR = true;
  EXPECT_EQ(start(), can_status::in_execution);
  ASSERT_TRUE(asked(1));
  answer(0, gateway_REPLY_DONE);
  told(0, layer2_OBJECT_JOB_NONE, layer2_OBJECT_END_TIMED_OUT);
  ASSERT_TRUE(call_until(send, [&] { return send.Status == can_status::timed_out; }));
  EXPECT_TRUE(send.Error);
}

TEST_F(DirectAccess, L38OneAnswerToARemoteFrame) {
  begin();
  send.RTR = true;
  EXPECT_EQ(start(), can_status::in_execution);
  ASSERT_TRUE(asked(1));
  EXPECT_TRUE(daemon->objects[0].on_remote);
  EXPECT_FALSE(daemon->objects[0].every_time);
  answer(0, gateway_REPLY_DONE);
  told(0, layer2_OBJECT_JOB_HELD);
  EXPECT_EQ(start(), can_status::in_execution) << "another edge takes its place while nobody asks";
  ASSERT_TRUE(asked(2));
  answer(1, gateway_REPLY_DONE);
  told(1, layer2_OBJECT_JOB_NONE, layer2_OBJECT_END_DONE, 2);
  ASSERT_TRUE(call_until(send, [&] { return BOOL{send.Done}; }));
  EXPECT_EQ(sent.size(), 1u);
  send.call();
  EXPECT_FALSE(send.Done);
  EXPECT_EQ(send.Status, can_status::done);
}

TEST_F(DirectAccess, L38AnAnswerIsThatOfItsJob) {
  begin();
  send.RTR = true;
  EXPECT_EQ(start(), can_status::in_execution);
  ASSERT_TRUE(asked(1));
  answer(0, gateway_REPLY_DONE);
  told(0, layer2_OBJECT_JOB_HELD);
  EXPECT_EQ(start(), can_status::in_execution) << "another job takes its place";
  ASSERT_TRUE(asked(2));
  // The first one was answered at that moment, which is told only now.
  told(1, layer2_OBJECT_JOB_NONE);
  answer(1, gateway_REPLY_DONE);
  told(0, layer2_OBJECT_JOB_HELD, layer2_OBJECT_END_DONE, 2);
  ASSERT_TRUE(call_until(state, [&] { return objects.open() == 0; }));
  for (int i = 0; i < 20; ++i) {
    send.call();
    ASSERT_EQ(send.Status, can_status::in_execution);
    ASSERT_FALSE(send.Done);
  }
  EXPECT_TRUE(sent.empty());
  told(1, layer2_OBJECT_JOB_NONE, layer2_OBJECT_END_DONE, 2);
  ASSERT_TRUE(call_until(send, [&] { return BOOL{send.Done}; }));
  EXPECT_EQ(sent.size(), 1u);
}

TEST_F(DirectAccess, AJobThatAnotherProgramReplacesHasEnded) {
  begin();
  send.RTR = true;
  EXPECT_EQ(start(), can_status::in_execution);
  ASSERT_TRUE(asked(1));
  answer(0, gateway_REPLY_DONE);
  told(0, layer2_OBJECT_JOB_HELD);
  told(1, layer2_OBJECT_JOB_NONE, layer2_OBJECT_END_DONE, 2);
  ASSERT_TRUE(call_until(send, [&] { return send.Status == can_status::aborted; }));
  EXPECT_FALSE(send.Done);
  EXPECT_TRUE(sent.empty());
}

TEST_F(DirectAccess, L38EachAnswerIsDoneOnce) {
  begin();
  send.RTR = send.MultipleTx = true;
  EXPECT_EQ(start(), can_status::in_execution);
  ASSERT_TRUE(asked(1));
  EXPECT_TRUE(daemon->objects[0].every_time);
  answer(0, gateway_REPLY_DONE);
  told(3, layer2_OBJECT_JOB_HELD);
  int done = 0;
  ASSERT_TRUE(call_until(send, [&] { return (done += send.Done) == 3; }));
  send.call();
  EXPECT_FALSE(send.Done);
  EXPECT_EQ(send.Status, can_status::done) << "pending only until the first answer";
  EXPECT_EQ(sent.size(), 3u);
  send.Abort = true;
  ASSERT_TRUE(call_until(send, [&] { return daemon->objects.size() == 2; }));
  answer(1, gateway_REPLY_DONE);
  ASSERT_TRUE(call_until(send, [&] { return send.Status == can_status::aborted; }));
}

}  // namespace
}  // namespace cansync::client::function_blocks
