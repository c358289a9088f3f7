// What was kept around a fault as files, and the folder they are in.
#include "daemon/recorder/flight_files.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/syscall.h>
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
#include "daemon/recorder/flight_writer.h"
#include "support/loop_rig.h"

namespace {

using namespace cansyncd;
using namespace cansyncd::test;
using std::chrono::microseconds;
using std::chrono::milliseconds;
namespace fs = std::filesystem;
using Kind = rt::FlightEntry::Kind;

/// Told of each file or folder that is put on the disk.
std::function<void(const std::string& path)> on_sync;

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
  std::size_t files_count() const { return files().size(); }
  static std::string text_of(const fs::path& path) {
    std::ifstream file(path);
    return {std::istreambuf_iterator<char>(file), {}};
  }

  fs::path folder;
};

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

TEST_F(FlightFolder, WhatIsFrequentTakesNoPlaceFromWhatIsRare) {
  FlightRecording recording;
  recording.trigger.reason = static_cast<std::uint32_t>(FlightReason::bus_off);
  EXPECT_EQ(write_flight(recording, settings()).problem, "");
  recording.trigger.reason = static_cast<std::uint32_t>(FlightReason::requested);
  for (int i = 1; i < 6; ++i) {
    recording.trigger.at = milliseconds(i);
    EXPECT_EQ(write_flight(recording, settings()).problem, "");
  }
  const std::string mine = "flight-line_1-19700101T000000.00";
  EXPECT_EQ(files(), (std::vector<std::string>{mine + "0Z-bus_off.json", mine + "0Z-bus_off.log",
                                               mine + "4Z-requested.json", mine + "4Z-requested.log",
                                               mine + "5Z-requested.json", mine + "5Z-requested.log"}));
}

TEST_F(FlightFolder, WhatHasJustBeenWrittenStaysWhateverItsReason) {
  auto few = settings();
  FlightRecording recording;
  for (const unsigned files : {2U, 1U}) {
    few.files = files;
    for (const FlightReason reason :
         {FlightReason::syncs_missed, FlightReason::requested, FlightReason::bus_off}) {
      recording.trigger.reason = static_cast<std::uint32_t>(reason);
      recording.trigger.at += milliseconds(1);
      const FlightFileResult written = write_flight(recording, few);
      EXPECT_TRUE(fs::exists(written.log)) << written.log;
      EXPECT_TRUE(fs::exists(fs::path(written.log).replace_extension(".json"))) << written.log;
    }
    EXPECT_EQ(files_count(), 2 * files);
  }
}

TEST_F(FlightFolder, HalfRecordingsOfAStartBeforeAreRemovedAndNothingElse) {
  const std::string mine = "flight-line_1-19700101T00000";
  const std::vector<std::string> whole = {mine + "1.000Z-bus_off.json", mine + "1.000Z-bus_off.log",
                                          "flight-line_10-19700101T000002.000Z-bus_off.log", "notes.log.new"};
  for (const std::string& name : whole) std::ofstream(folder / name) << "x";
  for (const char* half : {"2.000Z-bus_off.log", "3.000Z-bus_off.log.new", "4.000Z-bus_off.json.new"})
    std::ofstream(folder / (mine + half)) << "x";
  remove_half_recordings(settings());
  EXPECT_EQ(files(), whole);
}

TEST_F(FlightFolder, BothFilesAndTheirFolderAreOnTheDiskBeforeAnOlderOneGoes) {
  auto keep_one = settings();
  keep_one.files = 1;
  FlightRecording recording;
  ASSERT_EQ(write_flight(recording, keep_one).problem, "");
  const auto before = files();
  ASSERT_EQ(before.size(), 2U);
  std::vector<std::string> synced;
  on_sync = [&](const std::string& path) {
    synced.push_back(fs::path(path).filename().string());
    EXPECT_TRUE(fs::exists(folder / before[0]) && fs::exists(folder / before[1])) << path;
  };
  recording.trigger.at = std::chrono::seconds(7);
  EXPECT_EQ(write_flight(recording, keep_one).problem, "");
  on_sync = nullptr;
  const std::string mine = "flight-line_1-19700101T000007.000Z-requested";
  const std::string in = folder.filename().string();
  EXPECT_EQ(synced, (std::vector<std::string>{mine + ".log.new", in, mine + ".json.new", in}));
  EXPECT_EQ(files(), (std::vector<std::string>{mine + ".json", mine + ".log"}));
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
  fs::create_directory(gone.folder);
  const auto later = told_of(gone, 5);
  ASSERT_EQ(later.size(), 1U);
  EXPECT_EQ(later[0].code, "flight_recording") << "the next fault is recorded again";
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

/// In the place of the C library's: what it was asked for is seen.
extern "C" int fsync(int file) {
  std::error_code ignored;
  if (on_sync) on_sync(fs::read_symlink("/proc/self/fd/" + std::to_string(file), ignored).string());
  return static_cast<int>(::syscall(SYS_fsync, file));
}
