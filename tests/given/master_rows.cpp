// What may be given to a master of CANsync.
#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cstdint>
#include <string>
#include <thread>
#include <utility>
#include <variant>

#include "cansync.h"
#include "cansync/dds/topics.h"
#include "cansync/sim/drive_parameters.h"
#include "daemon/cansync/bus/bus_plan.h"
#include "daemon/cansync/exchange.h"
#include "daemon/cansync/gateway/gateway.h"
#include "daemon/cansync/realtime/realtime_loop.h"
#include "daemon/cansync/segment/load_checked.h"
#include "daemon/cansync/status/gateway_state.h"
#include "paced_bus.h"
#include "row_on.h"
#include "rows.h"
#include "telegrams.h"

namespace given {
namespace {

using std::chrono::milliseconds;

struct MasterParts {
  using File = cansyncd::ConfigFile;
  static File load(const config::Source& source, std::span<const std::string> overrides) {
    return cansyncd::load_checked(source, overrides);
  }
};

class MasterDaemon final : public Daemon {
 public:
  MasterDaemon(const std::string& text, const gateway::dds::ParticipantOptions& place,
               cansyncd::JournalSink& journal, std::uint8_t start)
      : Daemon(start),
        file_(load<MasterParts>(text)),
        participant_(place),
        line_({.bits_per_second = file_.config.bus.bits_per_second},
              std::move(cansyncd::bus_plan(file_.config).sim.nodes)),
        bus_(line_),
        exchange_(cansyncd::ExchangeSizes{}),
        gateway_(file_.config, exchange_, participant_, journal, identity),
        loop_(file_.config.master, loop_settings(), bus_, exchange_) {}
  ~MasterDaemon() override { stop(); }

  void start() override {
    gateway_.start();
    thread_ = std::thread([this] { loop_.run(); });
    bus_.go_on(milliseconds(1));
  }
  void stop() override {
    if (!thread_.joinable()) return;
    loop_.request_stop();
    bus_.let_end();
    thread_.join();
    gateway_.stop();
  }
  void run(can::Time span) override {
    pass_time(*this, span, [this](can::Time until) { bus_.go_on(until); });
  }
  void settle() override { given::settle(gateway_, exchange_); }
  void set_read_only(bool read_only) override { given::set_read_only(gateway_, file_.config, read_only); }
  void reload(const std::string& text) override { gateway_.reload(load<MasterParts>(text).config); }
  DisturbedBus& bus() override { return bus_; }

 private:
  cansyncd::LoopSettings loop_settings() {
    cansyncd::LoopSettings settings = in_virtual_time(cansyncd::LoopSettings{});
    settings.sync_wire = &line_;
    return settings;
  }

  cansyncd::ConfigFile file_;
  gateway::dds::Participant participant_;
  sim::Line line_;
  PacedBus bus_;
  cansyncd::Exchange exchange_;
  cansyncd::Gateway gateway_;
  cansyncd::RealtimeLoop loop_;
  std::thread thread_;
};

const std::string kLine = R"([bus]
interface = "sim"
bit_rate = 1000000
[dds]
request_max_age_ms = 0
[recorder]
folder = ""
[failsafe]
reference_max_age_ms = 0
[startup]
listen_ms = 10
census = false
[sim]
lock_time_ms = 100
[[slave]]
number = 0
[[slave]]
number = 1
)";

/// On the daemon of a master, whose line is in run.
class LineRow : public RowOn {
 public:
  explicit LineRow(const ProtocolUnderTest& protocol) : RowOn(protocol), settles_(protocol.settles) {
    activate();
  }
  void set_running(bool running) override {
    if (!running) return set_mode(cansync_MODE_STOP);
    set_mode(cansync_MODE_SETUP);
    run(milliseconds(500));
    set_mode(cansync_MODE_RUN);
  }
  void restart() override {
    RowOn::restart();
    activate();
  }

 protected:
  /// The telegrams of a kind that stood on the bus: `word(telegram)`, as `frames` has it.
  template <class Telegram, class Word>
  std::string telegrams(Word&& word) {
    return frames([&](const can::Frame& frame) {
      const auto telegram = telegram_of<Telegram>(frame);
      return telegram ? std::string(word(*telegram)) : std::string();
    });
  }

 private:
  void set_mode(cansync_Mode mode) {
    cansync_Command command = {};
    command.kind = cansync_COMMAND_MODE;
    command.mode = mode;
    (void)watcher().ask<cansync_CommandReply>(command);
  }
  /// The line is in run, and every slave is synchronized.
  void activate() {
    bus().concerns = [](const can::Frame& frame) {
      return std::holds_alternative<cansync::Telegram>(cansync::decode(frame)) &&
             !telegram_of<cansync::ReferenceTelegram>(frame);
    };
    for (int i = 0; i < 100 && watcher().newest<cansync_MasterStatus>().slaves_synchronized != 3; ++i)
      run(milliseconds(50));
    EXPECT_EQ(watcher().newest<cansync_MasterStatus>().slaves_synchronized, 3u);
    run(settles_);
  }

  const milliseconds settles_;
};

/// Reference values of telegram 1: value 0 by the first, value 1 by the second.
class References final : public LineRow {
 public:
  using LineRow::LineRow;
  bool is_job() const override { return false; }
  unsigned burst() const override { return 10; }
  /// From now on it gives its values again and again, as programs do.
  void give(Giver giver) override {
    gives_[index(giver)] = true;
    write(giver);
  }
  void end(Giver giver) override {
    gives_[index(giver)] = false;
    cansync_ReferenceValues sample = {};
    sample.telegram = 1;
    sample.given_up = true;
    program(giver).give(sample);
  }
  void restart() override {
    gives_ = {};
    LineRow::restart();
  }
  void kill(Giver giver) override {
    gives_[index(giver)] = false;
    LineRow::kill(giver);
  }
  void each_step() override {
    for (const Giver giver : {Giver::first, Giver::second}) {
      if (gives_[index(giver)]) write(giver);
    }
  }
  std::string on_bus() override {
    return telegrams<cansync::ReferenceTelegram>([](const cansync::ReferenceTelegram& telegram) {
      if (telegram.channel != cansync::Channel::one || telegram.words == 0) return std::string();
      return whose(telegram.word[0], telegram.word[2]);
    });
  }
  std::string told() override {
    // The status tells of another giver after this time.
    std::this_thread::sleep_for(cansyncd::StatePublisher::kGiversPeriod);
    run(milliseconds(10));
    return ownership_word(watcher().newest<cansync_MasterStatus>().reference_release[0]);
  }

 private:
  void write(Giver giver) {
    cansync_ReferenceValues sample = {};
    sample.telegram = 1;
    sample.value[index(giver)] = value_of(giver);
    sample.valid = static_cast<std::uint8_t>(1U << index(giver));
    sample.release_intervals = 50;
    sample.mapping_number = watcher().newest<cansync_MasterStatus>().mapping_number;
    program(giver).give(sample);
  }
  std::array<bool, 2> gives_ = {};
};

/// A write or read of a parameter.
class ParameterJob : public LineRow {
 public:
  ParameterJob(const ProtocolUnderTest& protocol, bool write) : LineRow(protocol), write_(write) {}
  bool is_job() const override { return true; }
  void give(Giver giver) override {
    cansync_ParameterRequest request = {};
    request.write = write_;
    request.slave = 0;
    request.number = kNumber;
    request.element = 7;
    request.format = cansync_FORMAT_WORD;
    request.value = giver == Giver::first ? 1 : 2;
    request.timeout = 2000;
    const std::uint64_t number = program(giver).ask<cansync_ParameterReply>(request);
    if (giver == Giver::first) newest_ = number;
  }
  void end(Giver giver) override { program(giver).cancel(newest_); }
  std::string on_bus() override {
    return telegrams<cansync::ParameterCommand>([&](const cansync::ParameterCommand& command) {
      if (command.number.value() != kNumber) return "";
      if (!write_) return "question";
      return command.value == 1 ? "first" : "second";
    });
  }
  void collect() override { collect_answers<cansync_ParameterReply>(); }

 private:
  static constexpr std::uint32_t kNumber = sim::parameter::first_plain_word;
  const bool write_;
  std::uint64_t newest_ = 0;
};
class Write final : public ParameterJob {
 public:
  explicit Write(const ProtocolUnderTest& protocol) : ParameterJob(protocol, true) {}
};
class Read final : public ParameterJob {
 public:
  explicit Read(const ProtocolUnderTest& protocol) : ParameterJob(protocol, false) {}
};

/// A control word that enables.
class ControlWord final : public LineRow {
 public:
  using LineRow::LineRow;
  bool is_job() const override { return true; }
  void give(Giver giver) override {
    cansync_Command command = {};
    command.kind = cansync_COMMAND_CONTROL_WORD;
    command.slave = 0;
    command.control_word = giver == Giver::first ? 0x000F : 0x001F;
    command.timeout = 2000;
    const std::uint64_t number = program(giver).ask<cansync_CommandReply>(command);
    if (giver == Giver::first) newest_ = number;
  }
  void end(Giver giver) override { program(giver).cancel(newest_); }
  std::string on_bus() override {
    return telegrams<cansync::ActionCommand>([](const cansync::ActionCommand& action) {
      if (action.command != 1) return "";
      return action.data_word == 0x000F ? "first" : "second";
    });
  }
  void collect() override { collect_answers<cansync_CommandReply>(); }

 private:
  std::uint64_t newest_ = 0;
};

/// A download of twelve bytes.
class Download final : public LineRow {
 public:
  using LineRow::LineRow;
  bool is_job() const override { return true; }
  void give(Giver giver) override {
    std::array<std::uint8_t, 12> bytes = {};
    bytes[0] = giver == Giver::first ? 1 : 2;
    cansync_TransferRequest request = {};
    request.direction = cansync_DIRECTION_DOWNLOAD;
    request.address = 0x1000;
    request.length = bytes.size();
    request.timeout = 2000;
    request.data._buffer = bytes.data();
    request.data._length = request.data._maximum = bytes.size();
    const std::uint64_t number = program(giver).ask<cansync_TransferReply>(request);
    if (giver == Giver::first) newest_ = number;
  }
  void end(Giver giver) override { program(giver).cancel(newest_); }
  std::string on_bus() override {
    return telegrams<cansync::DownloadBlock>([](const cansync::DownloadBlock& block) {
      if (block.offset.value() != 0) return "";
      return block.data[0] == 1 ? "first" : "second";
    });
  }
  void collect() override { collect_answers<cansync_TransferReply>(); }

 private:
  std::uint64_t newest_ = 0;
};

}  // namespace

void add_references(Rows& rows, const std::string& name, const ProtocolUnderTest& under_test) {
  rows.add<References>(name, under_test);
}

void add_line_rows(Rows& rows, const std::string& protocol, const ProtocolUnderTest& under_test) {
  add_references(rows, protocol + ".references", under_test);
  rows.add<Write>(protocol + ".write", under_test);
  rows.add<Read>(protocol + ".read", under_test);
  rows.add<ControlWord>(protocol + ".control_word", under_test);
  rows.add<Download>(protocol + ".download", under_test);
}

void add_master_rows(Rows& rows) {
  add_line_rows(rows, "master", {make_daemon<MasterDaemon>, kLine});
}

}  // namespace given
