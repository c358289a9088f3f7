// What may be given to a master of CANsync.
#include <array>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <variant>

#include "cansync.h"
#include "cansync/dds/topics.h"
#include "cansync/sim/drive_parameters.h"
#include "cansync/telegram/telegram.h"
#include "daemon/cansync/bus/bus_plan.h"
#include "daemon/cansync/exchange.h"
#include "daemon/cansync/gateway/gateway.h"
#include "daemon/cansync/realtime/realtime_loop.h"
#include "daemon/cansync/segment/load_checked.h"
#include "daemon/cansync/status/gateway_state.h"
#include "row_on.h"
#include "rows.h"

namespace given {
namespace {

using std::chrono::milliseconds;

/// A bus whose time goes on as far as the test lets it; the loop on it has a thread of its own.
class PacedBus final : public DisturbedBus {
 public:
  using DisturbedBus::DisturbedBus;

  can::Wake wait_until(can::Time deadline) noexcept override {
    std::unique_lock lock(mutex_);
    while (deadline > limit_) {
      if (behind_.now() < limit_) {
        const can::Wake wake = behind_.wait_until(limit_);
        if (wake == can::Wake::frame) return wake;
      }
      parked_ = true;
      changed_.notify_all();
      changed_.wait(lock, [&] { return !parked_; });
    }
    return behind_.wait_until(deadline);
  }
  /// Time goes on to `limit`; returns when it stands there.
  void go_on(can::Time limit) {
    std::unique_lock lock(mutex_);
    limit_ = limit;
    parked_ = false;
    changed_.notify_all();
    changed_.wait(lock, [&] { return parked_; });
  }
  /// Time stands no more.
  void let_end() {
    const std::lock_guard lock(mutex_);
    limit_ = can::Time::max();
    parked_ = false;
    changed_.notify_all();
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  can::Time limit_{0};
  bool parked_ = false;
};

struct MasterParts {
  using File = cansyncd::ConfigFile;
  static File load(const config::Source& source, std::span<const std::string> overrides) {
    return cansyncd::load_checked(source, overrides);
  }
};

/// As `Daemon`, for a loop that runs on a thread.
class MasterDaemon {
 public:
  MasterDaemon(cansyncd::ConfigFile file, const gateway::dds::ParticipantOptions& where,
               cansyncd::JournalSink& journal, std::uint8_t start)
      : file_(std::move(file)),
        identity{0xDA, start},
        participant_(where),
        line_({.bits_per_second = file_.config.bus.bits_per_second},
              std::move(cansyncd::bus_plan(file_.config).sim.nodes)),
        bus(line_),
        exchange(cansyncd::ExchangeSizes{}),
        gateway(file_.config, exchange, participant_, journal, identity),
        loop_(file_.config.master, loop_settings(), bus, exchange) {}
  ~MasterDaemon() { stop(); }

  void start() {
    gateway.start();
    thread_ = std::thread([this] { loop_.run(); });
    bus.go_on(milliseconds(1));
  }
  void stop() {
    if (!thread_.joinable()) return;
    loop_.request_stop();
    bus.let_end();
    thread_.join();
    gateway.stop();
  }
  void run(can::Time span) {
    pass_time(*this, span, [this](can::Time until) { bus.go_on(until); });
  }

 private:
  cansyncd::LoopSettings loop_settings() {
    cansyncd::LoopSettings settings;
    settings.sync_wire = &line_;
    settings.wall_clock = nullptr;
    return settings;
  }

  cansyncd::ConfigFile file_;

 public:
  const cansyncd::DaemonIdentity identity;

 private:
  gateway::dds::Participant participant_;
  sim::Line line_;

 public:
  PacedBus bus;
  cansyncd::Exchange exchange;
  cansyncd::Gateway gateway;

 private:
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

class MasterRow : public RowOn<MasterParts, MasterDaemon> {
 public:
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
  explicit MasterRow(const std::string& changed = {})
      : RowOn(kLine, changed.empty() ? kLine : kLine + changed) {
    activate();
  }

  /// The telegrams of a kind that stood on the bus.
  template <class Telegram, class Word>
  std::string telegrams(Word&& word) {
    return frames([&](const can::Frame& frame) {
      const cansync::Decoded decoded = cansync::decode(frame);
      const auto* telegram = std::get_if<cansync::Telegram>(&decoded);
      const Telegram* one = telegram != nullptr ? std::get_if<Telegram>(telegram) : nullptr;
      return one != nullptr ? std::string(word(*one)) : std::string();
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
    daemon().bus.concerns = [](const can::Frame& frame) {
      const cansync::Decoded decoded = cansync::decode(frame);
      const auto* telegram = std::get_if<cansync::Telegram>(&decoded);
      return telegram != nullptr && !std::holds_alternative<cansync::ReferenceTelegram>(*telegram);
    };
    for (int i = 0; i < 100 && watcher().newest<cansync_MasterStatus>().slaves_synchronized != 3; ++i)
      run(milliseconds(50));
    EXPECT_EQ(watcher().newest<cansync_MasterStatus>().slaves_synchronized, 3u);
  }
};

/// Reference values of telegram 1.
class References final : public MasterRow {
 public:
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
    MasterRow::restart();
  }
  void kill(Giver giver) override {
    gives_[index(giver)] = false;
    MasterRow::kill(giver);
  }
  void each_step() override {
    for (const Giver giver : {Giver::first, Giver::second}) {
      if (gives_[index(giver)]) write(giver);
    }
  }
  std::string on_bus() override {
    return telegrams<cansync::ReferenceTelegram>([](const cansync::ReferenceTelegram& telegram) {
      if (telegram.channel != cansync::Channel::one || telegram.words == 0) return "";
      return telegram.word[0] == 0 ? "zero" : telegram.word[0] == 1 ? "first" : "second";
    });
  }
  std::string told() override {
    // The status tells of another giver after this time.
    std::this_thread::sleep_for(cansyncd::StatePublisher::kGiversPeriod);
    run(milliseconds(10));
    const cansync_ReferenceRelease& release = watcher().newest<cansync_MasterStatus>().reference_release[0];
    if (gateway::dds::text(release.writer) == "") return "nobody has it";
    if (release.strength == 1) return "has it";
    return gateway::dds::text(release.waiting_writer) == "" ? "another has it" : "waits";
  }

 private:
  void write(Giver giver) {
    cansync_ReferenceValues sample = {};
    sample.telegram = 1;
    sample.value[0] = giver == Giver::first ? 1 : 2;
    sample.valid = 1;
    sample.release_intervals = 50;
    sample.mapping_number = watcher().newest<cansync_MasterStatus>().mapping_number;
    program(giver).give(sample);
  }
  std::array<bool, 2> gives_ = {};
};

/// A write or read of a parameter.
class ParameterJob : public MasterRow {
 public:
  explicit ParameterJob(bool write) : write_(write) {}
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
  Write() : ParameterJob(true) {}
};
class Read final : public ParameterJob {
 public:
  Read() : ParameterJob(false) {}
};

/// A control word that enables.
class ControlWord final : public MasterRow {
 public:
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
class Download final : public MasterRow {
 public:
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

void add_master_rows(Rows& rows) {
  rows.add<References>("master.references");
  rows.add<Write>("master.write");
  rows.add<Read>("master.read");
  rows.add<ControlWord>("master.control_word");
  rows.add<Download>("master.download");
}

}  // namespace given
