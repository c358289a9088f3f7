// Parameter jobs of a slave: rows S20, S21 and S22 of docs/cansync-slave.md. Bytes are the manual's.
#include "cansync/slave/parameter_jobs.h"

#include <gtest/gtest.h>

#include <chrono>

#include "service_rig.h"

namespace cansync::test {
namespace {

using ParameterService = ServiceTest;

ParameterAnswer value(std::uint32_t raw, bool doubleword = false) {
  return {false, ParameterError::none, doubleword, raw};
}

TEST_F(ParameterService, S20TheTableAnswersWithoutAnApplication) {
  service_.set_application(false);
  EXPECT_EQ(send(read(400)), response({0x01, 0x90, 7, 0, 0, 0}));
  EXPECT_EQ(send(read(401)), response({0x01, 0x91, 0x78, 0x56, 0x34, 0x12, 0, 0}));
  EXPECT_EQ(send(write_word(400, 100)), response({0x01, 0x90, 0, 0}));
  EXPECT_EQ(send(read(400)), response({0x01, 0x90, 100, 0, 0, 0}));
  EXPECT_EQ(send(command({0x11, 0x90, 0, 0})), response({0x01, 0x90, 100, 0, 0, 0})) << "element 1: maximum";
  EXPECT_EQ(told_.take(), "");
}

TEST_F(ParameterService, S22EveryErrorOfTheTable) {
  EXPECT_EQ(send(write_word(400, 101)), error(400, 0xFFFD));
  EXPECT_EQ(send(write_word(401, 1)), error(401, 0xFFFC));
  EXPECT_EQ(send(read(399)), error(399, 0xFFFB));
  EXPECT_EQ(send(read(4095)), error(4095, 0xFFFB));
  EXPECT_EQ(send(write_word(399, 1)), error(399, 0xFFFB));
  EXPECT_EQ(send(read(402)), error(402, 0xFFFA));
  EXPECT_EQ(send(write_word(402, 1)), error(402, 0xFFFA));
  EXPECT_EQ(send(command({0x71, 0x90, 1, 0, 0, 0, 0, 0})), error(400, 0xFFF9)) << "doubleword to a word";
  EXPECT_EQ(send(command({0x71, 0x2D, 1, 0})), response({0x21, 0x2D, 0xFB, 0xFF, 1, 0})) << "sub-slave 1";
  EXPECT_EQ(send(command({0x71, 0x90, 0xFF, 0xFF})), response({0x21, 0x90, 0xFB, 0xFF, 0xFF, 0xFF}));
  EXPECT_EQ(service_.table().value(400), 7u);
}

TEST_F(ParameterService, S22AWriteThatTheTableRefusesDoesNotReachTheApplication) {
  EXPECT_EQ(send(write_word(501, 11)), error(501, 0xFFFD));
  EXPECT_EQ(send(write_word(501, 0xFFF5)), error(501, 0xFFFE)) << "-11";
  EXPECT_EQ(send(write_word(500, 1)), error(500, 0xFFF9));
  EXPECT_EQ(send(write_word(502, 1)), error(502, 0xFFFC));
  EXPECT_EQ(send(command({0x01, 0xF5, 0, 0})), response({0x01, 0xF5, 0xF6, 0xFF, 0, 0})) << "minimum";
  EXPECT_EQ(told_.take(), "");
  EXPECT_EQ(send(write_word(501, 0xFFF6)), busy(501));
  EXPECT_EQ(told_.take(), "write 501");
  EXPECT_EQ(told_.parameter.value, 0xFFF6u);
}

TEST_F(ParameterService, S20BusyForAsManyQuestionsAsTheApplicationNeeds) {
  for (const unsigned questions : {1u, 2u, 1000u}) {
    for (unsigned i = 0; i < questions; ++i) ASSERT_EQ(send(read(500)), busy(500));
    EXPECT_EQ(told_.take(), "read 500") << "asked once";
    ASSERT_TRUE(service_.jobs().answer(told_.parameter.id, value(questions, true)));
    const auto low = static_cast<std::uint8_t>(questions & 0xFF);
    const auto high = static_cast<std::uint8_t>(questions >> 8);
    EXPECT_EQ(send(read(500)), response({0x01, 0xF4, low, high, 0, 0, 0, 0}));
    EXPECT_EQ(told_.take(), "answered " + std::to_string(told_.parameter.id));
  }
}

TEST_F(ParameterService, S20AnsweredIsSaidWhenItWasOnTheBusAndNotBefore) {
  send(read(500));
  service_.jobs().answer(told_.parameter.id, value(1, true));
  told_.take();
  const auto answer = send(read(500), false);
  EXPECT_EQ(told_.take(), "");
  slave_.sent(*answer);
  EXPECT_EQ(told_.take(), "answered 1");
}

TEST_F(ParameterService, S20AnAnswerThatWasNeverOnTheBusIsToldAsDropped) {
  for (const bool by_table : {false, true}) {
    send(read(500));
    service_.jobs().answer(told_.parameter.id, value(1, true));
    send(read(500), false);
    told_.take();
    send(read(by_table ? 400 : 500));
    EXPECT_EQ(told_.take(), by_table ? "dropped 2" : "dropped 1, read 500");
  }
}

TEST_F(ParameterService, S20ARefusalOfTheSlaveItselfIsNobodysAnswer) {
  send(read(500));
  service_.jobs().answer(told_.parameter.id, value(1, true));
  send(read(500), false);
  told_.take();
  EXPECT_EQ(send(command({0x61, 0x90, 1, 0, 0, 0})), error(400, 0xFFFC));
  EXPECT_EQ(told_.take(), "");
}

TEST_F(ParameterService, S22TheApplicationMayGiveAnyErrorNumber) {
  constexpr std::uint16_t kCodes[] = {0xFFFF, 0xFFFE, 0xFFFA, 0x0001, 0x1234};
  for (const std::uint16_t code : kCodes) {
    send(write_word(501, 3));
    ParameterAnswer refusal;
    refusal.error = static_cast<ParameterError>(code);
    ASSERT_TRUE(service_.jobs().answer(told_.parameter.id, refusal));
    EXPECT_EQ(send(write_word(501, 3)), error(501, code));
  }
}

TEST_F(ParameterService, S21AnotherNumberWhileBusyDropsTheOldJobAndTakesNoAnswerToIt) {
  EXPECT_EQ(send(read(500)), busy(500));
  const std::uint64_t old = told_.parameter.id;
  EXPECT_EQ(send(write_word(501, 3)), busy(501));
  EXPECT_EQ(told_.take(), "read 500, dropped 1, write 501");
  EXPECT_FALSE(service_.jobs().answer(old, value(9, true))) << "the old command must not be answered";
  EXPECT_EQ(send(write_word(501, 3)), busy(501));
  EXPECT_TRUE(service_.jobs().answer(told_.parameter.id, value(0)));
  EXPECT_FALSE(service_.jobs().answer(told_.parameter.id, value(1))) << "one answer";
  EXPECT_EQ(send(write_word(501, 3)), response({0x01, 0xF5, 0, 0}));
  EXPECT_EQ(told_.take(), "answered 2");
}

TEST_F(ParameterService, S21AnotherValueOfTheSameNumberIsAnotherJob) {
  send(write_word(501, 3));
  send(write_word(501, 4));
  EXPECT_EQ(told_.take(), "write 501, dropped 1, write 501");
  EXPECT_EQ(told_.parameter.value, 4u);
}

TEST_F(ParameterService, S21AnAnswerThatWasNotFetchedIsDroppedWithItsJob) {
  send(read(500));
  ASSERT_TRUE(service_.jobs().answer(told_.parameter.id, value(1, true)));
  send(read(400));
  EXPECT_EQ(told_.take(), "read 500, dropped 1");
  EXPECT_EQ(send(read(500)), busy(500)) << "a new job, not the old answer";
  EXPECT_EQ(told_.take(), "read 500");
}

TEST_F(ParameterService, S20WithoutAnApplicationItsNumbersAreNotAvailable) {
  service_.set_application(false);
  EXPECT_EQ(send(read(500)), error(500, 0xFFFA));
  EXPECT_EQ(send(write_word(501, 1)), error(501, 0xFFFA));
  EXPECT_EQ(told_.take(), "");
}

TEST_F(ParameterService, S20AnApplicationThatDiesWhileBusyLeavesNothingOpen) {
  EXPECT_EQ(send(read(500)), busy(500));
  service_.set_application(false);
  EXPECT_EQ(told_.take(), "read 500, dropped 1");
  EXPECT_FALSE(service_.jobs().answer(1, value(1, true)));
  service_.set_application(true);
  EXPECT_EQ(send(read(500)), error(500, 0xFFFA)) << "the job of the one that died";
  EXPECT_EQ(told_.take(), "") << "an answer that no application gave is not reported to one";
  EXPECT_EQ(send(read(500)), busy(500)) << "the new application's";
  EXPECT_EQ(told_.parameter.id, 2u);
}

TEST_F(ParameterService, S20AnAnswerOutlivesItsApplication) {
  send(read(500));
  ASSERT_TRUE(service_.jobs().answer(1, value(5, true)));
  service_.set_application(false);
  EXPECT_EQ(send(read(500)), response({0x01, 0xF4, 5, 0, 0, 0, 0, 0}));
}

/// The master gives up while it is told "busy": nobody fetches the answer, and nothing else is asked.
TEST_F(ParameterService, S20AnAnswerThatNobodyFetchesIsNotTheAnswerToAMuchLaterQuestion) {
  using std::chrono::nanoseconds;
  using std::chrono::seconds;
  send(write_word(501, 3));
  service_.jobs().at(seconds(99));
  service_.jobs().at(seconds(100));
  ASSERT_TRUE(service_.jobs().answer(1, value(0)));
  service_.jobs().at(seconds(101));
  EXPECT_EQ(told_.take(), "write 501") << "a master that still asks gets it";
  service_.jobs().at(seconds(101) + nanoseconds(1));
  EXPECT_EQ(told_.take(), "dropped 1");
  service_.jobs().at(seconds(3700));
  EXPECT_EQ(send(write_word(501, 3)), busy(501)) << "a second write is done, not only confirmed";
  EXPECT_EQ(told_.take(), "write 501");
  EXPECT_EQ(told_.parameter.id, 2u);
}

TEST_F(ParameterService, S20WhatTheSlaveItselfWouldHaveAnsweredIsNotKeptEither) {
  send(read(500));
  service_.set_application(false);
  service_.jobs().at(std::chrono::seconds(10));
  service_.set_application(true);
  EXPECT_EQ(told_.take(), "read 500, dropped 1");
  EXPECT_EQ(send(read(500)), busy(500)) << "the new application's";
  EXPECT_EQ(told_.take(), "read 500");
}

/// The answer was fetched and left out, and the master asks no more.
TEST_F(ParameterService, S20AnAnswerThatWasNeverOnTheBusEndsWithItsTime) {
  using std::chrono::seconds;
  for (const bool write : {false, true}) {
    const can::Frame question = write ? write_word(501, 3) : read(500);
    const std::string asked = write ? "write 501" : "read 500";
    const seconds start(write ? 1000 : 100);
    service_.jobs().at(start);
    send(question);
    ASSERT_TRUE(service_.jobs().answer(told_.parameter.id, value(1, !write)));
    send(question, false);
    service_.jobs().at(start + seconds(1));
    EXPECT_EQ(told_.take(), asked);
    service_.jobs().at(start + seconds(2));
    EXPECT_EQ(told_.take(), "dropped " + std::to_string(told_.parameter.id));
    service_.jobs().at(start + seconds(900));
    EXPECT_EQ(send(question), busy(write ? 501 : 500)) << "a question of its own";
    EXPECT_EQ(told_.take(), asked);
    service_.jobs().dropped();
    told_.take();
  }
}

TEST_F(ParameterService, S20AMasterThatStillAsksForItsWriteGetsTheSameAnswerHoweverLongThatTakes) {
  using std::chrono::seconds;
  service_.jobs().at(seconds(100));
  send(write_word(501, 3));
  ASSERT_TRUE(service_.jobs().answer(1, value(0)));
  for (int second = 100; second < 110; ++second) {
    service_.jobs().at(seconds(second));
    EXPECT_EQ(send(write_word(501, 3), false), response({0x01, 0xF5, 0, 0}));
  }
  EXPECT_EQ(told_.take(), "write 501");
  EXPECT_EQ(send(write_word(501, 3)), response({0x01, 0xF5, 0, 0}));
  EXPECT_EQ(told_.take(), "answered 1");
}

TEST_F(ParameterService, S20AWriteOfTheTableWhoseAnswerWasLostIsOneOfItsOwnLater) {
  using std::chrono::seconds;
  service_.jobs().at(seconds(100));
  EXPECT_EQ(send(write_word(400, 9), false), response({0x01, 0x90, 0, 0}));
  service_.table().set_value(400, 8);
  send(write_word(400, 9), false);
  EXPECT_EQ(service_.table().value(400), 8u) << "not written twice";
  service_.jobs().at(seconds(102));
  send(write_word(400, 9));
  EXPECT_EQ(service_.table().value(400), 9u);
}

TEST_F(ParameterService, S21LeavingSynchronousOperationDropsTheJob) {
  send(read(500));
  EXPECT_TRUE(slave_.control(ControlCommand::cold_restart));
  EXPECT_EQ(told_.take(), "read 500, dropped 1");
  EXPECT_FALSE(service_.jobs().open());
}

TEST_F(ParameterService, S21LeavingSynchronousOperationDropsWhatWasAnsweredAndNotOnTheBus) {
  send(read(500));
  ASSERT_TRUE(service_.jobs().answer(1, value(1, true)));
  send(read(500), false);
  EXPECT_TRUE(slave_.control(ControlCommand::cold_restart));
  EXPECT_EQ(told_.take(), "read 500, dropped 1");
}

class GreedyService : public ServiceTest {
 protected:
  static SlaveServiceSettings settings() {
    SlaveServiceSettings result = service_settings();
    result.jobs = {true, true};
    return result;
  }
  GreedyService() : ServiceTest(settings()) {}
};

TEST_F(GreedyService, S22NumbersOutsideTheTableAndSubSlavesMayBeTheApplications) {
  EXPECT_EQ(send(read(399)), busy(399));
  EXPECT_EQ(send(command({0x71, 0x90, 1, 0})), response({0x41, 0x90})) << "400 of sub-slave 1";
  EXPECT_EQ(told_.parameter.sub_slave.value, 1u);
  EXPECT_EQ(send(command({0x71, 0x90, 0xFF, 0xFF})), response({0x41, 0x90}));
  EXPECT_EQ(told_.parameter.sub_slave.value, 65535u);
  ASSERT_TRUE(service_.jobs().answer(told_.parameter.id, value(3)));
  EXPECT_EQ(send(command({0x71, 0x90, 0xFF, 0xFF})), response({0x01, 0x90, 3, 0, 0xFF, 0xFF}));
  EXPECT_EQ(send(read(400)), response({0x01, 0x90, 7, 0, 0, 0})) << "the slave's own";
}

/// Numbers of the table, and others, that an application takes over while it is there.
class TakingService : public ServiceTest {
 protected:
  static SlaveServiceSettings settings() {
    SlaveServiceSettings result = service_settings();
    result.parameters.push_back({403, false, {}, 8, 0, 0, false, false, ParameterError::unspecified});
    result.jobs.unknown = ParameterError::not_available_now;
    result.jobs.answer_time = std::chrono::seconds(5);
    return result;
  }
  TakingService() : ServiceTest(settings()) {
    TakenOver taken;
    taken.numbers.set(400).set(403).set(399);
    service_.jobs().take_over(taken);
  }
};

TEST_F(TakingService, S20NumbersThatAreTakenOverAreAskedForAndOthersAreNot) {
  EXPECT_EQ(send(read(400)), busy(400));
  EXPECT_EQ(send(read(403)), busy(403));
  EXPECT_EQ(send(read(399)), busy(399));
  EXPECT_EQ(send(write_word(400, 101)), error(400, 0xFFFD)) << "limits stay the table's";
  EXPECT_EQ(told_.take(), "read 400, dropped 1, read 403, dropped 2, read 399, dropped 3");
  EXPECT_EQ(send(read(401)), response({0x01, 0x91, 0x78, 0x56, 0x34, 0x12, 0, 0}));
  EXPECT_EQ(send(read(398)), error(398, 0xFFFA));
  EXPECT_EQ(send(write_word(398, 1)), error(398, 0xFFFA));
  EXPECT_EQ(told_.take(), "");
}

TEST_F(TakingService, S20WithoutItsApplicationTheTableAnswersOrTheErrorThatIsConfigured) {
  service_.set_application(false);
  service_.set_application(true);
  EXPECT_EQ(send(read(400)), response({0x01, 0x90, 7, 0, 0, 0})) << "another one has to take it over anew";
  EXPECT_EQ(send(write_word(400, 9)), response({0x01, 0x90, 0, 0}));
  EXPECT_EQ(send(read(403)), error(403, 0xFFFF));
  EXPECT_EQ(send(write_word(403, 1)), error(403, 0xFFFF));
  EXPECT_EQ(send(read(399)), error(399, 0xFFFA));
  EXPECT_EQ(told_.take(), "");
}

TEST_F(TakingService, S20WhatIsOpenWhenItsApplicationGoesEndsAsConfiguredAndAWriteWithAnError) {
  send(read(400));
  service_.set_application(false);
  EXPECT_EQ(told_.take(), "read 400, dropped 1");
  EXPECT_EQ(send(read(400)), response({0x01, 0x90, 7, 0, 0, 0}));
  service_.set_application(true);
  TakenOver taken;
  taken.numbers.set(400).set(403);
  service_.jobs().take_over(taken);
  send(write_word(400, 9));
  service_.set_application(false);
  EXPECT_EQ(send(write_word(400, 9)), error(400, 0xFFFA)) << "nobody knows whether it was taken";
  EXPECT_EQ(send(read(400)), response({0x01, 0x90, 7, 0, 0, 0}));
  service_.set_application(true);
  service_.jobs().take_over(taken);
  send(read(403));
  service_.set_application(false);
  EXPECT_EQ(send(read(403)), error(403, 0xFFFF));
}

TEST_F(TakingService, S20WhatIsOpenEndsWhenItsNumberIsTakenOverNoMore) {
  EXPECT_EQ(send(read(400)), busy(400));
  TakenOver fewer;
  fewer.numbers.set(400);
  service_.jobs().take_over(fewer);
  EXPECT_EQ(send(read(400)), busy(400));
  EXPECT_EQ(told_.take(), "read 400") << "its number stays";
  service_.jobs().take_over({});
  EXPECT_EQ(told_.take(), "dropped 1");
  EXPECT_EQ(send(read(400)), response({0x01, 0x90, 7, 0, 0, 0})) << "the table's";
  service_.jobs().take_over(fewer);
  send(write_word(400, 9));
  service_.jobs().take_over({});
  EXPECT_EQ(send(write_word(400, 9)), error(400, 0xFFFA)) << "nobody knows whether it was taken";
  EXPECT_EQ(told_.take(), "write 400, dropped 2");
}

TEST_F(TakingService, S20WhatIsAnsweredStaysSoWhenItsNumberIsTakenOverNoMore) {
  send(read(400));
  ASSERT_TRUE(service_.jobs().answer(1, value(3)));
  service_.jobs().take_over({});
  EXPECT_EQ(send(read(400)), response({0x01, 0x90, 3, 0, 0, 0}));
  EXPECT_EQ(told_.take(), "read 400, answered 1");
}

TEST_F(TakingService, S20WhatIsOpenWhenItsApplicationGoesIsAnsweredAsWithoutIt) {
  SlaveServiceSettings unknown = settings();
  unknown.jobs.unknown = ParameterError::not_present;
  for (const bool sub_slave : {false, true}) {
    ServiceRecord told;
    SlaveService service(unknown, told);
    Slave slave(slave_settings(), service);
    for (const auto command : {ControlCommand::handshake, ControlCommand::take_over_initialisation,
                               ControlCommand::start_synchronous})
      EXPECT_TRUE(slave.control(command));
    const can::Frame question = sub_slave ? command({0x71, 0x90, 1, 0}) : read(399);
    const can::Frame without = sub_slave ? response({0x21, 0x90, 0xFB, 0xFF, 1, 0}) : error(399, 0xFFFB);
    const auto ask = [&] { return slave.receive(question, std::chrono::microseconds(400))->frame; };
    EXPECT_EQ(ask(), without);
    service.set_application(true);
    TakenOver taken;
    taken.numbers.set(399);
    taken.sub_slaves = true;
    service.jobs().take_over(taken);
    EXPECT_EQ(ask(), sub_slave ? response({0x41, 0x90}) : busy(399));
    service.set_application(false);
    EXPECT_EQ(ask(), without);
  }
}

TEST_F(TakingService, S20AnApplicationThatIsSilentForTheAnswerTimeIsWaitedForNoLonger) {
  service_.jobs().at(std::chrono::seconds(100));
  EXPECT_EQ(send(read(400)), busy(400));
  service_.jobs().at(std::chrono::seconds(105));
  EXPECT_EQ(send(read(400)), busy(400));
  EXPECT_EQ(told_.take(), "read 400");
  service_.jobs().at(std::chrono::seconds(105) + std::chrono::nanoseconds(1));
  EXPECT_EQ(told_.take(), "dropped 1") << "once";
  service_.jobs().at(std::chrono::seconds(106));
  EXPECT_FALSE(service_.jobs().answer(1, value(3)));
  EXPECT_EQ(send(read(400)), response({0x01, 0x90, 7, 0, 0, 0}));
  EXPECT_EQ(told_.take(), "") << "not its answer";
  EXPECT_EQ(send(read(400)), busy(400)) << "it is asked again for the next";
  EXPECT_EQ(told_.take(), "read 400");
}

TEST_F(TakingService, S20AnAnswerThatNobodyFetchesIsKeptForTheAnswerTime) {
  using std::chrono::nanoseconds;
  using std::chrono::seconds;
  service_.jobs().at(seconds(100));
  send(read(400));
  service_.jobs().at(seconds(103));
  ASSERT_TRUE(service_.jobs().answer(1, value(3)));
  service_.jobs().at(seconds(108));
  EXPECT_EQ(told_.take(), "read 400");
  service_.jobs().at(seconds(108) + nanoseconds(1));
  EXPECT_EQ(told_.take(), "dropped 1");
  EXPECT_EQ(send(read(400)), busy(400)) << "its value now, not the one of then";
  EXPECT_EQ(told_.take(), "read 400");
}

}  // namespace
}  // namespace cansync::test
