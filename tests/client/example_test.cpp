#include <gtest/gtest.h>

#include <string>

#include "client/child.h"
#include "client/fake_daemon.h"
#include "support/dds_places.h"

/// Runs the example program, which knows nothing but the data model, as a process of its own.
namespace {

Child run_example(const std::string& arguments) {
  return run_child(std::string(CANSYNC_EXAMPLE) + " " + arguments);
}

class ExampleTest : public ::testing::Test {
 protected:
  ExampleTest() { daemon_.publish_actual(2, 0xABCD); }
  std::string place() const { return std::to_string(places_.here.domain) + " " + places_.here.partition; }

  TwoPlaces places_;
  FakeDaemon daemon_{places_.here};
};

TEST_F(ExampleTest, ShowsActualValuesAndReadsOneParameter) {
  const Child result = run_example(place() + " 2 301");
  EXPECT_EQ(result.exit_code, 0) << result.output;
  EXPECT_NE(result.output.find("value 0: raw 0x0000ABCD"), std::string::npos) << result.output;
  EXPECT_NE(result.output.find("parameter 301: 0\n"), std::string::npos) << result.output;
}

TEST_F(ExampleTest, FailsWithTheDaemonsReason) {
  const Child result = run_example(place() + " 2 4096");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_NE(result.output.find("number 4096: out of range; allowed 0..4095"), std::string::npos)
      << result.output;
}

TEST_F(ExampleTest, WrongUsageFails) {
  EXPECT_EQ(run_example("1").exit_code, 1);
}

}  // namespace
