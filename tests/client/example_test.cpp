#include <gtest/gtest.h>
#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <memory>
#include <string>

#include "client/fake_daemon.h"
#include "support/dds_places.h"

/// Runs the example program, which knows nothing but the data model, as a process of its own.
namespace {

struct Result {
  int exit_code = -1;
  std::string output;  // stdout and stderr
};

Result run_example(const std::string& arguments) {
  Result result;
  FILE* pipe = popen((std::string(CANSYNC_EXAMPLE) + " " + arguments + " 2>&1").c_str(), "r");
  if (pipe == nullptr) return result;
  std::array<char, 256> line = {};
  while (fgets(line.data(), line.size(), pipe) != nullptr) result.output += line.data();
  const int status = pclose(pipe);
  result.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return result;
}

class ExampleTest : public ::testing::Test {
 protected:
  ExampleTest() { daemon_.publish_actual(2, 0xABCD); }
  std::string place() const { return std::to_string(places_.here.domain) + " " + places_.here.partition; }

  TwoPlaces places_;
  FakeDaemon daemon_{places_.here};
};

TEST_F(ExampleTest, ShowsActualValuesAndReadsOneParameter) {
  const Result result = run_example(place() + " 2 301");
  EXPECT_EQ(result.exit_code, 0) << result.output;
  EXPECT_NE(result.output.find("value 0: raw 0x0000ABCD"), std::string::npos) << result.output;
  EXPECT_NE(result.output.find("parameter 301: 0\n"), std::string::npos) << result.output;
}

TEST_F(ExampleTest, FailsWithTheDaemonsReason) {
  const Result result = run_example(place() + " 2 4096");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_NE(result.output.find("number 4096: out of range; allowed 0..4095"), std::string::npos)
      << result.output;
}

TEST_F(ExampleTest, WrongUsageFails) {
  EXPECT_EQ(run_example("1").exit_code, 1);
}

}  // namespace
