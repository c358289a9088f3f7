// The C face of a slave's application: what nobody takes stays bounded, and an answer is for the job that was asked.
#include <cansync/cansync_c_slave.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "slave_rig.h"
#include "support/heap.h"

namespace cansync::client::function_blocks {
namespace {

using Handle = std::unique_ptr<cansync_application, void (*)(cansync_application*)>;

class SlaveCFace : public ::testing::Test {
 protected:
  SlaveCFace() {
    const std::string bus = place.partition;
    cansync_options options = {};
    options.domain = place.domain;
    options.bus = bus.c_str();
    options.wait_ms = 60'000;
    EXPECT_EQ(cansync_application_connect(handle.get(), &options), CANSYNC_DONE)
        << cansync_application_last_error(handle.get());
  }

  /// The next event, if any has come; the daemon listens meanwhile.
  std::optional<cansync_slave_event> receive() {
    cansync_slave_event event = {};
    const int result = cansync_application_receive(handle.get(), 1, &event);
    daemon->take();
    return result == CANSYNC_DONE ? std::optional(event) : std::nullopt;
  }
  /// The next question about a parameter.
  cansync_slave_event asked(std::uint64_t number, std::uint16_t parameter) {
    cansync_slave_ParameterJob job = daemon->job(number, cansync_slave_JOB_ASKED);
    job.parameter = parameter;
    cansync_slave_event question = {};
    EXPECT_TRUE(repeat_until(
        [&] {
          if (daemon->hears()) daemon->write(job);
          if (const auto event = receive(); event && event->kind == CANSYNC_SLAVE_PARAMETER)
            question = *event;
        },
        [&] { return question.number == parameter; }));
    return question;
  }
  bool taken_over() {
    return repeat_until([&] { (void)receive(); }, [&] { return daemon->parameters.has_value(); });
  }

  TwoPlaces places;
  gateway::dds::ParticipantOptions place = places.here;
  std::optional<FakeSlaveDaemon> daemon{std::in_place, place};
  Handle handle{cansync_application_new(), cansync_application_free};
};

// CANSYNC_SLOW_EVENTS: so many; of one a millisecond a day has 86400000.
TEST_F(SlaveCFace, OfEventsThatNobodyTakesTheNewest1000AreKeptAlsoAfterACommand) {
  const char* given = std::getenv("CANSYNC_SLOW_EVENTS");  // NOLINT(concurrency-mt-unsafe): one thread
  const std::uint32_t many =
      given == nullptr ? 4000 : static_cast<std::uint32_t>(std::strtoul(given, nullptr, 10));
  std::uint32_t sent = 0;
  const auto send = [&] {
    for (std::uint8_t other = 8; other < 18; ++other) {
      ++sent;
      daemon->monitored(other, 1, sent, sent);
    }
  };
  const auto fill = [&](std::uint32_t until) {
    while (sent < until) {
      send();
      (void)receive();
    }
  };
  fill(2000);
  // Also while a command waits for its reply, which nobody gives here.
  std::atomic<bool> replied = false;
  std::thread beside([&] {
    while (!replied) {
      send();
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  });
  EXPECT_EQ(cansync_application_set_mode(handle.get(), 2), CANSYNC_NO_REPLY);
  replied = true;
  beside.join();
  fill(sent + 4000);
  const std::size_t before = cansyncd::support::heap_in_use();
  fill(sent + many - 4000);
  const std::size_t after = cansyncd::support::heap_in_use();
  if (given != nullptr) std::printf("%u events: %zu -> %zu KiB of heap\n", sent, before / 1024, after / 1024);
  EXPECT_LE(after, before + (std::size_t{1} << 20));
  std::size_t kept = 0;
  std::uint32_t last = 0;
  // Those on their way come while the others are taken; without a bound there were 3600 more at least.
  EXPECT_TRUE(repeat_until(
      [&] {
        const auto event = receive();
        if (!event) return;
        ++kept;
        last = static_cast<std::uint32_t>(event->values[0]);
      },
      [&] { return last == sent; }))
      << "the newest are kept: " << last << " of " << sent;
  EXPECT_LE(kept, 2000u);
  EXPECT_GE(kept, 900u);
}

TEST_F(SlaveCFace, AnAnswerToTheStartBeforeIsNotGivenToAJobOfTheNewOne) {
  const std::uint16_t numbers[] = {400, 401};
  ASSERT_EQ(cansync_application_take_over(handle.get(), numbers, 2, 0, 0, 0), CANSYNC_DONE);
  ASSERT_TRUE(taken_over());
  const cansync_slave_event old = asked(1, 400);
  daemon.emplace(place);
  ASSERT_TRUE(taken_over());
  const cansync_slave_event now = asked(1, 401);
  EXPECT_NE(old.job, now.job) << "each start numbers its own from 1";
  EXPECT_EQ(cansync_application_answer(handle.get(), old.job, 111, 0), CANSYNC_DONE)
      << "nobody wants it any more";
  EXPECT_EQ(cansync_application_answer(handle.get(), now.job, 222, 0), CANSYNC_DONE);
  EXPECT_TRUE(repeat_until([&] { (void)receive(); }, [&] { return !daemon->answers.empty(); }));
  ASSERT_EQ(daemon->answers.size(), 1u);
  EXPECT_EQ(daemon->answers[0].sample.value, 222u);
}

TEST_F(SlaveCFace, AJobThatAnotherApplicationIsAskedIsNotToldToOneThatStandsBy) {
  const std::uint16_t numbers[] = {400, 401};
  ASSERT_EQ(cansync_application_take_over(handle.get(), numbers, 2, 0, 1, 0), CANSYNC_DONE);
  ASSERT_TRUE(taken_over());
  cansync_slave_ParameterJob of_another = daemon->job(1, cansync_slave_JOB_ASKED);
  of_another.parameter = 400;
  std::fill(std::begin(of_another.application), std::end(of_another.application), std::uint8_t{0xEE});
  cansync_slave_ParameterJob own = daemon->job(2, cansync_slave_JOB_ASKED);
  own.parameter = 401;
  std::vector<unsigned> told;
  const auto look = [&] {
    if (const auto event = receive(); event && event->kind == CANSYNC_SLAVE_PARAMETER)
      told.push_back(event->number);
  };
  ASSERT_TRUE(repeat_until(look, [&] { return daemon->hears(); }));
  daemon->write(of_another);
  daemon->write(own);
  EXPECT_TRUE(repeat_until(look, [&] { return !told.empty() && told.back() == 401; }));
  EXPECT_EQ(std::count(told.begin(), told.end(), 400u), 0);
  EXPECT_EQ(cansync_application_answer(handle.get(), 2, 1, 0), CANSYNC_INVALID) << "its own is the first";
}

// An answer that does not fit the telegram would be another one.
TEST_F(SlaveCFace, AnAnswerThatWouldSayAnotherThingIsRefused) {
  const std::uint16_t numbers[] = {400};
  ASSERT_EQ(cansync_application_take_over(handle.get(), numbers, 1, 0, 1, 0), CANSYNC_DONE);
  ASSERT_TRUE(taken_over());
  const std::uint64_t read = asked(1, 400).job;
  EXPECT_EQ(cansync_application_answer(handle.get(), read, 100'000, 0), CANSYNC_INVALID);
  EXPECT_STREQ(cansync_application_last_error(handle.get()),
               "client: value 100000: wider than a word; allowed -32768..65535, or give it as a doubleword");
  EXPECT_EQ(cansync_application_refuse(handle.get(), read, 0), CANSYNC_INVALID) << "0 would be done";
  EXPECT_EQ(cansync_application_answer(handle.get(), read, static_cast<std::uint32_t>(-5), 0), CANSYNC_DONE);

  std::uint64_t block = 0;
  ASSERT_TRUE(repeat_until(
      [&] {
        daemon->write(daemon->block(1, cansync_slave_BLOCK_BEGUN));
        if (const auto event = receive(); event && event->kind == CANSYNC_SLAVE_BLOCK) block = event->job;
      },
      [&] { return block != 0; }));
  const std::vector<std::uint8_t> data(301, 7);
  EXPECT_EQ(cansync_application_allow_block(handle.get(), block, data.data(), data.size(), 0),
            CANSYNC_INVALID);
  EXPECT_EQ(cansync_application_step_block(handle.get(), block, data.data(), data.size()), CANSYNC_INVALID);
  EXPECT_EQ(cansync_application_refuse_block(handle.get(), block, 0xFF), CANSYNC_INVALID);
  EXPECT_STREQ(cansync_application_last_error(handle.get()), "client: error 255: allowed 256..65535");
  EXPECT_EQ(cansync_application_allow_block(handle.get(), block, data.data(), 300, 0), CANSYNC_DONE);
  EXPECT_TRUE(repeat_until([&] { (void)receive(); }, [&] { return daemon->answers.size() == 2; }));
  EXPECT_EQ(daemon->answers.at(0).sample.value, 0xFFFBu);
  EXPECT_EQ(daemon->answers.at(1).data.size(), 300u);
}

TEST_F(SlaveCFace, WhoOnlyReleasesHearsOfAnotherWriterOfARestartAndOfTheEnd) {
  const std::int32_t raw[4] = {1, 2, 3, 4};
  int result = CANSYNC_DONE;
  const auto release = [&] {
    result = cansync_application_release(handle.get(), 1, raw, 0x0F, 2);
    if (daemon) daemon->take();
  };
  ASSERT_TRUE(repeat_until(release, [&] { return !daemon->releases.empty(); }));
  EXPECT_EQ(result, CANSYNC_DONE);
  cansync_slave_Ownership& owner = daemon->status.actual_ownership[0];
  std::snprintf(owner.writer, sizeof(owner.writer), "another");
  owner.strength = 5;
  owner.writer_guid[0] = 0xEE;
  daemon->tell();
  ASSERT_TRUE(repeat_until(release, [&] { return result == CANSYNC_REFUSED; }));
  EXPECT_NE(std::string(cansync_application_last_error(handle.get())).find("another"), std::string::npos);
  daemon.emplace(place);
  ASSERT_TRUE(repeat_until(release, [&] { return result == CANSYNC_TAKE_UP; }));
  EXPECT_TRUE(daemon->releases.empty());
  daemon.reset();
  ASSERT_TRUE(repeat_until(release, [&] { return result == CANSYNC_NO_DAEMON; }));
  EXPECT_EQ(cansync_application_set_mode(handle.get(), 2), CANSYNC_NO_DAEMON);
}

}  // namespace
}  // namespace cansync::client::function_blocks
