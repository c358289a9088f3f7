// The flight recorder behind the realtime loop, in virtual time: what is kept around a fault, and its files.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <sstream>
#include <string>
#include <variant>
#include <vector>

#include "can/candump.h"
#include "daemon/cansync/realtime/flight_reports.h"
#include "daemon/loop/flight_tap.h"
#include "daemon/recorder/flight_desk.h"
#include "daemon/recorder/flight_files.h"
#include "daemon/recorder/flight_writer.h"
#include "support/loop_rig.h"

namespace {

using namespace cansyncd;
using namespace cansyncd::test;
using std::chrono::microseconds;
using std::chrono::milliseconds;
namespace fs = std::filesystem;
using Kind = rt::FlightEntry::Kind;

/// A folder of the test's own.
class FlightFolder : public testing::Test {
 protected:
  FlightFolder() {
    std::string name = (fs::temp_directory_path() / "cansync_flight_XXXXXX").string();
    folder = ::mkdtemp(name.data());
  }
  ~FlightFolder() override {
    std::error_code ignored;
    fs::remove_all(folder, ignored);
  }

  FlightFileSettings settings() const {
    return {folder.string(), 3, "line 1", "can0", 1'000'000, flight_protocol(milliseconds(1))};
  }
  std::vector<std::string> files() const {
    std::vector<std::string> out;
    for (const auto& entry : fs::directory_iterator(folder)) out.push_back(entry.path().filename().string());
    std::sort(out.begin(), out.end());
    return out;
  }
  static std::string text_of(const fs::path& path) {
    std::ifstream file(path);
    return {std::istreambuf_iterator<char>(file), {}};
  }

  fs::path folder;
};

/// The loop on its scripted bus, with a recorder between. The wall clock is one hour ahead of the bus's.
class Flight {
 public:
  explicit Flight(std::size_t entries, std::uint64_t after, const FlightTriggers& triggers = {})
      : recorder(entries, after),
        tap(recorder, triggers),
        rig(with(&tap)),
        bus(rig.bus, tap),
        loop(master_settings(3), wired(with(&tap), rig.bus), bus, rig.exchange) {}

  static LoopSettings with(FlightTap* tap) {
    LoopSettings settings = virtual_time();
    settings.epoch = std::chrono::hours(1);
    settings.tap = tap;
    return settings;
  }

  /// Runs until SYNC number `n`, with reference values from the 20th on.
  void run_until(unsigned n) {
    cansync::ReferenceUpdate update;
    update.value = {1, 2, 3, 4};
    update.valid_mask = 0x0F;
    update.release_intervals = 500;
    rig.push_at(20, update);
    rig.at(n, can::Time{0}, [this] { loop.request_stop(); });
    loop.run();
  }

  FlightRecording recording() {
    EXPECT_TRUE(recorder.wait_frozen(milliseconds(0)));
    return {recorder.trigger(), recorder.entries(), recorder.take_further()};
  }

  rt::FlightRecorder recorder;
  FlightTap tap;
  LoopRig rig;
  RecordedBus bus;
  RealtimeLoop loop;
};

std::vector<rt::FlightEntry> of_kind(const FlightRecording& recording, Kind kind) {
  std::vector<rt::FlightEntry> out;
  std::copy_if(recording.entries.begin(), recording.entries.end(), std::back_inserter(out),
               [kind](const rt::FlightEntry& entry) { return entry.kind == kind; });
  return out;
}

TEST(Flight, WhatSurroundsSkippedEdgesIsExact) {
  Flight flight(4096, 3);
  // The thread sleeps 20 intervals too long at SYNC 100.
  const can::Time late_edge = flight.rig.first_sync() + 100 * flight.rig.interval;
  flight.rig.bus.lateness = [&](can::Time deadline) {
    return deadline == late_edge ? 20 * flight.rig.interval + microseconds(7) : can::Time{0};
  };
  flight.run_until(200);
  const FlightRecording recording = flight.recording();
  EXPECT_EQ(recording.trigger.reason, static_cast<std::uint32_t>(FlightReason::syncs_missed));
  EXPECT_EQ(recording.trigger.detail, 20U);
  EXPECT_EQ(recording.trigger.interval, 120U);
  EXPECT_EQ(recording.trigger.wall_clock_offset, std::chrono::hours(1));

  const auto wakes = of_kind(recording, Kind::wake);
  const auto late = std::find_if(wakes.begin(), wakes.end(),
                                 [&](const rt::FlightEntry& entry) { return entry.due == late_edge; });
  ASSERT_NE(late, wakes.end());
  EXPECT_EQ(late->at - late->due, 20 * flight.rig.interval + microseconds(7));
  // Every other wake-up came when it was due: WRC1, WRC2, CC and the edge of each interval.
  EXPECT_EQ(
      std::count_if(wakes.begin(), wakes.end(), [](const auto& entry) { return entry.at != entry.due; }), 1);

  const auto edges = of_kind(recording, Kind::edge);
  ASSERT_FALSE(edges.empty());
  // Edge 99, none until 120, then the three intervals after the fault up to the edge that ends them.
  std::vector<long> numbers;
  numbers.reserve(edges.size());
  for (const auto& entry : edges)
    numbers.push_back((entry.due - flight.rig.first_sync()) / flight.rig.interval);
  const auto at_99 = std::find(numbers.begin(), numbers.end(), 99);
  ASSERT_NE(at_99, numbers.end());
  EXPECT_EQ(std::vector<long>(at_99, numbers.end()), (std::vector<long>{99, 120, 121, 122, 123, 124}));
}

TEST(Flight, EveryFrameOfTheBusIsKept) {
  Flight flight(65536, 0);
  flight.rig.at(150, can::Time{0}, [&] { flight.recorder.request(); });
  flight.run_until(160);
  const FlightRecording recording = flight.recording();
  EXPECT_EQ(recording.trigger.reason, static_cast<std::uint32_t>(FlightReason::requested));
  EXPECT_TRUE(flight.recorder.trigger().interval == 150 || flight.recorder.trigger().interval == 151);
  // The bus's own account of what was handed to it, up to where the recording ends.
  std::vector<can::Frame> handed;
  for (const auto& sent : flight.rig.bus.sent) {
    if (sent.at < recording.trigger.at) handed.push_back(sent.frame);
  }
  const auto sent = of_kind(recording, Kind::sent);
  ASSERT_EQ(sent.size(), handed.size());
  for (std::size_t i = 0; i < sent.size(); ++i) EXPECT_EQ(sent[i].frame, handed[i]) << i;
  EXPECT_GT(of_kind(recording, Kind::received).size(), 100U);
  const auto states = of_kind(recording, Kind::state);
  ASSERT_FALSE(states.empty());
  EXPECT_EQ(states.back().value, static_cast<std::uint32_t>(cansync::State::active_master));
}

TEST(Flight, ATelegramThatIsTooLateStandsInItAsLeftOut) {
  Flight flight(65536, 2);
  flight.rig.at(100, can::Time{0}, [&] { flight.rig.bus.send_result = can::SendResult::queue_full; });
  flight.run_until(120);
  const FlightRecording recording = flight.recording();
  EXPECT_EQ(recording.trigger.reason, static_cast<std::uint32_t>(FlightReason::sending_failed));
  const auto left_out = of_kind(recording, Kind::left_out);
  ASSERT_FALSE(left_out.empty());
  const auto sent = of_kind(recording, Kind::sent);
  ASSERT_FALSE(sent.empty());
  EXPECT_EQ(sent.back().value, static_cast<std::uint32_t>(can::SendResult::queue_full));
}

TEST(Flight, OnlyTheFaultsThatAreWantedAreRecorded) {
  FlightTriggers none{false, 0, false, false, false};
  Flight flight(1024, 0, none);
  flight.rig.at(100, can::Time{0}, [&] { flight.rig.bus.send_result = can::SendResult::queue_full; });
  const can::Time late_edge = flight.rig.first_sync() + 110 * flight.rig.interval;
  flight.rig.bus.lateness = [&](can::Time deadline) {
    return deadline == late_edge ? 50 * flight.rig.interval : can::Time{0};
  };
  flight.run_until(300);
  EXPECT_FALSE(flight.recorder.wait_frozen(milliseconds(0)));
}

TEST_F(FlightFolder, TheLogIsCandumpTextInTheOrderOfItsTimes) {
  FlightRecording recording;
  recording.trigger = {static_cast<std::uint32_t>(FlightReason::bus_off), 0, 7, milliseconds(20),
                       std::chrono::seconds(1'700'000'000)};
  const auto add = [&](Kind kind, int at_us, int due_us, const can::Frame& frame = {},
                       std::uint32_t value = 0) {
    recording.entries.push_back({kind, value, 7, microseconds(at_us), microseconds(due_us), frame});
  };
  const can::Frame wrc{.id = 0x103, .dlc = 2, .data = {0x12, 0x34}};
  const can::Frame rdc{.id = 0x303, .dlc = 1, .data = {0xAB}};
  add(Kind::wake, 12, 0);
  add(Kind::edge, 15, 0);
  add(Kind::sent, 300, 300, wrc, static_cast<std::uint32_t>(can::SendResult::queued));
  add(Kind::received, 700, 700, rdc);
  add(Kind::echo, 411, 411, wrc);
  add(Kind::left_out, 900, 900, {}, static_cast<std::uint32_t>(cansync::Slot::command));
  add(Kind::controller, 950, 950, {}, static_cast<std::uint32_t>(can::ControllerState::bus_off));
  recording.further_faults = 2;

  const FlightFileResult result = write_flight(recording, settings());
  EXPECT_EQ(result.problem, "");
  EXPECT_EQ(result.frames, 2U);
  const std::string stem = "flight-line_1-20231114T221320.020Z-bus_off";
  EXPECT_EQ(files(), (std::vector<std::string>{stem + ".json", stem + ".log"}));
  EXPECT_EQ(result.log, (folder / (stem + ".log")).string());
  EXPECT_EQ(text_of(result.log),
            "(1700000000.000015) sync 080#\n"
            "(1700000000.000411) can0 103#1234\n"
            "(1700000000.000700) can0 303#AB\n");
  EXPECT_EQ(text_of(folder / (stem + ".json")), R"({
  "format": 1,
  "bus": "line 1",
  "interface": "can0",
  "bit_rate": 1000000,
  "interval_ns": 1000000,
  "reason": "bus_off",
  "detail": 0,
  "fault_interval": 7,
  "fault_time_ns": 1700000000020000000,
  "faults_without_recording": 2,
  "candump": "flight-line_1-20231114T221320.020Z-bus_off.log",
  "frames": 2,
  "states": [
    {"interval": 7, "time_ns": 1700000000000950000, "controller": "bus-off"}],
  "left_out": [
    {"interval": 7, "time_ns": 1700000000000900000, "slot": "CC"}],
  "handed_over": [
    {"interval": 7, "time_ns": 1700000000000300000, "id": 259, "result": "queued"}],
  "sync_edges": [
    {"interval": 7, "due_ns": 1700000000000000000, "actual_ns": 1700000000000015000}],
  "wake_ups": [
    {"interval": 7, "due_ns": 1700000000000000000, "actual_ns": 1700000000000012000}]
}
)");
  std::istringstream lines(text_of(result.log));
  for (std::string line; std::getline(lines, line);) {
    EXPECT_TRUE(std::holds_alternative<can::CandumpLine>(can::parse_candump_line(line))) << line;
  }
}

TEST_F(FlightFolder, KeepsTheNewestRecordingsOfItsBusAndTouchesNothingElse) {
  std::ofstream(folder / "notes.json") << "mine";
  std::ofstream(folder / "flight-other-20000101T000000.000Z-bus_off.json") << "theirs";
  FlightRecording recording;
  for (int i = 0; i < 5; ++i) {
    recording.trigger.at = milliseconds(i);
    EXPECT_EQ(write_flight(recording, settings()).problem, "");
  }
  const std::string mine = "flight-line_1-19700101T000000.00";
  EXPECT_EQ(files(), (std::vector<std::string>{
                         mine + "2Z-requested.json", mine + "2Z-requested.log", mine + "3Z-requested.json",
                         mine + "3Z-requested.log", mine + "4Z-requested.json", mine + "4Z-requested.log",
                         "flight-other-20000101T000000.000Z-bus_off.json", "notes.json"}));
}

/// What a test of many recordings tells them apart by: the seconds of their names.
std::vector<std::string> seconds_of(const std::vector<std::string>& files) {
  std::vector<std::string> out;
  for (const std::string& file : files) {
    if (file.ends_with(".json")) out.push_back(file.substr(file.rfind('T') + 1, 6));
  }
  return out;
}

TEST_F(FlightFolder, ARecordingMadeAfterTheWallClockWasSetBackStays) {
  auto keep_two = settings();
  keep_two.files = 2;
  FlightRecording recording;
  FlightFileResult last;
  for (const int second : {30, 31, 10, 11}) {
    recording.trigger.at = std::chrono::seconds(second);
    last = write_flight(recording, keep_two);
    EXPECT_EQ(last.problem, "");
    EXPECT_TRUE(fs::exists(last.log)) << second;
    EXPECT_TRUE(fs::exists(fs::path(last.log).replace_extension(".json"))) << second;
  }
  EXPECT_EQ(seconds_of(files()), (std::vector<std::string>{"000010", "000011"}));
}

TEST_F(FlightFolder, BusesWhoseNamesBeginAlikeKeepTheirOwn) {
  auto one = settings();
  auto other = settings();
  one.bus = "a";
  other.bus = "a-b";
  one.files = other.files = 1;
  for (const auto& of : {other, one, other}) EXPECT_EQ(write_flight({}, of).problem, "");
  const std::string rest = "-19700101T000000.000Z-requested";
  EXPECT_EQ(files(), (std::vector<std::string>{"flight-a" + rest + ".json", "flight-a" + rest + ".log",
                                               "flight-a-b" + rest + ".json", "flight-a-b" + rest + ".log"}));
}

TEST_F(FlightFolder, NothingIsWrittenThroughALink) {
  const fs::path victim = folder / "victim";
  std::ofstream(victim) << "precious";
  for (const char* ending : {".log", ".json", ".log.part", ".json.part", ".log.new", ".json.new"}) {
    fs::create_symlink(victim,
                       folder / (std::string("flight-line_1-19700101T000000.000Z-requested") + ending));
  }
  EXPECT_EQ(write_flight({}, settings()).problem, "");
  EXPECT_EQ(text_of(victim), "precious");
}

TEST_F(FlightFolder, AFolderInWhichOthersMayReplaceFilesIsRefused) {
  const auto everybody = fs::perms::all;
  fs::permissions(folder, everybody);
  EXPECT_EQ(prepare_flight_folder(folder.string()),
            folder.string() + ": every user may replace files in it; take that right away (chmod o-w)");
  fs::permissions(folder, everybody | fs::perms::sticky_bit);
  EXPECT_EQ(prepare_flight_folder(folder.string()), "");
  if (::geteuid() != 0) return;
  constexpr uid_t kSomebody = 65533;
  ASSERT_EQ(::chown(folder.c_str(), kSomebody, kSomebody), 0);
  EXPECT_EQ(prepare_flight_folder(folder.string()),
            folder.string() + ": belongs to user 65533; allowed: root, or the daemon's own user 0");
}

TEST_F(FlightFolder, AFileIsNoFolder) {
  const std::string file = (folder / "file").string();
  std::ofstream(file) << "mine";
  EXPECT_EQ(prepare_flight_folder(file), file + ": Not a directory");
}

/// A recorder that has frozen `count` frames.
void freeze(rt::FlightRecorder& recorder, unsigned count) {
  rt::FlightEntry entry;
  entry.kind = Kind::received;
  for (unsigned i = 0; i < count; ++i) recorder.record(entry);
  recorder.fault({});
  recorder.begin_interval({});
}

/// What a writer tells of one recording of `frames` frames.
std::vector<EventText> told_of(const FlightFileSettings& settings, unsigned frames) {
  rt::FlightRecorder recorder(frames, 0);
  freeze(recorder, frames);
  std::vector<EventText> told;
  {
    FlightWriter writer(recorder, settings, [&](const EventText& event) { told.push_back(event); });
  }
  freeze(recorder, 1);
  EXPECT_TRUE(recorder.wait_frozen(milliseconds(0))) << "it was armed again";
  EXPECT_EQ(recorder.entries().size(), 1U);
  return told;
}

TEST_F(FlightFolder, TheEventNamesTheFile) {
  const auto told = told_of(settings(), 5);
  ASSERT_EQ(told.size(), 1U);
  EXPECT_EQ(told[0].code, "flight_recording");
  EXPECT_EQ(told[0].severity, gateway_SEVERITY_INFO);
  EXPECT_EQ(told[0].text,
            (folder / "flight-line_1-19700101T000000.000Z-requested.log").string() +
                " (requested, interval 0, 5 frames; 0 faults before have no recording of their own)");
}

TEST_F(FlightFolder, AFolderThatIsGoneIsAnEventAndTheRecorderGoesOn) {
  auto gone = settings();
  gone.folder += "/gone";
  const auto told = told_of(gone, 5);
  ASSERT_EQ(told.size(), 1U);
  EXPECT_EQ(told[0].code, "flight_recording_failed");
  EXPECT_EQ(told[0].severity, gateway_SEVERITY_ERROR);
  EXPECT_NE(told[0].text.find("/gone/flight-line_1-"), std::string::npos) << told[0].text;
  EXPECT_NE(told[0].text.find("No such file or directory"), std::string::npos) << told[0].text;
}

TEST_F(FlightFolder, AFullDiskIsAnEventAndLeavesNoHalfFile) {
  // A limit on the size of files stands for the full disk: writing fails in the middle.
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit small{1000, before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  const auto told = told_of(settings(), 2000);
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &before), 0);
  std::signal(SIGXFSZ, old_handler);
  ASSERT_EQ(told.size(), 1U);
  EXPECT_EQ(told[0].code, "flight_recording_failed");
  EXPECT_NE(told[0].text.find("File too large"), std::string::npos) << told[0].text;
  EXPECT_EQ(files(), std::vector<std::string>{});
}

TEST_F(FlightFolder, TheFolderIsTheConfiguredOneTheServicesOrTheUsualOne) {
  Config config;
  config.bus.name = "press";
  EXPECT_EQ(flight_folder(config, nullptr), "/var/lib/cansync/press");
  EXPECT_EQ(flight_folder(config, "/var/lib/cansync/line2:/elsewhere"), "/var/lib/cansync/line2");
  config.recorder.folder = "";
  EXPECT_EQ(flight_folder(config, "/var/lib/cansync/line2"), "");
  EXPECT_EQ(prepare_flight_folder((folder / "new").string()), "");
  EXPECT_TRUE(fs::is_directory(folder / "new"));
  EXPECT_NE(prepare_flight_folder((folder / "not" / "there").string()), "");
}

TEST_F(FlightFolder, WithoutAFolderTheLoopDrivesTheBusItself) {
  Config config;
  config.recorder.folder = (folder / "not" / "there").string();
  ScriptedBus bus;
  FlightDesk off(config, flight_protocol(milliseconds(1)), bus, [](const EventText&) {});
  EXPECT_EQ(&off.bus(), &bus);
  EXPECT_EQ(off.tap(), nullptr);
  EXPECT_FALSE(off.request());
  config.recorder.folder = folder.string();
  FlightDesk on(config, flight_protocol(milliseconds(1)), bus, [](const EventText&) {});
  EXPECT_NE(&on.bus(), &bus);
  EXPECT_TRUE(on.request());
}

}  // namespace
