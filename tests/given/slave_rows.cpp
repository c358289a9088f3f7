// What may be given to a slave of CANsync.
#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "cansync_slave.h"
#include "cansync_slave/dds/topics.h"
#include "daemon/cansync_slave/segment/slave_segment.h"
#include "row_on.h"
#include "rows.h"
#include "telegrams.h"

namespace given {
namespace {

using std::chrono::milliseconds;

/// The parameter that the master above asks for again and again.
constexpr std::uint16_t kNumber = 777;

const std::string kSlave = R"([bus]
interface = "sim"
protocol = "cansync-slave"
bit_rate = 1000000
[dds]
request_max_age_ms = 0
[recorder]
folder = ""
[slave]
number = 3
missing_references = 0
[[sim.job]]
number = 1
parameter = 777
every = 10
)";

/// On the daemon of a slave, which the master above has synchronized.
class SideRow : public RowOn {
 public:
  explicit SideRow(const ProtocolUnderTest& protocol) : RowOn(protocol) { synchronize(); }
  bool is_job() const override { return false; }
  void end(Giver giver) override { gives_[index(giver)] = false; }
  void kill(Giver giver) override {
    gives_[index(giver)] = false;
    RowOn::kill(giver);
  }
  void set_running(bool running) override {
    if (!running) return set_mode(cansync_slave_SLAVE_MODE_STOP);
    set_mode(cansync_slave_SLAVE_MODE_SETUP);
    run(milliseconds(500));
    set_mode(cansync_slave_SLAVE_MODE_RUN);
  }
  void restart() override {
    gives_ = {};
    RowOn::restart();
    synchronize();
  }

 protected:
  bool gives(Giver giver) const { return gives_[index(giver)]; }
  /// From now on it gives again and again, as programs do.
  void begin(Giver giver) { gives_[index(giver)] = true; }

 private:
  void set_mode(cansync_slave_SlaveMode mode) {
    cansync_slave_SlaveCommand command = {};
    command.kind = cansync_slave_SLAVE_COMMAND_MODE;
    command.mode = mode;
    (void)watcher().ask<cansync_slave_SlaveCommandReply>(command);
  }
  void synchronize() {
    for (int i = 0; i < 100 && !watcher().newest<cansync_slave_SlaveSideStatus>().synchronized; ++i)
      run(milliseconds(50));
    EXPECT_TRUE(watcher().newest<cansync_slave_SlaveSideStatus>().synchronized);
  }

  std::array<bool, 2> gives_ = {};
};

/// Actual values of telegram 1: value 0 by the first, value 1 by the second.
class ActualValues final : public SideRow {
 public:
  using SideRow::SideRow;
  unsigned burst() const override { return 10; }
  void give(Giver giver) override {
    begin(giver);
    release(giver);
  }
  void end(Giver giver) override {
    SideRow::end(giver);
    cansync_slave_ActualRelease sample = {};
    sample.telegram = 1;
    sample.given_up = true;
    program(giver).give(sample);
  }
  void each_step() override {
    for (const Giver giver : {Giver::first, Giver::second}) {
      if (gives(giver)) release(giver);
    }
  }
  std::string on_bus() override {
    return frames([](const can::Frame& frame) {
      const auto telegram = telegram_of<cansync::ActualTelegram>(frame);
      return telegram && telegram->channel == cansync::Channel::one && telegram->words != 0
                 ? whose(telegram->word[0], telegram->word[2])
                 : std::string();
    });
  }
  std::string told() override {
    return ownership_word(watcher().newest<cansync_slave_SlaveSideStatus>().actual_ownership[0]);
  }

 private:
  void release(Giver giver) {
    cansync_slave_ActualRelease sample = {};
    sample.telegram = 1;
    sample.raw[index(giver)] = value_of(giver);
    sample.valid = static_cast<std::uint8_t>(1U << index(giver));
    sample.wait_intervals = 50;
    program(giver).give(sample);
  }
};

/// Answers of an application, which has taken over the parameter that the master asks for.
class Answers final : public SideRow {
 public:
  using SideRow::SideRow;
  void give(Giver giver) override {
    begin(giver);
    say_present(giver);
  }
  void end(Giver giver) override {
    SideRow::end(giver);
    Sample sample = {};
    sample.kind = cansync_slave_ANSWER_GIVEN_UP;
    program(giver).give(sample);
  }
  void each_step() override {
    for (const Giver giver : {Giver::first, Giver::second}) {
      if (!gives(giver)) continue;
      say_present(giver);
      answer(giver);
    }
  }
  std::string on_bus() override {
    return frames([](const can::Frame& frame) {
      const auto reply = telegram_of<cansync::ParameterReply>(frame);
      if (!reply || reply->number.value() != kNumber || reply->busy) return std::string();
      return reply->error ? std::string("an error") : whose(reply->payload[0]);
    });
  }
  std::string told() override {
    const auto& status = watcher().newest<cansync_slave_SlaveSideStatus>();
    if (gateway::dds::text(status.application).empty()) return "nobody has it";
    if (status.application_strength == 1) return "has it";
    return gateway::dds::text(status.waiting_application).empty() ? "another has it" : "waits";
  }

 private:
  using Sample = cansync_slave_ApplicationAnswer;

  void say_present(Giver giver) {
    std::uint16_t number = kNumber;
    Sample sample = {};
    sample.kind = cansync_slave_ANSWER_PRESENT;
    sample.parameters._buffer = &number;
    sample.parameters._length = sample.parameters._maximum = 1;
    program(giver).give(sample);
  }
  void answer(Giver giver) {
    const auto guid = program(giver).guid<Sample>();
    std::vector<std::uint64_t> asked;
    program(giver).take_samples<cansync_slave_ParameterJob>([&](const cansync_slave_ParameterJob& job) {
      const bool is_mine = std::equal(guid.begin(), guid.end(), std::begin(job.application));
      if (is_mine && job.step == cansync_slave_JOB_ASKED) asked.push_back(job.job);
    });
    for (const std::uint64_t job : asked) {
      Sample sample = {};
      sample.kind = cansync_slave_ANSWER_PARAMETER;
      sample.job = job;
      sample.value = value_of(giver);
      program(giver).give(sample);
    }
  }
};

/// A mapping of the actual values: value 1 or 2 is the one word of telegram 1, in the place of value 0. Somebody else
/// gives all of them.
class Mapping final : public SideRow {
 public:
  explicit Mapping(const ProtocolUnderTest& protocol) : SideRow(protocol) {}
  void give(Giver giver) override { map(giver, value_of(giver)); }
  /// There is no end of its own: it maps what the file maps.
  void end(Giver giver) override { map(giver, 0); }
  void each_step() override {
    cansync_slave_ActualRelease sample = {};
    sample.telegram = 1;
    sample.raw[0] = 3;
    sample.raw[1] = 1;
    sample.raw[2] = 2;
    sample.valid = 7;
    sample.wait_intervals = 50;
    watcher().give(sample);
  }
  std::string on_bus() override {
    return frames([](const can::Frame& frame) {
      const auto telegram = telegram_of<cansync::ActualTelegram>(frame);
      if (!telegram || telegram->channel != cansync::Channel::one || telegram->words == 0)
        return std::string();
      return whose(telegram->word[0]);
    });
  }
  void collect() override { collect_answers<cansync_slave_SlaveCommandReply>(); }

 private:
  void map(Giver giver, unsigned value) {
    constexpr std::uint8_t kAssigned = 1;
    cansync_slave_SlaveCommand command = {};
    command.kind = cansync_slave_SLAVE_COMMAND_MAPPING;
    command.actual_mapping[0] = static_cast<std::uint8_t>(kAssigned | value << 2U);
    (void)program(giver).ask<cansync_slave_SlaveCommandReply>(command);
  }
};

}  // namespace

void add_side_rows(Rows& rows, const std::string& protocol, const ProtocolUnderTest& under_test) {
  rows.add<ActualValues>(protocol + ".actual_values", under_test);
  rows.add<Answers>(protocol + ".answers", under_test);
}

void add_slave_rows(Rows& rows) {
  const ProtocolUnderTest slave{make_daemon<DeadlineDaemon<cansyncd::SlaveParts>>, kSlave};
  add_side_rows(rows, "slave", slave);
  rows.add<Mapping>("slave.mapping", slave);
}

}  // namespace given
