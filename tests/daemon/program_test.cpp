#include <gtest/gtest.h>

#include <fstream>
#include <set>
#include <sstream>
#include <variant>

#include "can/candump.h"
#include "cansyncd_fixture.h"

namespace {

TEST_F(CansyncdTest, ChecksAFileAndStartsNothing) {
  const std::string file = write("good.toml", kTwoSlaves);
  Program check = run({"--check", file});
  EXPECT_EQ(check.exit_code(), 0);
  const std::string text = check.text();
  EXPECT_EQ(text.find(file + ": in order\nbus budget at 1000000 bit/s"), 0U) << text;
  EXPECT_NE(text.find("\nbus load: idle 44.4 %, typical 61.8 %, worst 81.0 %\n"), std::string::npos) << text;
}

TEST_F(CansyncdTest, RefusesAWrongFileInBothWays) {
  const std::string file = write("wrong.toml", "[bus]\nbit_rate = 1\n[[slave]]\nnumber = 99\n");
  const std::string expected =
      file + ":2:12: bus.bit_rate: found 1; allowed: 125000, 250000, 500000 or 1000000 bit/s\n" + file +
      ":4:10: slave.number: found 99; allowed: 0..31\n";
  for (const char* option : {"--check", "--"}) {
    Program program(CANSYNCD, {option, file});
    EXPECT_EQ(program.exit_code(), 78);
    EXPECT_EQ(program.text(), expected);
  }
}

TEST_F(CansyncdTest, StartsWithTheLastGoodFileWhenAskedTo) {
  const std::string file = write("line.toml", kTwoSlaves);
  const std::string kept = write("line.9.toml", "[bus]\nbit_rate = 1\n");
  {
    Program good = run({"--last-good", folder_.string(), file});
    ASSERT_TRUE(good.says("running: bus two")) << good.text();
    good.signal(SIGTERM);
    EXPECT_EQ(good.exit_code(), 0) << good.text();
  }
  write("line.toml", "[bus]\nbit_rate = 2\n");
  write("line.11.toml", "bit_rate = ");
  Program refused = run({file});
  EXPECT_EQ(refused.exit_code(), 78) << "by hand a wrong file is refused";
  Program started = run({"--last-good", folder_.string(), file});
  ASSERT_TRUE(started.says("running: bus two")) << started.text();
  ASSERT_TRUE(started.says("configuration_last_good")) << started.text();
  EXPECT_NE(started.text().find(file + ":2:12: bus.bit_rate: found 2; allowed:"), std::string::npos)
      << started.text();
  EXPECT_NE(started.text().find("runs the configuration of 20"), std::string::npos) << started.text();
  started.signal(SIGTERM);
  EXPECT_EQ(started.exit_code(), 0) << started.text();
}

TEST_F(CansyncdTest, RunsWithoutAProfileThatIsMissingAndChecksIt) {
  const std::string file = write("line.toml", std::string(kTwoSlaves) + "profile = \"nowhere\"\n");
  Program check = run({"--check", file});
  EXPECT_EQ(check.exit_code(), 78);
  EXPECT_NE(check.text().find("profile: no profile 'nowhere'"), std::string::npos) << check.text();
  Program started = run({file});
  ASSERT_TRUE(started.says("running: bus two")) << started.text();
  ASSERT_TRUE(started.says("no names of parameters and no limits for writes: " + file)) << started.text();
}

TEST_F(CansyncdTest, WarnsOfABusNameThatEveryMachineHas) {
  const auto checked = [&](const std::string& name, const std::string& interface) {
    Program check = run({"--check", write("line.toml", "[bus]\ninterface = \"can0\"\nname = \"" + name +
                                                           "\"\n[dds]\ninterface = \"" + interface +
                                                           "\"\n[[slave]]\nnumber = 0\n")});
    EXPECT_EQ(check.exit_code(), 0) << check.text();
    return check.text();
  };
  const std::string warning = "warning: bus.name is \"can0\", the name of the CAN interface";
  EXPECT_NE(checked("can0", "eth1").find(warning), std::string::npos);
  EXPECT_EQ(checked("press2", "eth1").find("warning: bus.name"), std::string::npos);
  EXPECT_EQ(checked("can0", "lo").find("warning: bus.name"), std::string::npos);
}

TEST_F(CansyncdTest, RefusesToStartWithoutItsSyncLine) {
  const std::string file =
      write("sync.toml",
            "[sync]\noutput = \"gpio\"\ngpio_chip = \"/nowhere/gpiochip0\"\n" + std::string(kTwoSlaves));
  Program program = run({file});
  EXPECT_NE(program.exit_code(), 0);
  EXPECT_NE(program.text().find(
                file + ":3:13: sync.gpio_chip: /nowhere/gpiochip0: No such file or directory; plug the "
                       "hardware in or load its driver, or name another device"),
            std::string::npos)
      << program.text();
  Program pulses =
      run({file, "--set=sync.output=none", "--set=sync.input=pps", "--set=sync.pps_device=/dev/null"});
  EXPECT_NE(pulses.exit_code(), 0);
  EXPECT_NE(
      pulses.text().find("sync.pps_device: /dev/null: Inappropriate ioctl for device; this is no device of "
                         "that kind"),
      std::string::npos)
      << pulses.text();
}

TEST_F(CansyncdTest, TakesACanInterfaceButNoTraceOfIt) {
  const std::string text = "[bus]\ninterface = \"can0\"\n[[slave]]\nnumber = 0\n";
  EXPECT_EQ(run({"--check", write("can.toml", text)}).exit_code(), 0);
  Program traced = run({"--check", write("traced.toml", text + "[sim]\ntrace = \"x.log\"\n")});
  EXPECT_EQ(traced.exit_code(), 78);
  EXPECT_NE(traced.text().find("traced.toml:6:9: sim.trace: found with bus.interface = \"can0\""),
            std::string::npos)
      << traced.text();
}

TEST_F(CansyncdTest, RefusesAnInterfaceThatIsNotForCan) {
  Program program = run({write("lo.toml", "[bus]\ninterface = \"lo\"\n[[slave]]\nnumber = 0\n")});
  EXPECT_EQ(program.exit_code(), 1);
  EXPECT_NE(program.text().find("lo is no CAN interface"), std::string::npos) << program.text();
}

TEST_F(CansyncdTest, NamesThePlaceInAWrongFaultScript) {
  write("faults.toml", "[[fault]]\nkind = \"nonsense\"\n");
  Program script =
      run({"--check", write("b.toml", "[sim]\nfault_script = \"faults.toml\"\n[[slave]]\nnumber = 0\n")});
  EXPECT_EQ(script.exit_code(), 78);
  EXPECT_NE(script.text().find("/faults.toml:2:"), std::string::npos) << script.text();
}

TEST_F(CansyncdTest, StartsWithoutAFaultThatIsWrongAndSaysSo) {
  const std::string script = write("faults.toml",
                                   "[[fault]]\nkind = \"busy\"\nslave = 0\n"
                                   "[[fault]]\nkind = \"nonsense\"\n");
  const std::string file = write(
      "b.toml",
      "sim.fault_script = \"faults.toml\"\nsim.lock_time_ms = 20\nbus.name = \"two\"\n[[slave]]\nnumber = 0\n");
  Program check = run({"--check", file});
  EXPECT_EQ(check.exit_code(), 78);
  EXPECT_NE(check.text().find("/faults.toml:5:8: kind is \"nonsense\""), std::string::npos) << check.text();
  Program started = run({file});
  ASSERT_TRUE(started.says("running: bus two")) << started.text();
  ASSERT_TRUE(started.says("a fault of the script is left out: " + script + ":5:8: ")) << started.text();
}

TEST_F(CansyncdTest, WrongCommandLinesAreUsageErrors) {
  const std::string file = write("good.toml", kTwoSlaves);
  const std::vector<std::vector<std::string>> wrong = {
      {}, {"--nonsense"}, {file, "--check", file}, {"--trace", "t", file, file}};
  for (const auto& arguments : wrong) {
    Program program(CANSYNCD, arguments);
    EXPECT_EQ(program.exit_code(), 2) << program.text();
    EXPECT_NE(program.text().find("--help"), std::string::npos) << program.text();
  }
}

TEST_F(CansyncdTest, WhatCannotBeHadIsNamed) {
  const std::string file = write("good.toml", kTwoSlaves);
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases = {
      {{"--trace", "/no/such/folder/trace.log"}, "/no/such/folder/trace.log"},
      {{"--set", "realtime.mode=enforce", "--set", "realtime.cpu=1023"}, "1023"},
  };
  for (const auto& [arguments, expected] : cases) {
    std::vector<std::string> all = {file};
    all.insert(all.end(), arguments.begin(), arguments.end());
    Program program = run(all);
    EXPECT_EQ(program.exit_code(), 1) << program.text();
    EXPECT_NE(program.text().find("error: cannot run: "), std::string::npos) << program.text();
    EXPECT_NE(program.text().find(expected), std::string::npos) << program.text();
  }
}

TEST_F(CansyncdTest, RunsUntilSigtermOrSigint) {
  const std::string file = write("good.toml", kTwoSlaves);
  for (const int number : {SIGTERM, SIGINT}) {
    Program program = run({file});
    ASSERT_TRUE(program.says("running: bus two (sim) at 1000000 bit/s, 2 slaves")) << program.text();
    ASSERT_TRUE(program.says("to 'run'")) << program.text();
    EXPECT_NE(program.text().find("realtime thread: SCHED_"), std::string::npos) << program.text();
    program.signal(number);
    EXPECT_EQ(program.exit_code(), 0) << program.text();
    EXPECT_TRUE(program.text().ends_with("stopped\n")) << program.text();
  }
}

TEST_F(CansyncdTest, SigusrSavesAFlightRecordingThatCandumpToolsRead) {
  const std::string folder = (folder_ / "flights").string();
  Program program =
      run({write("good.toml", std::string(kTwoSlaves) + "[recorder]\nfolder = \"" + folder + "\"\n")});
  ASSERT_TRUE(program.says("to 'run'")) << program.text();
  program.signal(SIGUSR1);
  ASSERT_TRUE(program.says("flight_recording: " + folder + "/flight-two-")) << program.text();
  program.signal(SIGTERM);
  EXPECT_EQ(program.exit_code(), 0) << program.text();
  fs::path log;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() == ".log") log = entry.path();
  }
  std::ifstream lines(log);
  unsigned edges = 0;
  unsigned frames = 0;
  for (std::string line; std::getline(lines, line);) {
    const auto parsed = can::parse_candump_line(line);
    ASSERT_TRUE(std::holds_alternative<can::CandumpLine>(parsed)) << line;
    ++(std::get<can::CandumpLine>(parsed).interface == "sync" ? edges : frames);
  }
  EXPECT_GT(edges, 20U);
  EXPECT_GT(frames, 4U) << "activation and status words";
  EXPECT_TRUE(fs::is_regular_file(log.replace_extension(".json")));
}

TEST_F(CansyncdTest, WithoutAFolderThatCanBeWrittenTheRecorderIsOffAndSaysSo) {
  Program program = run({write("good.toml", kTwoSlaves), "--set", "recorder.folder=/no/such/folder"});
  ASSERT_TRUE(program.says("the flight recorder is off: /no/such/folder")) << program.text();
  ASSERT_TRUE(program.says("running: ")) << program.text();
  program.signal(SIGUSR1);
  EXPECT_TRUE(program.says("no flight recording: the flight recorder is off")) << program.text();
}

TEST_F(CansyncdTest, SighupAppliesWhatItCanAndSaysWhatNeedsARestart) {
  const std::string file = write("line.toml", kTwoSlaves);
  Program program = run({file});
  ASSERT_TRUE(program.says("to 'run'")) << program.text();

  write("line.toml",
        "[bus]\nname = \"other\"\n[process]\npolling_1 = 5\n[sim]\nlock_time_ms = 20\n"
        "[[slave]]\nnumber = 0\nname = \"unwinder\"\n[[slave]]\nnumber = 5\n");
  program.signal(SIGHUP);
  EXPECT_TRUE(program.says("changed: process.polling_1\n")) << program.text();
  EXPECT_TRUE(program.says("changed: slave.0.name\n")) << program.text();
  EXPECT_TRUE(program.says("warning: not changed: bus.name takes effect after a restart\n"))
      << program.text();
  EXPECT_TRUE(program.says("configuration_reloaded")) << program.text();

  write("line.toml", "[process]\npolling_1 = 6\n[[slave]]\nnumber = 0\n");
  program.signal(SIGHUP);
  EXPECT_TRUE(program.says("is wrong; the daemon keeps running as before\n")) << program.text();
  EXPECT_TRUE(program.says("line.toml:2:13: process.polling_1: found 6; allowed")) << program.text();

  program.signal(SIGTERM);
  EXPECT_EQ(program.exit_code(), 0);
}

TEST_F(CansyncdTest, TraceIsACandumpLogOfTheBus) {
  const std::string trace = (folder_ / "trace.log").string();
  Program program = run({write("line.toml", kTwoSlaves), "--trace", trace});
  ASSERT_TRUE(program.says("to 'run'")) << program.text();
  program.signal(SIGTERM);
  EXPECT_EQ(program.exit_code(), 0);
  EXPECT_NE(program.text().find("trace " + trace), std::string::npos);

  std::ifstream lines(trace);
  std::set<std::uint32_t> identifiers;
  int edges = 0;
  for (std::string text; std::getline(lines, text);) {
    const auto line = can::parse_candump_line(text);
    ASSERT_TRUE(std::holds_alternative<can::CandumpLine>(line)) << text;
    const auto& parsed = std::get<can::CandumpLine>(line);
    if (parsed.interface == "sync") {
      ++edges;
    } else {
      identifiers.insert(parsed.frame.id);
    }
  }
  EXPECT_GT(edges, 20);
  // SYNC activation, and the status words of both slaves asked and answered.
  for (const std::uint32_t id : {0x010U, 0x500U, 0x580U, 0x505U, 0x585U})
    EXPECT_TRUE(identifiers.contains(id)) << id;
}

TEST_F(CansyncdTest, ATerminalShowsWordsInsteadOfPriorities) {
  const std::string file = write("good.toml", kTwoSlaves);
  const std::vector<std::string> arguments = {file, "--domain=" + std::to_string(domain_.get()),
                                              "--set=recorder.folder=/no/such/folder"};
  Program program(CANSYNCD, arguments, {}, Program::Output::terminal);
  ASSERT_TRUE(program.says("\nrunning: bus two (sim)")) << program.text();
  EXPECT_NE(program.text().find("warning: the flight recorder is off"), std::string::npos) << program.text();
  program.signal(SIGTERM);
  EXPECT_EQ(program.exit_code(), 0);
  EXPECT_EQ(program.text().find('<'), std::string::npos) << program.text();
  // A variable that names another stream changes nothing.
  Program told(CANSYNCD, {file, "--set=realtime.mode=enforce", "--set=realtime.cpu=1023"},
               {"JOURNAL_STREAM=1:2"}, Program::Output::terminal);
  EXPECT_EQ(told.exit_code(), 1);
  EXPECT_NE(told.text().find("error: cannot run: "), std::string::npos) << told.text();
}

}  // namespace
