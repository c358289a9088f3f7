#include "cli/base/interrupt.h"

#include <gtest/gtest.h>

#include <csignal>

namespace cansync::cli {
namespace {

TEST(Interrupt, AProgramThatIsContinuedIsNotAskedToEnd) {
  install_interrupt_handlers();
  EXPECT_FALSE(just_continued());
  ASSERT_EQ(std::raise(SIGCONT), 0);
  EXPECT_TRUE(just_continued());
  EXPECT_FALSE(interrupt_flag().load());
  EXPECT_FALSE(wait_until(std::chrono::steady_clock::now()));
}

}  // namespace
}  // namespace cansync::cli
