// Groups that other nodes are asked for.
#include "j1939/requested.h"

#include "j1939/node_fixture.h"

namespace j1939::test {
namespace {

TEST_F(NodeTest, RequestsAreBounded) {
  for (OrderId id = 1; id <= kMostRequests; ++id)
    ASSERT_EQ(rig.node.submit(request(id, 0xFEE5, kOther), rig.now), Refusal::none);
  EXPECT_EQ(rig.node.submit(request(99, 0xFEE5, kOther), rig.now), Refusal::queue_full);
  EXPECT_EQ(rig.pump().size(), kMostRequests);
  (void)rig.hear(frame(0x18FEE521, {7}));
  EXPECT_EQ(rig.answers().size(), kMostRequests) << "one answer is the answer to all";
  EXPECT_EQ(rig.node.submit(request(99, 0xFEE5, kOther), rig.now), Refusal::none);
}

TEST_F(NodeTest, ARequestIsDoneWithTheMessageOfTheNodeThatWasAsked) {
  ASSERT_EQ(rig.node.submit(request(1, 0xFEE5, kOther), rig.now), Refusal::none);
  EXPECT_EQ(rig.pump(), std::vector{frame(0x18EA2180, {0xE5, 0xFE, 0x00})});
  (void)rig.hear(frame(0x18FEE522, {1}));  // of another
  (void)rig.hear(frame(0x18FEE621, {1}));  // another group
  EXPECT_TRUE(rig.answers().empty());
  (void)rig.hear(frame(0x18FEE521, {4, 5, 6}));
  const Answer answer = only_answer();
  EXPECT_EQ(answer.outcome, Outcome::done);
  ASSERT_EQ(answer.size, 3u);
  EXPECT_EQ((std::vector<std::uint8_t>(data.begin(), data.begin() + 3)),
            (std::vector<std::uint8_t>{4, 5, 6}));
}

TEST_F(NodeTest, ARequestIsDoneWithALongMessageToo) {
  ASSERT_EQ(rig.node.submit(request(1, 0xFEEB, kOther), rig.now), Refusal::none);
  (void)rig.pump();
  (void)rig.hear(frame(0x1CEC8021, {16, 9, 0, 2, 255, 0xEB, 0xFE, 0x00}));
  (void)rig.hear(frame(0x1CEB8021, {1, 1, 2, 3, 4, 5, 6, 7}));
  (void)rig.hear(frame(0x1CEB8021, {2, 8, 9, 255, 255, 255, 255, 255}));
  const Answer answer = only_answer();
  EXPECT_EQ(answer.outcome, Outcome::done);
  EXPECT_EQ(answer.size, 9u);
  EXPECT_EQ(data[8], 9);
}

TEST_F(NodeTest, ARequestThatIsRefusedSaysHow) {
  for (const int control : {1, 2, 3}) {
    ASSERT_EQ(rig.node.submit(request(1, 0xFEE5, kOther), rig.now), Refusal::none);
    (void)rig.pump();
    (void)rig.hear(frame(0x18E8FF21, {control, 255, 255, 255, 0x81, 0xE5, 0xFE, 0x00}));  // for another
    EXPECT_TRUE(rig.answers().empty());
    (void)rig.hear(frame(0x18E8FF21, {control, 255, 255, 255, 0x80, 0xE5, 0xFE, 0x00}));
    const Answer answer = only_answer();
    EXPECT_EQ(answer.outcome, Outcome::refused);
    EXPECT_EQ(answer.code, control);
  }
  ASSERT_EQ(rig.node.submit(request(2, 0xFEE5, kOther), rig.now), Refusal::none);
  (void)rig.pump();
  (void)rig.hear(frame(0x18E8FF21, {0, 255, 255, 255, 255, 0xE5, 0xFE, 0x00}));
  const Answer acknowledged = only_answer();
  EXPECT_EQ(acknowledged.outcome, Outcome::done);
  EXPECT_EQ(acknowledged.size, 0u);
}

TEST_F(NodeTest, ARequestThatNobodyAnswersEndsWithItsMonitoringTime) {
  ASSERT_EQ(rig.node.submit(request(1, 0xFEE5, kOther), rig.now), Refusal::none);
  (void)rig.run(milliseconds(1249));
  EXPECT_TRUE(rig.answers().empty());
  (void)rig.run(milliseconds(1));
  EXPECT_EQ(only_answer().outcome, Outcome::no_answer);
}

/// A broadcast of 30 packets, 200 ms apart, takes 6 s.
TEST_F(NodeTest, ARequestWaitsForTheAnswerThatIsComing) {
  ASSERT_EQ(rig.node.submit(request(1, 0xFEEB, kOther), rig.now), Refusal::none);
  (void)rig.pump();
  (void)rig.run(milliseconds(100));
  (void)rig.hear(frame(0x1CECFF21, {32, 210, 0, 30, 255, 0xEB, 0xFE, 0x00}));
  for (int i = 1; i <= 30; ++i) {
    EXPECT_TRUE(rig.answers().empty()) << i;
    (void)rig.run(milliseconds(200));
    (void)rig.hear(frame(0x1CEBFF21, {i, 1, 2, 3, 4, 5, 6, 7}));
  }
  const Answer answer = only_answer();
  EXPECT_EQ(answer.outcome, Outcome::done);
  EXPECT_EQ(answer.size, 210u);
}

TEST_F(NodeTest, ARequestWaitsForAnAnswerNoLongerThanItIsComing) {
  const can::Frame announcement = frame(0x1CECFF21, {32, 210, 0, 30, 255, 0xEB, 0xFE, 0x00});
  ASSERT_EQ(rig.node.submit(request(1, 0xFEEB, kOther), rig.now), Refusal::none);
  (void)rig.pump();
  (void)rig.run(milliseconds(1000));
  (void)rig.hear(announcement);
  (void)rig.run(milliseconds(749));
  EXPECT_TRUE(rig.answers().empty());
  (void)rig.run(milliseconds(1));
  EXPECT_EQ(only_answer().outcome, Outcome::no_answer) << "T1";

  ASSERT_EQ(rig.node.submit(request(2, 0xFEEB, kOther), rig.now), Refusal::none);
  (void)rig.pump();
  (void)rig.hear(announcement);
  for (int i = 0; i < 5; ++i) {
    (void)rig.run(milliseconds(500));
    (void)rig.hear(announcement);
  }
  EXPECT_EQ(only_answer().outcome, Outcome::no_answer) << "who begins again and again does not hold it";

  ASSERT_EQ(rig.node.submit(request(3, 0xFEEB, kOther), rig.now), Refusal::none);
  (void)rig.pump();
  (void)rig.hear(frame(0x1CECFF22, {32, 210, 0, 30, 255, 0xEB, 0xFE, 0x00}));
  (void)rig.hear(frame(0x1CECFF21, {32, 210, 0, 30, 255, 0xEC, 0xFE, 0x00}));
  for (int i = 1; i <= 3; ++i) {
    (void)rig.run(milliseconds(500));
    (void)rig.hear(frame(0x1CEBFF22, {i, 1, 2, 3, 4, 5, 6, 7}));
    (void)rig.hear(frame(0x1CEBFF21, {i, 1, 2, 3, 4, 5, 6, 7}));
  }
  EXPECT_EQ(only_answer().outcome, Outcome::no_answer) << "of another node, of another group";
}

TEST_F(NodeTest, ARequestToAllIsDoneWhenItWasSent) {
  ASSERT_EQ(rig.node.submit(request(1, 0xFEE5, kGlobalAddress), rig.now), Refusal::none);
  EXPECT_EQ(rig.pump(), std::vector{frame(0x18EAFF80, {0xE5, 0xFE, 0x00})});
  EXPECT_EQ(only_answer().outcome, Outcome::done);
}

TEST_F(NodeTest, WithoutAnAddressOnlyTheAddressesOfOthersCanBeAskedFor) {
  NodeSettings listening = settings_at(kOwn);
  listening.claim.preferred.reset();
  NodeRig listener(listening);
  (void)listener.pump();
  EXPECT_EQ(listener.node.submit(request(1, 0xFEE5, kOther), listener.now), Refusal::no_address);
  EXPECT_EQ(listener.node.submit(request(2, 0xEE00, kGlobalAddress), listener.now), Refusal::none);
  EXPECT_EQ(listener.pump(), std::vector{frame(0x18EAFFFE, {0x00, 0xEE, 0x00})});
}

TEST_F(NodeTest, ARequestThatWasOnTheBusIsNotCancelled) {
  ASSERT_EQ(rig.node.submit(request(1, 0xFEEC, 0x21), rig.now), Refusal::none);
  EXPECT_TRUE(rig.node.cancel(1));
  EXPECT_EQ(only_answer().outcome, Outcome::cancelled);
  ASSERT_EQ(rig.node.submit(request(2, 0xFEEC, 0x21), rig.now), Refusal::none);
  (void)rig.pump();
  EXPECT_TRUE(rig.node.cancel(2));
  const Answer answer = only_answer();
  EXPECT_EQ(answer.outcome, Outcome::no_answer) << "the other node may act on it";
  EXPECT_EQ(answer.ended_by, JobEnd::cancelled);
}

}  // namespace
}  // namespace j1939::test
