#include "daemon/status/metrics_file.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <condition_variable>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <sstream>
#include <string>
#include <vector>

#include "daemon/service/replace_file.h"

namespace cansyncd {
namespace {

namespace fs = std::filesystem;

class MetricsFileTest : public testing::Test {
 protected:
  MetricsFileTest() {
    std::string name = (fs::temp_directory_path() / "cansyncd-metrics-XXXXXX").string();
    folder_ = ::mkdtemp(name.data());
    path_ = (folder_ / "line.prom").string();
  }
  ~MetricsFileTest() override {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
  }
  std::string content() const {
    std::ifstream file(path_);
    std::ostringstream out;
    out << file.rdbuf();
    return out.str();
  }

  fs::path folder_;
  std::string path_;
};

/// Events, as the writing thread tells them.
class Told {
 public:
  void operator()(const EventText& event) {
    const std::lock_guard lock(mutex_);
    events_.push_back(event);
    wake_.notify_all();
  }
  /// The first `count` events; fewer when they do not come within 60 s.
  std::vector<EventText> wait(std::size_t count) {
    std::unique_lock lock(mutex_);
    wake_.wait_for(lock, std::chrono::seconds(60), [&] { return events_.size() >= count; });
    return events_;
  }

 private:
  std::mutex mutex_;
  std::condition_variable wake_;
  std::vector<EventText> events_;
};

TEST_F(MetricsFileTest, ReplacesTheFileAndLeavesNothingBeside) {
  EXPECT_EQ(replace_file(path_, "one\n"), std::nullopt);
  std::ifstream reader(path_);  // keeps what it opened
  EXPECT_EQ(replace_file(path_, "two\n"), std::nullopt);
  std::string seen;
  std::getline(reader, seen);
  EXPECT_EQ(seen, "one");
  EXPECT_EQ(content(), "two\n");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()), 1);
}

TEST_F(MetricsFileTest, EveryUserMayReadItWhateverTheUmaskOfTheServiceIs) {
  const mode_t before = ::umask(0027);
  EXPECT_EQ(replace_file(path_, "one\n"), std::nullopt);
  EXPECT_EQ(fs::status(path_).permissions(), fs::perms(0640));
  EXPECT_EQ(replace_file(path_, "two\n", {.for_everybody = true}), std::nullopt);
  EXPECT_EQ(fs::status(path_).permissions(), fs::perms(0644));
  ::umask(before);
}

TEST_F(MetricsFileTest, DoesNotWriteThroughALink) {
  const fs::path other = folder_ / "other";
  std::ofstream(other) << "mine";
  fs::create_symlink(other, path_ + ".new");
  EXPECT_EQ(replace_file(path_, "metrics\n"), std::nullopt);
  std::ifstream file(other);
  std::string text;
  file >> text;
  EXPECT_EQ(text, "mine");
  EXPECT_EQ(content(), "metrics\n");
}

TEST_F(MetricsFileTest, AFullDiskKeepsTheFileBefore) {
  ASSERT_EQ(replace_file(path_, "before\n"), std::nullopt);
  std::signal(SIGXFSZ, SIG_IGN);
  const rlimit before = [] {
    rlimit limit{};
    ::getrlimit(RLIMIT_FSIZE, &limit);
    return limit;
  }();
  const rlimit little{16, before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &little), 0);
  const auto problem = replace_file(path_, std::string(100, 'x'));
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
  EXPECT_EQ(problem, "File too large");
  EXPECT_EQ(content(), "before\n");
  EXPECT_FALSE(fs::exists(path_ + ".new"));
}

TEST_F(MetricsFileTest, FailuresAreToldOnceAndCounted) {
  path_ = (folder_ / "later" / "line.prom").string();
  Told told;
  {
    MetricsFile file(path_, [&](const EventText& event) { told(event); });
    file.write("a\n");
    auto events = told.wait(1);
    ASSERT_EQ(events.size(), 1u);
    EXPECT_EQ(events[0].code, "metrics_not_written");
    EXPECT_EQ(events[0].severity, gateway_SEVERITY_WARNING);
    EXPECT_NE(events[0].text.find(path_ + " cannot be written: No such file or directory"), std::string::npos)
        << events[0].text;
    file.write("b\n");
    while (file.failures() < 2) std::this_thread::yield();
    fs::create_directory(folder_ / "later");
    file.write("c\n");
    events = told.wait(2);
    ASSERT_EQ(events.size(), 2u) << "the second failure is counted alone";
    EXPECT_EQ(events[1].code, "metrics_written_again");
    EXPECT_NE(events[1].text.find("2 times it was not"), std::string::npos) << events[1].text;
    EXPECT_EQ(content(), "c\n");
    EXPECT_EQ(file.failures(), 2u);
  }
  EXPECT_FALSE(fs::exists(path_)) << "nobody renews it any more";
}

}  // namespace
}  // namespace cansyncd
