// A program of its own: a signal that came stays known in it.
#include <gtest/gtest.h>

#include <csignal>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "cli/base/interrupt.h"
#include "cli/base/session.h"

namespace cansync::cli {
namespace {

TEST(SeveralSlaves, ThoseThatASignalLeavesOutAreNamedAndTheVerbIsNotDone) {
  install_interrupt_handlers();
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> remarks(std::tmpfile(), &std::fclose);
  Output output(stdout, remarks.get(), false);
  Connection connection;
  Session session({}, output, connection);
  const std::vector<unsigned> slaves = {0, 3, 4, 7};
  const auto until = [&](std::size_t last) {
    return session.for_each(slaves, [last](std::size_t index) {
      if (index == last) (void)std::raise(SIGINT);
      return ExitCode::done;
    });
  };
  EXPECT_EQ(until(3), ExitCode::done) << "none was left out";
  EXPECT_EQ(until(1), ExitCode::cancelled) << "and the first was the last: the signal came before";
  std::rewind(remarks.get());
  std::string text;
  for (int c = std::fgetc(remarks.get()); c != EOF; c = std::fgetc(remarks.get()))
    text += static_cast<char>(c);
  EXPECT_EQ(text, "cansync: slaves 3-4,7: not done\n");
}

}  // namespace
}  // namespace cansync::cli
