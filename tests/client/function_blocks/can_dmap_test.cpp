// SFB 413 CAN_DMAP, section 4.2.4 of the manual of the Saia PCD's CAN functions: each row of its table, its
// example, and the process image of the connection.
#include <cansync/function_blocks/layer2/can_status.h>

#include <numeric>

#include "frame_rig.h"

namespace cansync::client::function_blocks {
namespace {

class CanDmap : public FrameBlockTest {
 protected:
  void SetUp() override {
    configure.Baudrate = 500'000;
    ASSERT_TRUE(call_until(configure, [&] { return configure.RetVal == can_status::done; }))
        << configure.error();
    mapping.DBNr = 20;
    mapping.TxTime = 25;
    mapping.MsgID = 0x300;
    mapping.Mask = 0x700;
  }
  WORD with(const std::vector<CanIOEntry>& table) {
    connection.load_data_block(20, data_block(table));
    mapping.NbEntries = static_cast<INT>(table.size());
    mapping.call();
    return mapping.RetVal;
  }
  /// What the daemon was asked for last.
  std::string sections(std::size_t times) {
    EXPECT_TRUE(call_until(state, [&] { return daemon->configured.size() >= times; }));
    return daemon->configured.empty() ? "" : daemon->configured.back();
  }

  CAN_CFG configure{connection};
  CAN_DMAP mapping{connection};
  CAN_STAT state{connection};
};

// The manual's example: bytes 0 to 4 of 16#318 come to input bytes 10, 11, 512, 513 and 35.
TEST_F(CanDmap, L50TheExampleOfTheManual) {
  const std::vector<std::uint8_t> block = {
      0, 0, 0,    0,    0, 0, 0, 0,                 //
      0, 0, 0x03, 0x18, 0, 0, 0, 10,   0, 2, 0, 0,  //
      0, 0, 0x03, 0x18, 0, 2, 2, 0x00, 0, 2, 0, 0,  //
      0, 0, 0x03, 0x18, 0, 4, 0, 35,   0, 1, 0, 0,
  };
  const std::vector<CanIOEntry> table = {{.MsgID = 0x318, .MsgOffset = 0, .VA = 10, .Size = 2},
                                         {.MsgID = 0x318, .MsgOffset = 2, .VA = 512, .Size = 2},
                                         {.MsgID = 0x318, .MsgOffset = 4, .VA = 35, .Size = 1}};
  EXPECT_EQ(data_block(table), block);
  connection.load_data_block(20, block);
  mapping.NbEntries = 3;
  mapping.call();
  ASSERT_EQ(mapping.RetVal, can_status::done) << mapping.error();
  EXPECT_EQ(
      sections(1),
      "[mapping]\nidentifier = 768\nmask = 1792\nextended = false\ninterval_ms = 10\non_change = false\n"
      "[[mapped]]\nnumber = 0\nidentifier = 792\noffset = 0\naddress = 10\nsize = 2\noutput = false\n"
      "[[mapped]]\nnumber = 1\nidentifier = 792\noffset = 2\naddress = 512\nsize = 2\noutput = false\n"
      "[[mapped]]\nnumber = 2\nidentifier = 792\noffset = 4\naddress = 35\nsize = 1\noutput = false\n");
  EXPECT_TRUE(call_until(state, [&] { return mapping.open() == 0; }));
  EXPECT_EQ(mapping.error(), "");
}

TEST_F(CanDmap, L50EachReturnValue) {
  const CanIOEntry in = {.MsgID = 0x301, .VA = 0, .Size = 1};
  const CanIOEntry out = {.MsgID = 0x101, .VA = 0, .Size = 8, .IO = true};
  EXPECT_EQ(with({in, out}), can_status::done) << mapping.error();
  const auto retval = [&](auto& input, auto value) {
    const auto before = std::exchange(input, value);
    mapping.call();
    input = before;
    return mapping.RetVal;
  };
  EXPECT_EQ(retval(mapping.PortID, INT{1}), can_status::wrong_port);
  EXPECT_EQ(retval(mapping.NbEntries, INT{-1}), can_status::wrong_parameter);
  EXPECT_EQ(retval(mapping.NbEntries, INT{3}), can_status::wrong_parameter) << "two are there";
  EXPECT_EQ(retval(mapping.TxTime, INT{0}), can_status::wrong_parameter);
  EXPECT_EQ(retval(mapping.MsgID, DWORD{0x800}), can_status::wrong_parameter);
  for (const INT number : {INT{0}, INT{99}})
    EXPECT_EQ(retval(mapping.DBNr, number), can_status::block_number);
  connection.load_data_block(21, {0, 1, 0, 0, 0, 0, 0, 0});
  EXPECT_EQ(retval(mapping.DBNr, INT{21}), can_status::wrong_parameter) << "another version";
  for (const INT size : {INT{1}, INT{3}, INT{8}})
    EXPECT_EQ(with({{.MsgID = 0x301, .Size = size}}), can_status::done) << "any number from 1 to 8";
  for (const INT size : {INT{0}, INT{9}, INT{-1}})
    EXPECT_EQ(with({{.MsgID = 0x301, .Size = size}}), can_status::wrong_configuration);
  EXPECT_EQ(with({{.MsgID = 0x301, .MsgOffset = 7, .Size = 2}}), can_status::wrong_configuration);
  EXPECT_EQ(with({{.MsgID = 0x301, .MsgOffset = -1}}), can_status::wrong_configuration);
  EXPECT_EQ(with({{.MsgID = 0x800, .IO = true}}), can_status::wrong_configuration);
  EXPECT_EQ(with({{.MsgID = 0x400}}), can_status::wrong_configuration) << "the mask does not take it";
  EXPECT_EQ(with({{.MsgID = 0x301, .VA = 0, .Size = 8}, {.MsgID = 0x301, .VA = 8, .Size = 1}}),
            can_status::wrong_configuration)
      << "more than 8 bytes of one identifier";
  EXPECT_EQ(with({{.MsgID = 0x301, .VA = 4}, {.MsgID = 0x302, .VA = 4}}), can_status::address_taken);
  for (const INT address : {INT{-1}, INT{1024}})
    EXPECT_EQ(with({{.MsgID = 0x301, .VA = address}}), can_status::address_taken);
  daemon.reset();
  ASSERT_TRUE(repeat_until([&] { mapping.call(); }, [&] { return mapping.RetVal == can_status::refused; }));
}

TEST_F(CanDmap, L51MoreThanThereIsRoomFor) {
  std::vector<CanIOEntry> table;
  for (INT i = 0; i < 129; ++i) table.push_back({.MsgID = static_cast<DWORD>(0x300 + i), .VA = i});
  EXPECT_EQ(with(table), can_status::no_memory) << "129 telegrams in";
  table.pop_back();
  EXPECT_EQ(with(table), can_status::done) << mapping.error();
  EXPECT_EQ(with(std::vector<CanIOEntry>(513, {.MsgID = 0x301})), can_status::no_memory) << "513 entries";
}

TEST_F(CanDmap, L52L53IntervalAndChange) {
  mapping.TxChange = true;
  mapping.IDE = true;
  mapping.MsgID = mapping.Mask = 0;
  ASSERT_EQ(with({{.MsgID = 0x18000000, .Size = 1, .IO = true}}), can_status::done) << mapping.error();
  const std::string text = sections(1);
  EXPECT_NE(text.find("interval_ms = 25\non_change = true"), std::string::npos) << text;
  EXPECT_NE(text.find("extended = true"), std::string::npos) << text;
}

TEST_F(CanDmap, L57NoEntriesEndTheMappingAndSoDoesCanCfg) {
  const std::vector<CanIOEntry> table = {{.MsgID = 0x301}};
  ASSERT_EQ(with(table), can_status::done);
  (void)sections(1);
  mapping.NbEntries = 0;
  mapping.DBNr = 0;
  mapping.call();
  ASSERT_EQ(mapping.RetVal, can_status::done) << mapping.error();
  EXPECT_EQ(sections(2), "[mapping]\n");
  mapping.DBNr = 20;
  ASSERT_EQ(with(table), can_status::done);
  (void)sections(3);
  configure.call();
  EXPECT_EQ(sections(4), "[mapping]\n");
}

// A daemon that takes one over refuses another.
TEST_F(CanDmap, L50OneAfterTheOther) {
  daemon->answers = false;
  ASSERT_EQ(with({{.MsgID = 0x301}}), can_status::done);
  (void)sections(1);
  ASSERT_EQ(with({{.MsgID = 0x302}}), can_status::done);
  ASSERT_EQ(with({{.MsgID = 0x303}}), can_status::done);
  EXPECT_EQ(mapping.open(), 2u) << "the later took the place of the one that waited";
  daemon->reply(daemon->controls[0], gateway_REPLY_DONE);
  EXPECT_NE(sections(2).find("identifier = 771\n"), std::string::npos);
  daemon->reply(daemon->controls[1], gateway_REPLY_REFUSED, "no");
  ASSERT_TRUE(call_until(state, [&] { return mapping.open() == 0; }));
  EXPECT_EQ(mapping.error(), "daemon: no");
  EXPECT_NE(connection.write_outputs(0, {}), "") << "there is none";
}

// The daemon keeps what it had when it refuses another: it would send its outputs for ever.
TEST_F(CanDmap, L57OneBeforeARefusedOneEndsWithCanCfgToo) {
  ASSERT_EQ(with({{.MsgID = 0x301}}), can_status::done);
  (void)sections(1);
  ASSERT_TRUE(call_until(state, [&] { return mapping.open() == 0; }));
  daemon->answers = false;
  ASSERT_EQ(with({{.MsgID = 0x302}}), can_status::done);
  (void)sections(2);
  daemon->reply(daemon->controls[1], gateway_REPLY_REFUSED, "no");
  ASSERT_TRUE(call_until(state, [&] { return mapping.open() == 0; }));
  EXPECT_NE(connection.write_outputs(0, {}), "") << "those of another table";
  daemon->answers = true;
  configure.call();
  EXPECT_EQ(sections(3), "[mapping]\n");
  ASSERT_EQ(with({{.MsgID = 0x303}}), can_status::done);
  EXPECT_NE(sections(4).find("identifier = 771\n"), std::string::npos);
}

TEST_F(CanDmap, L56InputsAreThoseOfTheLastCallAndOutputsGoAsAWhole) {
  const std::array<std::uint8_t, 3> bytes = {7, 8, 9};
  EXPECT_NE(connection.write_outputs(0, bytes).find("CAN_DMAP"), std::string::npos);
  ASSERT_EQ(with({{.MsgID = 0x301}, {.MsgID = 0x101, .Size = 3, .IO = true}}), can_status::done);
  layer2_ProcessImage image = {};
  image.inputs[0] = 0x55;
  image.inputs[1023] = 0x66;
  daemon->tell(image);
  ASSERT_TRUE(call_until(state, [&] { return connection.inputs()[0] == 0x55; }));
  EXPECT_EQ(connection.inputs()[1023], 0x66);
  EXPECT_NE(connection.write_outputs(1022, bytes).find("1024"), std::string::npos);
  ASSERT_TRUE(call_until(state, [&] { return connection.write_outputs(1021, bytes).empty(); }));
  ASSERT_TRUE(call_until(state, [&] { return !daemon->outputs.empty(); }));
  EXPECT_EQ(daemon->outputs.front(), (std::vector<std::uint8_t>{7, 8, 9}));
}

// 28 and 29 are closed to the other modes as soon as there is a mapping.
TEST_F(CanDmap, L59ItsObjectsAreClosed) {
  CAN_CFGO objects(connection);
  const CanObjCfgDef entry = {.ObjID = 28, .MsgID = 1, .Dir = true};
  connection.load_data_block(1, data_block(std::span(&entry, 1)));
  objects.DBNr = objects.NbObj = 1;
  objects.call();
  ASSERT_EQ(objects.RetVal, can_status::done) << objects.error();
  ASSERT_EQ(with({{.MsgID = 0x301}}), can_status::done);
  objects.call();
  EXPECT_EQ(objects.RetVal, can_status::denied);
  CAN_TX send(connection);
  send.ObjID = 28;
  send.call();
  EXPECT_EQ(send.Status, can_status::denied);
}

}  // namespace
}  // namespace cansync::client::function_blocks
