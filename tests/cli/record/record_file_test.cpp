#include "cli/record/record_file.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "cli/text/values.h"

namespace cansync::cli {
namespace {

const std::string kHeader = "time,value\n";
constexpr std::uint64_t kBytes = 4096;

class RecordFileTest : public ::testing::Test {
 protected:
  RecordFileTest()
      : folder_(std::filesystem::path(::testing::TempDir()) / ("record" + std::to_string(getpid()))) {
    std::filesystem::create_directories(folder_);
  }
  ~RecordFileTest() override { std::filesystem::remove_all(folder_); }

  std::string path(const std::string& name = "run.csv") const { return (folder_ / name).string(); }
  std::string content(const std::string& name) const {
    std::ifstream file(path(name));
    return {std::istreambuf_iterator<char>(file), {}};
  }
  /// Lines with rising numbers, a few at a time.
  static std::string lines(unsigned first, unsigned count) {
    std::string out;
    for (unsigned i = first; i < first + count; ++i) out += std::to_string(100000 + i) + ",1.5\n";
    return out;
  }

  std::filesystem::path folder_;
};

TEST_F(RecordFileTest, EndsFullWithWholeLinesAndWithinItsBound) {
  RecordFile file(path(), kHeader, {kBytes, 0});
  std::string all = kHeader;
  unsigned written = 0;
  while (file.write(lines(written, 7))) {
    all += lines(written, 7);
    written += 7;
    ASSERT_LT(written, 10000u);
  }
  EXPECT_FALSE(file.write(lines(0, 1)));
  const std::string found = content("run.csv");
  EXPECT_LE(found.size(), kBytes);
  EXPECT_GT(found.size(), kBytes - 2 * lines(0, 1).size());
  EXPECT_EQ(found.back(), '\n');
  EXPECT_EQ((all + lines(written, 7)).substr(0, found.size()), found) << "nothing is left out in between";
}

TEST_F(RecordFileTest, KeepsSoManyOlderFilesAndLosesNoLineBetweenThem) {
  RecordFile file(path(), kHeader, {kBytes, 2});
  constexpr unsigned kLines = 1500;  // some five files
  for (unsigned i = 0; i < kLines; i += 50) ASSERT_TRUE(file.write(lines(i, 50)));
  EXPECT_FALSE(std::filesystem::exists(path("run.csv.3")));
  std::string joined;
  for (const char* name : {"run.csv.2", "run.csv.1", "run.csv"}) {
    const std::string text = content(name);
    EXPECT_LE(text.size(), kBytes) << name;
    ASSERT_EQ(text.substr(0, kHeader.size()), kHeader) << name;
    joined += text.substr(kHeader.size());
  }
  const std::string every = lines(0, kLines);
  EXPECT_EQ(joined, every.substr(every.size() - joined.size()));
  EXPECT_GT(joined.size(), 2 * (kBytes - 2 * kHeader.size()));
}

TEST_F(RecordFileTest, AnEarlierRecordingIsNotReplacedWithoutForce) {
  const RecordBounds bounds{.bytes = kBytes, .older = 2};
  EXPECT_NO_THROW(expect_new_files(path(), bounds, false));
  std::ofstream(path("run.csv.3")) << "another one";  // of more files than are kept now
  EXPECT_NO_THROW(expect_new_files(path(), bounds, false));
  std::ofstream(path("run.csv.2")) << "of yesterday";
  EXPECT_NO_THROW(expect_new_files(path(), bounds, true));
  EXPECT_NO_THROW(expect_new_files(path(), {}, false));
  try {
    expect_new_files(path(), bounds, false);
    ADD_FAILURE() << "it would have been replaced";
  } catch (const UsageError& error) {
    EXPECT_NE(std::string(error.what()).find("run.csv.2"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("--force"), std::string::npos) << error.what();
  }
}

TEST_F(RecordFileTest, WithoutABoundTakesAll) {
  RecordFile file(path(), kHeader, {});
  EXPECT_TRUE(file.write(lines(0, 5000)));
  EXPECT_EQ(content("run.csv"), kHeader + lines(0, 5000));
}

TEST(ParseSize, UnitsAndWhatIsNone) {
  EXPECT_EQ(parse_size("65536", "--max-size"), 65536u);
  EXPECT_EQ(parse_size("64K", "--max-size"), 65536u);
  EXPECT_EQ(parse_size("2G", "--max-size"), std::uint64_t{2} << 30);
  for (const char* wrong : {"", "0", "-1", "64k", "1T", "K", "1MB", "99999999999G"})
    EXPECT_THROW((void)parse_size(wrong, "--max-size"), UsageError) << wrong;
}

}  // namespace
}  // namespace cansync::cli
