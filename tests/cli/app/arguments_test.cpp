#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "cli/app/application.h"

namespace cansync::cli {
namespace {

struct Outcome {
  ExitCode code;
  std::string data;
  std::string remarks;
};

std::string read_back(std::FILE* file) {
  std::string text;
  std::rewind(file);
  for (int c = std::fgetc(file); c != EOF; c = std::fgetc(file)) text += static_cast<char>(c);
  return text;
}

Outcome run_with(std::vector<const char*> arguments) {
  using File = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;
  const File data(std::tmpfile(), &std::fclose);
  const File remarks(std::tmpfile(), &std::fclose);
  arguments.insert(arguments.begin(), "cansync");
  const ExitCode code = run(static_cast<int>(arguments.size()), arguments.data(), data.get(), remarks.get());
  return {code, read_back(data.get()), read_back(remarks.get())};
}

struct WrongLine {
  std::vector<const char*> arguments;
  const char* complaint;  ///< what the remark must hold
};

/// Every one of these is told without a daemon, so nothing can have been sent.
class WrongCommandLine : public testing::TestWithParam<WrongLine> {};

TEST_P(WrongCommandLine, IsRefusedBeforeAnythingIsSent) {
  const Outcome outcome = run_with(GetParam().arguments);
  EXPECT_EQ(outcome.code, ExitCode::usage);
  EXPECT_EQ(outcome.data, "");
  EXPECT_NE(outcome.remarks.find(GetParam().complaint), std::string::npos) << outcome.remarks;
}

INSTANTIATE_TEST_SUITE_P(
    All, WrongCommandLine,
    testing::Values(
        WrongLine{{}, "VERB: found nothing; allowed: status, buses"},
        WrongLine{{"frobnicate", "1"}, "VERB: found 'frobnicate'; allowed: status, buses"},
        WrongLine{{"status", "--color", "red"}, "--color: found 'red'; allowed: auto, always, never"},
        WrongLine{{"read", "winder", "100", "4096"}, "PARAMETER: found '4096'; allowed: 0..4095"},
        WrongLine{{"read", "1", "100", "--every", "0.05"},
                  "--every: found '0.05'; allowed: 0.1..86400 seconds"},
        WrongLine{{"read", "1", "100", "--count", "2"}, "--every"},
        WrongLine{{"events", "--since", "soon"}, "--since: found 'soon'; allowed: how long ago"},
        WrongLine{{"events", "--level", "bad"}, "--level: found 'bad'; allowed: info, warning, error"},
        WrongLine{{"events", "--code", "Slave lost"}, "--code: found 'Slave lost'; allowed: codes"},
        WrongLine{{"events", "--slave", "32"}, "SLAVE: found '32'; allowed: 0..31"},
        WrongLine{
            {"status", "--colour"},
            "found '--colour', which is no argument of status; did you mean '--color'?; see `cansync status --help`"},
        WrongLine{
            {"--colour", "red"},
            "found '--colour', which is no argument of cansync; did you mean '--color'?; see `cansync --help`"},
        WrongLine{{"control", "1", "7", "8", "9"}, "found '8', which is no argument of control"},
        WrongLine{{"--domain", "231", "status"}, "--domain: found '231'; allowed: 0..230"},
        WrongLine{{"sttus"}, "VERB: found 'sttus'; did you mean 'status'?; allowed: status, buses"},
        WrongLine{{"status", "--jsno"}, "which is no argument of status; did you mean '--json'?"},
        WrongLine{{"wait", "synchronised"}, "did you mean 'synchronized'?"},
        WrongLine{{"--bus", "a b", "status"}, "--bus: found 'a b'; allowed: 1..63 letters, digits"},
        WrongLine{{"--bus", "plc2/", "status"}, "--bus: found 'plc2/'; allowed: 1..63 letters, digits"},
        WrongLine{{"--bus", "/can0", "status"}, "--bus: found '/can0'; allowed: 1..63 letters, digits"},
        WrongLine{{"--bus", "plc2/can0/1", "status"}, "or HOST/BUS of such names"},
        WrongLine{{"status", "--timeout", "0"}, "--timeout: found '0'"},
        WrongLine{{"record", "x.csv", "--every", "0"}, "--every: found '0'"},
        WrongLine{{"record", "x.csv", "--duration", "-1"}, "--duration: found '-1'"},
        WrongLine{{"record", "-", "--json"}, "both write to standard output"},
        WrongLine{{"plot", "x.csv", "-o", "x.pdf"}, "--output: found 'x.pdf'"},
        WrongLine{{"read", "1"}, "PARAMETER is required"},
        WrongLine{{"write", "1", "2", "3", "4"},
                  "found '4', which is no argument of write; see `cansync write --help`"},
        WrongLine{{"read", "32", "1"}, "SLAVE: found '32'; allowed: 0..31"},
        WrongLine{{"read", "1-32", "1"}, "SLAVE: found '32'; allowed: 0..31"},
        WrongLine{{"control", "3-1", "5"}, "SLAVE: found range '3-1'; allowed: the smaller number first"},
        WrongLine{{"status", "--retry", "0"}, "--retry: found '0'; allowed: over 0 and up to 86400 seconds"},
        WrongLine{{"wait", "ready"}, "STATE: found 'ready'; allowed: present, gone, setup"},
        WrongLine{{"wait", "run", "1"}, "SLAVE: found '1'; run is no state of a slave"},
        WrongLine{{"wait", "held", "32"}, "SLAVE: found '32'; allowed: 0..31"},
        WrongLine{{"batch"}, "FILE is required"},
        WrongLine{{"read", "1", "4096"}, "PARAMETER: found '4096'; allowed: 0..4095"},
        WrongLine{{"read", "1", "1", "--element", "8"}, "--element: found '8'; allowed: 0..7"},
        WrongLine{{"read", "1", "1", "--sub-slave", "65536"}, "allowed: 0..65535"},
        WrongLine{{"read", "1", "1", "--format", "byte"}, "allowed: word, doubleword, auto"},
        WrongLine{{"write", "1", "1", "65536", "--format", "word"},
                  "VALUE: found '65536'; allowed: -32768..65535"},
        WrongLine{{"write", "1", "1", "-2147483649"}, "VALUE: found '-2147483649'"},
        WrongLine{{"upload", "1", "0x100", "0", "f"}, "LENGTH: found '0'; allowed: 1..16777216"},
        WrongLine{{"upload", "1", "0x100", "10", "f", "--block-size", "4093"}, "allowed: 0..4092"},
        WrongLine{{"upload", "1", "0x100", "10", "-", "--json"}, "both want standard output"},
        WrongLine{{"upload", "1", "0x100", "10", "/dev/null"}, "'/dev/null' is no file"},
        WrongLine{{"download", "1", "0x100", "/dev/null"}, "'/dev/null' is empty"},
        WrongLine{{"control", "1", "65536"}, "WORD: found '65536'"}, WrongLine{{"broadcast"}, "is required"},
        WrongLine{{"broadcast", "--slaves", "0x0", "--command", "1"}, "slaves: found '0x0'"},
        WrongLine{{"broadcast", "--slaves", "1", "--command", "1", "--priority", "3"},
                  "--priority: found '3'"},
        WrongLine{{"mode", "walk"}, "MODE: found 'walk'; allowed: setup, run"},
        WrongLine{{"mode", "stop", "--force"}, "only `mode run`"}, WrongLine{{"set"}, "is required"},
        WrongLine{{"set", "5"}, "found '5'; allowed: VALUE=NUMBER"},
        WrongLine{{"set", "0=1", "--strength", "-1"}, "--strength: found '-1'"},
        WrongLine{{"watch", "--interval", "0"}, "--interval: found '0'"},
        WrongLine{{"poll", "1"}, "found '1' without a slave"},
        WrongLine{{"poll", "3", "auto"}, "CHANNEL: found '3'; allowed: 1..2"},
        WrongLine{{"map", "references", "3", "-"}, "TELEGRAM: found '3'; allowed: 1..2"},
        WrongLine{{"map", "references", "1"}, "found 0 words; allowed: 1..4"}));

TEST(CommandLine, HelpAndVersionAreUnderstoodAsWords) {
  EXPECT_EQ(run_with({"help"}).data, run_with({"--help"}).data);
  EXPECT_EQ(run_with({"help", "read"}).data, run_with({"read", "--help"}).data);
  for (const char* word : {"version", "-V"}) EXPECT_EQ(run_with({word}).data, run_with({"--version"}).data);
  EXPECT_EQ(run_with({"help", "sttus"}).code, ExitCode::usage);
}

TEST(CommandLine, HelpOfEveryVerbIsData) {
  for (const char* verb : {"status", "slaves", "watch", "events", "read", "write", "upload", "download",
                           "control", "broadcast", "mode", "set", "poll", "map"}) {
    const Outcome outcome = run_with({verb, "--help"});
    EXPECT_EQ(outcome.code, ExitCode::done) << verb;
    EXPECT_NE(outcome.data.find(std::string("cansync ") + verb), std::string::npos) << outcome.data;
    EXPECT_EQ(outcome.remarks, "");
  }
}

TEST(CommandLine, HelpListsVerbsAndExitCodes) {
  const Outcome outcome = run_with({"--help"});
  EXPECT_EQ(outcome.code, ExitCode::done);
  EXPECT_NE(outcome.data.find("\n  broadcast "), std::string::npos);
  EXPECT_NE(outcome.data.find("Exit codes:\n  0  done"), std::string::npos);
  EXPECT_EQ(outcome.remarks, "");
}

TEST(CommandLine, AFileThatCannotBeDownloadedIsToldBeforeAnythingIsSent) {
  const std::string missing = testing::TempDir() + "cansync_arguments_test_missing";
  const Outcome absent = run_with({"download", "1", "0x100", missing.c_str()});
  EXPECT_EQ(absent.code, ExitCode::failed);
  EXPECT_NE(absent.remarks.find(missing + ": No such file"), std::string::npos) << absent.remarks;
  const std::string folder = testing::TempDir();
  const Outcome unreadable = run_with({"download", "1", "0x100", folder.c_str()});
  EXPECT_EQ(unreadable.code, ExitCode::failed);
  EXPECT_NE(unreadable.remarks.find(folder + ": Is a directory"), std::string::npos) << unreadable.remarks;
  const std::string long_file = testing::TempDir() + "cansync_arguments_test_" + std::to_string(::getpid());
  std::ofstream(long_file).close();
  std::filesystem::resize_file(long_file, 16'777'217);  // takes no room
  const Outcome too_long = run_with({"download", "1", "0x100", long_file.c_str()});
  std::filesystem::remove(long_file);
  EXPECT_EQ(too_long.code, ExitCode::usage);
  EXPECT_NE(too_long.remarks.find("is too long; allowed: 1..16777216 bytes"), std::string::npos)
      << too_long.remarks;
}

TEST(CommandLine, AMissingInterfaceIsNotReachable) {
  const Outcome outcome = run_with({"status", "--interface", "nosuchinterface"});
  EXPECT_EQ(outcome.code, ExitCode::not_reachable);
  EXPECT_NE(outcome.remarks.find("'nosuchinterface' does not exist"), std::string::npos) << outcome.remarks;
}

}  // namespace
}  // namespace cansync::cli
