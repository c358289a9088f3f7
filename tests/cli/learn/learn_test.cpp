// What `learn` writes: configurations that the daemon takes and that do what was recorded, a line for every
// constant that is not confirmed, files that are never written over.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <sstream>

#include "can/candump.h"
#include "cansync/observe/random_line.h"
#include "cli/app/application.h"
#include "cli/app/command_line.h"
#include "cli/learn/learn_compare.h"
#include "cli/learn/learn_files.h"
#include "cli/learn/learn_points.h"
#include "cli/text/words.h"

namespace cansync::cli {
namespace {

namespace fs = std::filesystem;
using observe::support::Form;
using observe::support::RandomLine;
using observe::support::Recording;

std::string text_of_file(const fs::path& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// A recording as the simulated line writes it. `set_back`: by so much the clock goes back in its middle.
std::string log_of(const Recording& recording, std::chrono::microseconds set_back = {}) {
  std::string out;
  for (std::size_t i = 0; i < recording.entries.size(); ++i) {
    const Recording::Entry& entry = recording.entries[i];
    std::array<char, can::kCandumpLineLimit> line{};
    can::Frame edge;
    edge.id = 0x080;
    const auto time = std::chrono::duration_cast<std::chrono::microseconds>(entry.start) +
                      std::chrono::seconds(10) -
                      (i < recording.entries.size() / 2 ? std::chrono::microseconds(0) : set_back);
    out.append(line.data(), can::write_candump_line(time, entry.frame ? "can7" : "sync",
                                                    entry.frame ? *entry.frame : edge, line));
  }
  return out;
}

class LearnVerb : public ::testing::Test {
 protected:
  LearnVerb() {
    std::string name = (fs::temp_directory_path() / "cansync_learn.XXXXXX").string();
    folder_ = ::mkdtemp(name.data());
    line_ = observe::support::random_line(5, false);
    recording_ = observe::support::record(line_, line_.master);
    log_ = write("line.log", log_of(recording_));
  }
  ~LearnVerb() override { fs::remove_all(folder_); }

  std::string write(const std::string& name, const std::string& text) {
    const fs::path path = folder_ / name;
    fs::create_directories(path.parent_path());
    std::ofstream(path) << text;
    return path.string();
  }

  ExitCode run_verb(std::vector<std::string> words) {
    words.insert(words.begin(), {"cansync", "learn"});
    std::vector<const char*> arguments;
    for (const std::string& word : words) arguments.push_back(word.c_str());
    const fs::path data = folder_ / "data";
    const fs::path remarks = folder_ / "remarks";
    ExitCode code{};
    {
      const std::unique_ptr<std::FILE, int (*)(std::FILE*)> out(std::fopen(data.c_str(), "w"), &std::fclose);
      const std::unique_ptr<std::FILE, int (*)(std::FILE*)> told(std::fopen(remarks.c_str(), "w"),
                                                                 &std::fclose);
      code = run(static_cast<int>(arguments.size()), arguments.data(), out.get(), told.get());
    }
    data_ = text_of_file(data);
    remarks_ = text_of_file(remarks);
    return code;
  }

  fs::path folder_;
  RandomLine line_;
  Recording recording_;
  std::string log_;
  std::string data_;
  std::string remarks_;
};

TEST_F(LearnVerb, TellsWhatWasSeenAsTableAndAsObjects) {
  EXPECT_EQ(run_verb({log_}), ExitCode::done) << remarks_;
  const unsigned command = line_.master.master.startup.activate_command;
  std::istringstream lines(data_);
  std::string line;
  bool activation = false;
  while (std::getline(lines, line))
    activation = activation || (line.starts_with("startup.activate_command ") &&
                                line.find(" " + std::to_string(command) + " ") != std::string::npos &&
                                line.find("seen") != std::string::npos);
  EXPECT_TRUE(activation) << data_;
  EXPECT_EQ(run_verb({log_, "--json"}), ExitCode::done);
  EXPECT_NE(
      data_.find("\"point\":\"startup.activate_command\",\"found\":\"" + std::to_string(command) + "\""),
      std::string::npos)
      << data_.substr(0, 2000);
}

TEST_F(LearnVerb, AClockThatGoesBackIsReportedAndNothingIsDerivedAcrossIt) {
  const auto timing = [this] {
    std::istringstream lines(data_);
    std::string line;
    std::string found;
    while (std::getline(lines, line))
      if (line.starts_with("bus.send_margin_us ") || line.starts_with("bus.bit_rate "))
        found += line.substr(0, 60);
    return found;
  };
  ASSERT_EQ(run_verb({log_}), ExitCode::done) << remarks_;
  const std::string right = timing();
  ASSERT_NE(right, "");
  EXPECT_EQ(remarks_.find("clock"), std::string::npos) << remarks_;
  const std::string back = write("back.log", log_of(recording_, std::chrono::milliseconds(1500)));
  ASSERT_EQ(run_verb({back}), ExitCode::done) << remarks_;
  EXPECT_EQ(timing(), right);
  EXPECT_NE(remarks_.find("the clock goes back by 1.4"), std::string::npos) << remarks_;
  EXPECT_NE(remarks_.find("line "), std::string::npos) << remarks_;
}

TEST_F(LearnVerb, SyncFramesOfAnotherInterfaceAreNoEdges) {
  std::string both;
  for (int i = 0; i < 5000; ++i) {
    both += fmt::format("({}.{:06}) can1 080#\n", 10 + i / 1000, i % 1000 * 1000);
    both += fmt::format("({}.{:06}) can0 101#0100020003000400\n", 10 + i / 1000, i % 1000 * 1000 + 300);
  }
  const std::string log = write("both.log", both);
  EXPECT_EQ(run_verb({log}), ExitCode::usage) << "which of the two is not said";
  EXPECT_EQ(run_verb({log, "--from", "can0"}), ExitCode::done) << remarks_;
  EXPECT_NE((data_ + remarks_).find(" 0 SYNC edges"), std::string::npos) << data_ << remarks_;
}

TEST_F(LearnVerb, WritesAConfigurationThatDiffersInNothing) {
  const std::string out = (folder_ / "learned").string();
  ASSERT_EQ(run_verb({log_, "--write", out}), ExitCode::done) << remarks_;
  EXPECT_NE(remarks_.find("cansyncd --check " + out + "/can7.toml"), std::string::npos) << remarks_;
  EXPECT_EQ(run_verb({log_, "--compare", out + "/can7.toml"}), ExitCode::done) << data_ << remarks_;
  // Another activation is found.
  std::string text = text_of_file(fs::path(out) / "can7.toml");
  const std::size_t at = text.find("activate_command = ");
  ASSERT_NE(at, std::string::npos);
  text.replace(at, text.find('#', at) - at, "activate_command = 200 ");
  EXPECT_EQ(run_verb({log_, "--compare", write("learned/other.toml", text)}), ExitCode::different) << data_;
  EXPECT_NE(data_.find("startup.activate_command"), std::string::npos) << data_;
}

TEST_F(LearnVerb, OfOtherProtocolsNothingIsSaidOrWritten) {
  const std::string out = (folder_ / "learned").string();
  std::string truck;
  for (int i = 0; i < 400; ++i) truck += fmt::format("(1.{:06}) can0 0CF00400#0102030405060708\n", i * 2000);
  EXPECT_EQ(run_verb({write("truck.log", truck), "--write", out}), ExitCode::not_cansync);
  EXPECT_NE(remarks_.find("this does not look like CANsync; it looks like J1939"), std::string::npos)
      << remarks_;
  EXPECT_EQ(data_.find("send_margin"), std::string::npos) << data_;
  EXPECT_FALSE(fs::exists(out));
  std::string edges;
  for (int i = 0; i < 400; ++i) edges += fmt::format("(1.{:06}) can0 080#\n", i * 1000);
  EXPECT_EQ(run_verb({write("edges.log", edges), "--write", out}), ExitCode::not_cansync);
  EXPECT_NE(remarks_.find("SYNC frames alone"), std::string::npos) << remarks_;
  EXPECT_FALSE(fs::exists(out));
}

TEST_F(LearnVerb, WritesNoBitRateThatNothingTells) {
  std::string log;
  for (int i = 0; i < 400; ++i)
    log += fmt::format("(1.{:06}) can0 101#0100020003000400\n(1.{:06}) can0 301#0100020003000400\n",
                       i / 4 * 9000, i / 4 * 9000);
  const std::string bunched = write("bunched.log", log);
  const std::string out = (folder_ / "learned").string();
  EXPECT_EQ(run_verb({bunched, "--write", out}), ExitCode::usage);
  EXPECT_NE(remarks_.find("bunched"), std::string::npos) << remarks_;
  EXPECT_NE(remarks_.find("--bit-rate gives it"), std::string::npos) << remarks_;
  EXPECT_EQ(run_verb({bunched, "--write", out, "--bit-rate", "250000"}), ExitCode::done) << remarks_;
  EXPECT_EQ(settings_of_file(out + "/can0.toml").bit_rate, BitRate::kbit250);
}

TEST_F(LearnVerb, ProposesLimitsOfReferenceValuesAsCommentsThatMayBeSet) {
  const std::string out = (folder_ / "learned").string();
  ASSERT_EQ(run_verb({log_, "--write", out}), ExitCode::done) << remarks_;
  std::istringstream lines(text_of_file(fs::path(out) / "can7.toml"));
  std::string text;
  std::string line;
  bool proposal = false;
  unsigned options = 0;
  while (std::getline(lines, line)) {
    proposal = line == "# [[reference]]" || (proposal && line.starts_with("# "));
    if (proposal) {
      line.erase(0, 2);
      options += line.starts_with("minimum = ") || line.starts_with("maximum = ") ? 1U : 0U;
    }
    text += line + "\n";
  }
  EXPECT_GE(options, 2U) << text;
  EXPECT_EQ(run_verb({log_, "--compare", write("learned/limited.toml", text)}), ExitCode::done)
      << data_ << remarks_;
}

TEST_F(LearnVerb, WritesNothingOver) {
  const std::string out = (folder_ / "learned").string();
  write("learned/start-up.batch", "mine");
  EXPECT_EQ(run_verb({log_, "--write", out}), ExitCode::usage);
  EXPECT_NE(remarks_.find("start-up.batch is there already"), std::string::npos) << remarks_;
  EXPECT_EQ(text_of_file(fs::path(out) / "start-up.batch"), "mine");
  EXPECT_FALSE(fs::exists(fs::path(out) / "can7.toml"));
}

TEST_F(LearnVerb, SaysWhatItCannotRead) {
  EXPECT_EQ(run_verb({log_ + ".not"}), ExitCode::failed);
  EXPECT_EQ(run_verb({write("empty.log", "")}), ExitCode::failed);
  EXPECT_NE(remarks_.find("no frame"), std::string::npos) << remarks_;
  EXPECT_EQ(run_verb({write("two.log", "(1.000000) can0 101#0000\n(1.100000) can1 101#0000\n")}),
            ExitCode::usage);
  EXPECT_NE(remarks_.find("--from"), std::string::npos) << remarks_;
  EXPECT_EQ(run_verb({write("words.log", log_of(recording_) + "nonsense\n")}), ExitCode::in_part);
  EXPECT_EQ(run_verb({write("far.log", log_of(recording_) + "(999999999999.000000) can7 101#0000\n")}),
            ExitCode::in_part);
  EXPECT_NE(remarks_.find("is no time"), std::string::npos) << remarks_;
  EXPECT_EQ(run_verb({log_, "--stamps", "middle"}), ExitCode::usage);
  EXPECT_EQ(run_verb({log_, "--bit-rate", "100000"}), ExitCode::usage);
  const std::string wrong = write("wrong.toml", "[bus]\nbit_rate = 5\n");
  EXPECT_EQ(run_verb({log_, "--compare", wrong}), ExitCode::failed);
  EXPECT_NE(remarks_.find("wrong.toml:2"), std::string::npos) << remarks_;
}

TEST(LearnedFiles, TheDaemonTakesThemAndDoesWhatWasRecorded) {
  std::string name = (fs::temp_directory_path() / "cansync_learn.XXXXXX").string();
  const fs::path folder = ::mkdtemp(name.data());
  for (unsigned seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    const RandomLine line = observe::support::random_line(seed, seed % 4 == 0);
    const Recording recording = observe::support::record(line, line.master);
    const observe::Observation observation = observe_recording(recording, Form::starts);
    const observe::Learned learned = observe::learn(observation);
    const fs::path out = folder / std::to_string(seed);
    write_learned_files(out.string(), learned_files(observation, learned, {"line.log", "can0", "can0", 0}));
    const MasterSettings wanted = observe::settings_of(learned);
    MasterSettings loaded;
    ASSERT_NO_THROW(loaded = settings_of_file((out / "can0.toml").string()))
        << text_of_file(out / "can0.toml");
    EXPECT_TRUE(learned_differences(loaded, learned).empty());
    EXPECT_TRUE(learned_differences(wanted, learned).empty());
    EXPECT_EQ(loaded.configured(), wanted.configured());
    EXPECT_EQ(loaded.send_margin, std::chrono::duration_cast<std::chrono::microseconds>(wanted.send_margin));
    for (unsigned c = 0; c < kChannels; ++c) {
      // A telegram that was not there is not mapped by what was learned.
      if (learned.reference_mapping[c].known()) {
        EXPECT_EQ(loaded.process.reference_mapping[c], wanted.process.reference_mapping[c]);
      }
      for (const SlaveNumber slave : wanted.configured()) {
        if (learned.slave[slave.value()].actual_mapping[c].known()) {
          EXPECT_EQ(loaded.slaves[slave.value()].actual_mapping[c],
                    wanted.slaves[slave.value()].actual_mapping[c]);
        }
      }
    }
    // Every line of the batch is one that the program understands.
    std::istringstream batch(text_of_file(out / "start-up.batch"));
    std::string text;
    while (std::getline(batch, text)) {
      std::vector<std::string> words;
      for (const Word& word : split_words(text)) words.push_back(word.text);
      if (!words.empty()) {
        EXPECT_NO_THROW(parse_batch_command(words, Globals{})) << text;
      }
    }
  }
  fs::remove_all(folder);
}

/// What is left of a recording when it was cut, filtered, or frames were lost.
Recording damaged(const Recording& recording, unsigned kind) {
  std::size_t place = 0;
  Recording out;
  for (const Recording::Entry& entry : recording.entries) {
    ++place;
    const std::uint32_t channel = entry.frame ? identifier::channel_of(entry.frame->id) : 0;
    const bool answer = channel == identifier::actual_one || channel == identifier::actual_two ||
                        channel == identifier::response;
    const bool reference = channel == identifier::reference_one || channel == identifier::reference_two;
    const bool kept = kind == 0   ? place < recording.entries.size() / 3
                      : kind == 1 ? !answer
                      : kind == 2 ? !reference
                      : kind == 3 ? entry.frame && channel != identifier::command
                      : kind == 4 ? place * 2654435761U % 10 < 6
                                  : place > recording.entries.size() / 2;
    if (kept) out.entries.push_back(entry);
  }
  return out;
}

TEST(LearnedFiles, OfADamagedRecordingAreTakenByTheDaemonToo) {
  std::string name = (fs::temp_directory_path() / "cansync_learn.XXXXXX").string();
  const fs::path folder = ::mkdtemp(name.data());
  for (unsigned seed = 1; seed <= 12; ++seed) {
    const RandomLine line = observe::support::random_line(seed, seed % 4 == 0);
    const Recording recording = observe::support::record(line, line.master);
    for (unsigned kind = 0; kind < 6; ++kind) {
      SCOPED_TRACE(fmt::format("seed {}, kind {}", seed, kind));
      const auto observation = observe_recording(damaged(recording, kind), Form::starts);
      const observe::Learned learned = observe::learn(observation);
      const fs::path out = folder / fmt::format("{}-{}", seed, kind);
      write_learned_files(out.string(), learned_files(observation, learned, {"line.log", "can0", "can0", 0}));
      EXPECT_NO_THROW(settings_of_file((out / "can0.toml").string())) << text_of_file(out / "can0.toml");
    }
  }
  fs::remove_all(folder);
}

TEST(LearnedFiles, HaveNoNameThatLeadsOutOfTheFolder) {
  for (const char* name : {"../../etc/x", "if0/1", "1-2", "can 0", "", "-x"})
    EXPECT_EQ(usable_interface(name), "can0");
  for (const char* name : {"can0", "can-winder", "if0", "vcan_1"}) EXPECT_EQ(usable_interface(name), name);
}

/// The settings that docs/cansync-protocol.md names as open, by the last part of their name.
std::vector<std::string> unconfirmed_settings() {
  std::istringstream document(text_of_file(CANSYNC_PROTOCOL_DOC));
  std::vector<std::string> names;
  std::string line;
  bool inside = false;
  while (std::getline(document, line)) {
    if (line.starts_with("## ")) inside = line == "## Open and unconfirmed";
    if (inside && line.starts_with("What the CAN controller")) break;
    if (!inside || !line.starts_with("| ") || line.starts_with("| point")) continue;
    const std::string last = line.substr(line.rfind('|', line.size() - 2));
    for (std::size_t at = last.find('`'); at != std::string::npos; at = last.find('`', at + 1)) {
      const std::size_t end = last.find('`', at + 1);
      const std::string setting = last.substr(at + 1, end - at - 1);
      const std::size_t dot = setting.rfind('.');
      names.push_back(dot == std::string::npos ? setting : setting.substr(dot + 1));
      at = end;
    }
  }
  return names;
}

TEST(LearnedPoints, EveryUnconfirmedConstantHasItsLine) {
  const observe::Observation nothing;
  const auto points = learned_points(nothing, observe::learn(nothing));
  const auto settings = unconfirmed_settings();
  EXPECT_GE(settings.size(), 13u);
  for (const std::string& setting : settings) {
    const bool there = std::any_of(points.begin(), points.end(), [&](const LearnedPoint& point) {
      return point.name.find("." + setting) != std::string::npos;
    });
    EXPECT_TRUE(there) << setting;
  }
  for (const LearnedPoint& point : points) {
    EXPECT_EQ(point.certainty, observe::Certainty::not_seen) << point.name;
    EXPECT_EQ(point.found, "-") << point.name;
  }
}

TEST(LearnedDifferences, EachDeviationIsFound) {
  const RandomLine line = observe::support::random_line(5, false);
  const auto observation = observe_recording(observe::support::record(line, line.master), Form::starts);
  const observe::Learned learned = observe::learn(observation);
  const MasterSettings same = observe::settings_of(learned);
  ASSERT_TRUE(learned_differences(same, learned).empty());
  const auto option_of = [&](auto change) {
    MasterSettings other = same;
    change(other);
    const auto differences = learned_differences(other, learned);
    return differences.empty() ? std::string() : differences.front().option;
  };
  EXPECT_EQ(option_of([](auto& s) { s.startup.activate_data ^= 1; }), "startup.activate_data");
  EXPECT_EQ(option_of([](auto& s) { s.send_margin += 20 * slot_times(s.bit_rate).bit_time(); }),
            "bus.send_margin_us");
  EXPECT_EQ(option_of([](auto& s) { s.startup.status_period += std::chrono::seconds(1); }),
            "startup.status_period_ms");
  const unsigned first = (*same.configured().begin()).value();
  EXPECT_EQ(option_of([first](auto& s) { ++s.slaves[first].status_parameter; }),
            "slave." + std::to_string(first) + ".status_parameter");
  EXPECT_EQ(option_of([first](auto& s) { s.slaves[first].configured = false; }), "slaves");
}

}  // namespace
}  // namespace cansync::cli
