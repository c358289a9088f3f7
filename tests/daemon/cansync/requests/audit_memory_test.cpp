// What the audit trail says a value was before: never one that the slave may not have any more.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "daemon/cansync/requests/request_audit.h"

namespace cansyncd {
namespace {

using cansync::Outcome;
using cansync::SlaveNumber;

struct NoJournal final : JournalSink {
  void write(LogPriority, EventCode, const std::string&, const std::vector<JournalField>&) override {}
};

struct NoEvents final : EventSink {
  bool publish(const EventText&, SteadyTime) override { return true; }
};

class AuditBefore : public testing::Test {
 protected:
  static cansync::ParameterRequest write(std::uint32_t value) {
    cansync::ParameterRequest request;
    request.slave = slave_;
    request.number = *cansync::ParameterNumber::from(1000);
    request.write = true;
    request.value = value;
    return request;
  }
  void ended(std::uint32_t value, Outcome outcome, std::uint32_t busy_replies = 0) {
    cansync::ParameterResult result;
    result.outcome = outcome;
    result.value = value;
    result.busy_replies = busy_replies;
    audit_.learn(write(value), result);
  }
  std::string before(const Request& request) const {
    return audit_.before(request, cansync::State::active_master);
  }

  static inline const SlaveNumber slave_ = *SlaveNumber::from(3);
  NoJournal journal_;
  NoEvents events_;
  AuditTrail trail_{journal_, events_, "bus", 32};
  RequestAudit audit_{trail_, Config{}};
};

TEST_F(AuditBefore, AWriteThatTheSlaveHasOrMayHaveLeavesNoValueThatWasThereBefore) {
  for (const Outcome outcome : {Outcome::no_answer, Outcome::taken}) {
    ended(1, Outcome::done);
    ASSERT_EQ(before(write(2)), "1");
    ended(2, outcome);
    EXPECT_EQ(before(write(3)), AuditTrail::kNotKnown) << cansync::name(outcome);
  }
  ended(1, Outcome::done);
  ended(2, Outcome::timeout, 4);
  EXPECT_EQ(before(write(3)), AuditTrail::kNotKnown) << "the slave was busy with the value";
}

TEST_F(AuditBefore, AWriteOfWhichNothingWasSentLeavesTheValue) {
  ended(1, Outcome::done);
  for (const Outcome outcome : {Outcome::cancelled, Outcome::master_stopped, Outcome::slave_lost,
                                Outcome::slave_error, Outcome::value_too_wide, Outcome::timeout}) {
    ended(2, outcome);
    EXPECT_EQ(before(write(3)), "1") << cansync::name(outcome);
  }
}

TEST_F(AuditBefore, AControlWordThatMayHaveComeLeavesNoneThatWasThereBefore) {
  const cansync::ControlWordRequest word{1, slave_, 0x0007};
  cansync::BroadcastRequest broadcast;
  broadcast.action = {cansync::SlaveMask::of(slave_), cansync::kCommandControlWord, 0, 0x0006};
  const std::vector<Request> requests = {word, broadcast};
  for (const Request& request : requests) {
    audit_.remember(word, Outcome::done);
    ASSERT_EQ(before(word), "0x0007");
    audit_.remember(request, Outcome::timeout);
    EXPECT_EQ(before(word), "0x0007") << "it was not sent";
    audit_.remember(request, Outcome::no_answer);
    EXPECT_EQ(before(word), AuditTrail::kNotKnown);
  }
}

}  // namespace
}  // namespace cansyncd
