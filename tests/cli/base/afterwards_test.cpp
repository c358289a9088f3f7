// Commands that are run when a process is killed, and not when it ends in order.
#include "cli/base/afterwards.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <optional>
#include <thread>

namespace cansync::cli {
namespace {

namespace fs = std::filesystem;

class AfterwardsTest : public ::testing::Test {
 protected:
  AfterwardsTest() {
    std::string name = (fs::temp_directory_path() / "cansync_afterwards.XXXXXX").string();
    folder_ = ::mkdtemp(name.data());
    made_ = (folder_ / "it's made").string();
  }
  ~AfterwardsTest() override { fs::remove_all(folder_); }

  fs::path folder_;
  std::string made_;
};

TEST_F(AfterwardsTest, RunsTheCommandsWhenTheProcessIsKilled) {
  const pid_t child = ::fork();
  if (child == 0) {
    const Afterwards afterwards({{"false"}, {"touch", made_}});
    ::raise(SIGKILL);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFSIGNALED(status));
  // The shell is nobody's child; the time limit of the test ends a wait that is in vain.
  while (!fs::exists(made_)) std::this_thread::yield();
}

TEST_F(AfterwardsTest, RunsNothingWhenItIsCalledOff) {
  std::optional<Afterwards> afterwards(std::in_place,
                                       std::vector<std::vector<std::string>>{{"touch", made_}});
  afterwards.reset();
  EXPECT_FALSE(fs::exists(made_));
}

}  // namespace
}  // namespace cansync::cli
