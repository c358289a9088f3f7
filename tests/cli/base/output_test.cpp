#include "cli/base/output.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <system_error>

#include "cli/text/progress.h"

namespace cansync::cli {
namespace {

/// A temporary file that is read back.
class Capture {
 public:
  std::FILE* file() { return file_.get(); }
  std::string text() {
    std::string out;
    std::rewind(file());
    for (int c = std::fgetc(file()); c != EOF; c = std::fgetc(file())) out += static_cast<char>(c);
    return out;
  }

 private:
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file_{std::tmpfile(), &std::fclose};
};

TEST(Colours, AreThereWhenTheyAreAskedForAlone) {
  Capture capture;
  Output output(capture.file(), stderr, false);
  EXPECT_EQ(output.painted("a", Style::bad), "a") << "a file is no terminal";
  output.set_colours(ColourUse::always);
  EXPECT_EQ(output.painted("a", Style::bad), "\x1b[31ma\x1b[0m");
  EXPECT_EQ(output.painted("a", Style::plain), "a");
  EXPECT_EQ(output.for_line(false, "").painted("a", Style::warning), "\x1b[33ma\x1b[0m");
  output.set_colours(ColourUse::never);
  EXPECT_EQ(output.painted("a", Style::bad), "a");
}

TEST(Output, NoControlCharacterOfAForeignTextReachesATerminal) {
  const std::string foreign =
      "name\x1b]0;title\x07\x1b[2J\x1b[8m\x9b\xc2\x9b"
      "31m\x7f\r";
  for (const ColourUse use : {ColourUse::always, ColourUse::never}) {
    Capture data;
    Capture remarks;
    Output output(data.file(), remarks.file(), false);
    output.set_colours(use);
    output.line(foreign);
    output.line(foreign + output.painted(foreign, Style::bad) + foreign);
    Table table({{"NAME"}});
    table.add({foreign});
    output.table(table, {Style::warning});
    output.remark(foreign);
    std::string shown = data.text() + remarks.text();
    for (const std::string own : {"\x1b[31m", "\x1b[33m", "\x1b[0m"})
      for (std::size_t at = shown.find(own); at != std::string::npos; at = shown.find(own))
        shown.erase(at, own.size());
    EXPECT_EQ(shown.find_first_of("\x1b\x07\x7f\r"), std::string::npos) << shown;
    EXPECT_EQ(shown.find("\xc2\x9b"), std::string::npos);
    EXPECT_NE(shown.find("\\x1b[2J"), std::string::npos) << shown;
  }
}

TEST(Output, LinesAreTheSameForScriptsWhateverTheTerminal) {
  Capture capture;
  Output output(capture.file(), stderr, false);
  EXPECT_EQ(output.fitting_width(), 0u) << "a file is no terminal";
  Table table({{"NAME"}, {"COUNT", Table::Align::right, "", 0, 1, true}});
  table.add({"one", "0"});
  output.table(table);
  EXPECT_EQ(capture.text(), "NAME  COUNT\none       0\n") << "on a terminal it would go";
}

TEST(Output, KeepsDataAndRemarksApart) {
  Capture data;
  Capture remarks;
  Output output(data.file(), remarks.file(), true);
  output.object(JsonObject().add("result", "done"));
  output.remark("working");
  EXPECT_EQ(data.text(), "{\"result\":\"done\"}\n");
  EXPECT_EQ(remarks.text(), "cansync: working\n");
}

TEST(Output, SaysWhenDataCannotBeWritten) {
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> full(std::fopen("/dev/full", "w"), &std::fclose);
  ASSERT_NE(full, nullptr);
  Output output(full.get(), full.get(), false);
  EXPECT_THROW(output.line("x"), std::system_error);
}

/// A pipe without room whose reader takes what is in it when a signal comes, as Ctrl-C may come while a
/// program waits.
class FullPipe {
 public:
  FullPipe() {
    EXPECT_EQ(::pipe2(ends_.data(), O_NONBLOCK), 0);
    while (::write(ends_[1], "....", 4) > 0) {
    }
    EXPECT_EQ(::fcntl(ends_[1], F_SETFL, 0), 0);
    file_ = ::fdopen(ends_[1], "w");
    reader = ends_[0];
    struct sigaction action {};
    action.sa_handler = [](int) { drain(); };
    ::sigaction(SIGALRM, &action, &former_);
    const itimerval soon{{0, 0}, {0, 20000}};
    ::setitimer(ITIMER_REAL, &soon, nullptr);
  }
  ~FullPipe() {
    ::sigaction(SIGALRM, &former_, nullptr);
    std::fclose(file_);
    ::close(ends_[0]);
  }
  FullPipe(const FullPipe&) = delete;
  FullPipe& operator=(const FullPipe&) = delete;

  std::FILE* file() { return file_; }
  /// What came last.
  static std::string drain() {
    static std::array<char, 4096> part;
    std::size_t last = 0;
    for (ssize_t count = 1; count > 0;) {
      count = ::read(reader, part.data(), part.size());
      if (count > 0) last = static_cast<std::size_t>(count);
    }
    return {part.data(), std::min<std::size_t>(last, 15)};
  }

 private:
  static inline int reader = -1;
  std::array<int, 2> ends_{};
  std::FILE* file_ = nullptr;
  struct sigaction former_ {};
};

TEST(Output, GoesOnWhenASignalComesWhileItWaits) {
  FullPipe pipe;
  Output output(pipe.file(), pipe.file(), false);
  output.line("after it");
  EXPECT_EQ(FullPipe::drain(), "after it\n");
}

TEST(Output, RedrawsFromTheUpperLeft) {
  Capture data;
  Output output(data.file(), data.file(), false);
  Table table({{"A"}});
  table.add({"1"});
  output.redraw("title", table);
  output.redraw("title", table);
  const std::string screen = "\x1b[Htitle\x1b[K\nA\x1b[K\n1\x1b[K\n\x1b[J";
  EXPECT_EQ(data.text(), "\x1b[2J" + screen + screen);
}

TEST(Progress, ShowsTheShareDone) {
  EXPECT_EQ(progress_line(0, 200, 40), "[....................]   0 %  0 of 200 B");
  EXPECT_EQ(progress_line(100, 200, 40), "[#########.........]  50 %  100 of 200 B");
  EXPECT_EQ(progress_line(200, 200, 40), "[##################] 100 %  200 of 200 B");
}

TEST(Progress, StaysInsideTheLine) {
  for (unsigned width = 1; width < 100; ++width)
    EXPECT_LE(progress_line(123456, 16777216, width).size(), width);
}

TEST(Progress, CopesWithNothingToDoAndTooMuchDone) {
  EXPECT_NE(progress_line(0, 0, 60).find("100 %"), std::string::npos);
  EXPECT_NE(progress_line(300, 200, 60).find("100 %  200 of 200 B"), std::string::npos);
}

TEST(Progress, SaysNothingWithoutATerminal) {
  Capture file;
  {
    ProgressBar bar(file.file());
    bar.update(1, 2);
  }
  EXPECT_EQ(file.text(), "");
}

}  // namespace
}  // namespace cansync::cli
