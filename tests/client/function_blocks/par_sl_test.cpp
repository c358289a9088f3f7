// CANsync_PAR_SL, sentence by sentence of section 4.13 of the application manual.
#include "client/src/cansync_slave/slave_side.h"
#include "slave_rig.h"

namespace cansync::client::function_blocks {
namespace {

/// Of the sign of presence.
constexpr std::chrono::milliseconds kPresencePeriod{500};

class ParSl : public SlaveBlockTest {
 protected:
  /// The block is enabled and the daemon knows.
  void enable() {
    block.x_EN = true;
    ASSERT_TRUE(call_until(block, [&] { return daemon->parameters.has_value(); })) << block.error();
  }
  void ask_read(std::uint64_t number, std::uint16_t parameter) {
    cansync_slave_ParameterJob job = daemon->job(number, cansync_slave_JOB_ASKED);
    job.parameter = parameter;
    daemon->write(job);
  }
  void ask_write(std::uint64_t number, std::uint16_t parameter, std::uint32_t value, bool doubleword) {
    cansync_slave_ParameterJob job = daemon->job(number, cansync_slave_JOB_ASKED);
    job.parameter = parameter;
    job.write = true;
    job.value = value;
    job.doubleword = doubleword;
    daemon->write(job);
  }
  void end(std::uint64_t number, cansync_slave_JobStep step) { daemon->write(daemon->job(number, step)); }
  /// The newest answer, once there are so many.
  cansync_slave_ApplicationAnswer answer(std::size_t count) {
    EXPECT_TRUE(call_until(block, [&] { return daemon->answers.size() >= count; })) << block.error();
    EXPECT_EQ(daemon->answers.size(), count);
    return daemon->answers.empty() ? cansync_slave_ApplicationAnswer{} : daemon->answers.back().sample;
  }
  PAR_SL block{connection};
};

// "The system only reports parameter jobs and sends answers to the CANsync master when the FB is activated."
TEST_F(ParSl, TakesOverEveryNumberButTheStatusWordWhileItIsEnabled) {
  call_often(block);
  EXPECT_FALSE(daemon->parameters);
  enable();
  EXPECT_EQ(daemon->parameters->size(), 4095u);
  EXPECT_EQ(std::count(daemon->parameters->begin(), daemon->parameters->end(), 301), 0);
  EXPECT_FALSE(block.x_BUSY);
  block.x_EN = false;
  EXPECT_TRUE(call_until(block, [&] { return !daemon->parameters; }));
  // Without a job on its way that is no cancel: no reset is needed.
  enable();
  ask_read(1, 400);
  EXPECT_TRUE(call_until(block, [&] { return block.x_READ; }));
}

TEST_F(ParSl, OrThoseThatItIsGiven) {
  SlaveConnection other = SlaveConnection::connect(options_at(places.there));
  PAR_SL few(other, {400, 4095});
  few.x_EN = true;
  ASSERT_TRUE(call_until(few, [&] { return daemon->parameters.has_value(); }));
  EXPECT_EQ(*daemon->parameters, (std::vector<std::uint16_t>{400, 4095}));
  EXPECT_THROW(PAR_SL(other, {1}), SetupError);
}

// "In the case of a read parameter job, the system indicates the job with x_READ = TRUE and outputs the
// parameter number at u_PAR_NR." "With x_OK_IN = TRUE, the system takes the parameter value and the parameter
// format and sends them to the CANsync master."
TEST_F(ParSl, ReadsAreReportedAnsweredAndFetched) {
  enable();
  ask_read(11, 400);
  ASSERT_TRUE(call_until(block, [&] { return block.x_READ; }));
  EXPECT_EQ(block.u_PAR_NR, 400);
  EXPECT_FALSE(block.x_WRITE || block.x_OK || block.x_RESET_JOB);
  EXPECT_TRUE(block.x_ACTIV && block.x_BUSY);
  call_often(block);
  EXPECT_TRUE(daemon->answers.empty()) << "nothing was given";
  block.ud_PAR_VALUE_READ = 0x12345678;
  block.x_PAR_FORMAT_READ = true;
  block.x_OK_IN = true;
  const auto sent = answer(1);
  EXPECT_EQ(sent.kind, cansync_slave_ANSWER_PARAMETER);
  EXPECT_EQ(sent.job, 11u);
  EXPECT_EQ(sent.error, 0);
  EXPECT_EQ(sent.value, 0x12345678u);
  EXPECT_TRUE(sent.doubleword);
  // "x_BUSY: ... the answer to the CANsync master is ready but the CANsync master has not requested it."
  EXPECT_TRUE(block.x_BUSY && block.x_READ);
  EXPECT_FALSE(block.x_ACTIV || block.x_OK);
  // "x_OK: the CANsync master has fetched the answer."
  end(11, cansync_slave_JOB_ANSWERED);
  ASSERT_TRUE(call_until(block, [&] { return block.x_OK; }));
  EXPECT_FALSE(block.x_BUSY || block.x_READ || block.x_RESET_JOB);
  call_often(block);
  EXPECT_EQ(daemon->answers.size(), 1u) << "x_OK_IN stays, and answers nothing twice";
}

TEST_F(ParSl, ThatGoesGivesItsParametersBack) {
  SlaveConnection other = SlaveConnection::connect(options_at(places.there));
  {
    PAR_SL few(other, {400});
    few.x_EN = true;
    ASSERT_TRUE(call_until(few, [&] { return daemon->parameters.has_value(); }));
  }
  EXPECT_TRUE(repeat_until([&] { daemon->take(); }, [&] { return !daemon->parameters; }));
}

// "x_PAR_FORMAT_READ = FALSE ... WORD format (16-bit)".
TEST_F(ParSl, AWordIsItsSixteenBitsAndWhatIsWiderIsRefused) {
  enable();
  block.ud_PAR_VALUE_READ = 0xFFFFFFFE;  // -2 by way of DINT_TO_UDINT
  block.x_OK_IN = true;
  ask_read(1, 400);
  EXPECT_EQ(answer(1).value, 0xFFFEu);
  end(1, cansync_slave_JOB_ANSWERED);
  ASSERT_TRUE(call_until(block, [&] { return block.x_OK; }));
  block.ud_PAR_VALUE_READ = 0x10000;
  ask_read(2, 400);
  EXPECT_EQ(answer(2).error, 0xFFF9);
}

// "In the case of a write parameter job, the system indicates the job with x_WRITE = TRUE".
TEST_F(ParSl, WritesBringNumberFormatAndValue) {
  enable();
  ask_write(21, 4095, 0x89ABCDEF, true);
  ASSERT_TRUE(call_until(block, [&] { return block.x_WRITE; }));
  EXPECT_EQ(block.u_PAR_NR, 4095);
  EXPECT_TRUE(block.x_PAR_FORMAT_WRITE);
  EXPECT_EQ(block.ud_PAR_VALUE_WRITE, 0x89ABCDEFu);
  EXPECT_FALSE(block.x_READ);
  block.ud_PAR_VALUE_READ = 77;  // means nothing to a write
  block.x_OK_IN = true;
  const auto sent = answer(1);
  EXPECT_EQ(sent.error, 0);
  EXPECT_EQ(sent.value, 0u);
  end(21, cansync_slave_JOB_ANSWERED);
  EXPECT_TRUE(call_until(block, [&] { return block.x_OK && !block.x_WRITE; }));
}

// "it is possible to state an error number at i_ERR and set x_ERR_IN = TRUE." "it does not matter whether the
// answer in question is the error answer".
TEST_F(ParSl, AnErrorGoesToTheMasterAndIsFetchedToo) {
  enable();
  ask_write(1, 400, 5, false);
  block.i_ERR = static_cast<INT>(0xFFFD);
  block.x_ERR_IN = block.x_OK_IN = true;
  EXPECT_EQ(answer(1).error, 0xFFFD);
  end(1, cansync_slave_JOB_ANSWERED);
  ASSERT_TRUE(call_until(block, [&] { return block.x_OK; }));
  block.i_ERR = 0;
  ask_read(2, 400);
  EXPECT_EQ(answer(2).error, 0xFFFF) << "no error would be done";
}

// "The CANsync master can cancel a parameter job. In this case, the system sets output x_RESET_JOB to TRUE."
// "x_RESET_JOB is set back to FALSE when the CANsync master starts a new parameter job."
TEST_F(ParSl, AChangedJobIsShownForACallBeforeTheNewOneComes) {
  enable();
  ask_read(1, 400);
  ASSERT_TRUE(call_until(block, [&] { return block.x_READ; }));
  end(1, cansync_slave_JOB_DROPPED);
  ask_read(2, 500);
  ASSERT_TRUE(call_until(block, [&] { return !block.x_BUSY; }));
  EXPECT_TRUE(block.x_RESET_JOB);
  EXPECT_FALSE(block.x_READ || block.x_ACTIV || block.x_OK);
  EXPECT_EQ(block.u_PAR_NR, 400);
  block.x_OK_IN = true;  // of the job before: it is looked at only after the new one was shown
  block.ud_PAR_VALUE_READ = 40;
  ASSERT_TRUE(call_until(block, [&] { return block.x_READ; }));
  daemon->take();
  EXPECT_TRUE(daemon->answers.empty());
  EXPECT_EQ(block.u_PAR_NR, 500);
  EXPECT_FALSE(block.x_RESET_JOB);
  EXPECT_EQ(answer(1).job, 2u);
}

// "If FB CANsync_PAR_SL is deactivated ... it is assumed that communication was cancelled deliberately and
// you must then reset the FB with x_RESET = TRUE."
TEST_F(ParSl, EnableTakenAwayWhileBusyNeedsAReset) {
  enable();
  ask_read(1, 400);
  ASSERT_TRUE(call_until(block, [&] { return block.x_BUSY; }));
  block.x_EN = false;
  block.call();
  EXPECT_FALSE(block.x_BUSY || block.x_READ || block.x_ACTIV || block.x_OK);
  ASSERT_TRUE(call_until(block, [&] { return !daemon->parameters; }));
  block.x_EN = true;
  call_often(block);
  EXPECT_FALSE(daemon->parameters);
  block.x_RESET = true;
  block.call();
  block.x_RESET = false;
  enable();
}

// The manual's jobs are of values; the daemon may be asked for minimum and maximum too.
TEST_F(ParSl, OtherElementsAreNotAvailable) {
  enable();
  cansync_slave_ParameterJob job = daemon->job(1, cansync_slave_JOB_ASKED);
  job.parameter = 400;
  job.element = 1;
  daemon->write(job);
  EXPECT_EQ(answer(1).error, 0xFFFA);
  EXPECT_FALSE(block.x_BUSY);
}

TEST_F(ParSl, AJobOfADaemonThatHasGoneIsOver) {
  enable();
  ask_read(1, 400);
  ASSERT_TRUE(call_until(block, [&] { return block.x_BUSY; }));
  daemon.reset();
  daemon.emplace(places.here);
  ASSERT_TRUE(call_until(block, [&] { return block.x_RESET_JOB; }));
  EXPECT_FALSE(block.x_BUSY);
  ASSERT_TRUE(call_until(block, [&] { return daemon->parameters.has_value(); })) << "the new one is told";
  ask_read(1, 401);
  ASSERT_TRUE(call_until(block, [&] { return block.x_READ; }));
  EXPECT_EQ(block.u_PAR_NR, 401);
}

/// What a daemon asks before the program knows its writer of jobs is lost, and the master waits in vain.
TEST_F(ParSl, ADaemonIsToldOnlyWhenItsJobsReachTheProgram) {
  daemon.reset();
  daemon.emplace(places.here, FakeSlaveDaemon::WritesJobs::later);
  daemon->status.slave_number = 6;
  daemon->tell();
  ASSERT_TRUE(call_until(block, [&] { return connection.side().status().slave_number == 6; }));
  block.x_EN = true;
  ASSERT_TRUE(call_until(block, [&] { return daemon->hears(); }));
  const auto end = Clock::now() + 3 * kPresencePeriod;
  EXPECT_TRUE(call_until(block, [&] { return Clock::now() >= end; }));
  EXPECT_FALSE(daemon->parameters);
  daemon->write_jobs();
  enable();
}

/// A program and its stand-by both run: the drive is written by the one that the daemon asks.
TEST_F(ParSl, JobsOfAnotherApplicationAreNotShown) {
  enable();
  daemon->name_application(true);
  EXPECT_TRUE(call_until(block, [&] { return block.x_STANDBY; }));
  cansync_slave_ParameterJob others = daemon->given(daemon->job(1, cansync_slave_JOB_ASKED), true);
  others.parameter = 400;
  others.write = true;
  daemon->write(others);
  daemon->write(daemon->given(daemon->job(1, cansync_slave_JOB_ANSWERED), true));
  call_often(block);
  EXPECT_FALSE(block.x_WRITE || block.x_OK || block.x_BUSY);
  daemon->name_application(false);
  EXPECT_TRUE(call_until(block, [&] { return !block.x_STANDBY; }));
  cansync_slave_ParameterJob own = daemon->given(daemon->job(2, cansync_slave_JOB_ASKED), false);
  own.parameter = 401;
  own.write = true;
  daemon->write(own);
  ASSERT_TRUE(call_until(block, [&] { return block.x_WRITE; }));
  EXPECT_EQ(block.u_PAR_NR, 401);
  // The other one takes over: the job is taken away, and the block says so.
  daemon->write(daemon->given(daemon->job(2, cansync_slave_JOB_DROPPED), false));
  EXPECT_TRUE(call_until(block, [&] { return block.x_RESET_JOB; }));
  EXPECT_FALSE(block.x_OK || block.x_WRITE);
}

}  // namespace
}  // namespace cansync::client::function_blocks
