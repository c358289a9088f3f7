#include "daemon/service/event_codes.h"

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "cansync/master.h"
#include "daemon/cansync/texts/event_text.h"

namespace cansyncd {
namespace {

namespace fs = std::filesystem;

constexpr const char* kCatalog = CANSYNC_SOURCE_DIR "/systemd/cansyncd.catalog";

std::string content(const fs::path& path) {
  std::ifstream file(path);
  std::ostringstream out;
  out << file.rdbuf();
  return out.str();
}

/// Entries of the catalog file by id, as text.
std::multimap<std::string, std::string> catalog_entries() {
  std::multimap<std::string, std::string> entries;
  std::istringstream lines(content(kCatalog));
  auto entry = entries.end();
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("#")) continue;
    if (line.starts_with("-- ")) {
      entry = entries.emplace(line.substr(3), "");
    } else if (entry != entries.end()) {
      entry->second += line + "\n";
    }
  }
  return entries;
}

/// Output of a command; its exit code must be 0.
std::string output_of(const std::string& command) {
  FILE* pipe = ::popen(command.c_str(), "r");
  if (pipe == nullptr) return {};
  std::string out;
  for (int c = 0; (c = std::fgetc(pipe)) != EOF;) out.push_back(static_cast<char>(c));
  const int status = ::pclose(pipe);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << command << "\n" << out;
  return out;
}

TEST(EventCodes, EveryKindHasAWordAndAnIdOfItsOwn) {
  std::set<std::string_view> words;
  std::set<std::string_view> ids;
  const std::regex shape("[0-9a-f]{12}4[0-9a-f]{3}[89ab][0-9a-f]{15}");
  for (const EventKind& kind : kEventKinds) {
    EXPECT_TRUE(words.insert(kind.code).second) << kind.code;
    EXPECT_TRUE(ids.insert(kind.id).second) << kind.code << " has the id of another";
    EXPECT_TRUE(std::regex_match(std::string(kind.id), shape)) << kind.code << ": a random id of version 4";
    EXPECT_LE(kind.code.size(), 63u) << "member code of the topic Event";
  }
  EXPECT_EQ(EventCode("slave_lost"), "slave_lost");
}

TEST(EventCodes, EveryKindIsUsedByTheDaemon) {
  std::string source;
  for (const auto& entry : fs::recursive_directory_iterator(CANSYNC_SOURCE_DIR "/daemon")) {
    const bool table = entry.path().filename() == "event_codes.h";
    if (entry.path().extension() == ".cpp" || (entry.path().extension() == ".h" && !table)) {
      source += content(entry.path());
    }
  }
  for (const EventKind& kind : kEventKinds) {
    EXPECT_NE(source.find('"' + std::string(kind.code) + '"'), std::string::npos)
        << kind.code << " is in the table and nothing tells it";
  }
}

TEST(EventCodes, EventsOfTheMasterHaveItsNames) {
  using Code = cansync::MasterEvent::Code;
  for (int i = 0; cansync::name(static_cast<Code>(i)) != "unknown_event"; ++i) {
    EXPECT_EQ(code_of(static_cast<Code>(i)), cansync::name(static_cast<Code>(i)));
    EXPECT_LT(i, 255);
  }
}

TEST(EventCatalog, HasOneEntryForEachKindAndNoOther) {
  const auto entries = catalog_entries();
  EXPECT_EQ(entries.size(), std::size(kEventKinds));
  for (const EventKind& kind : kEventKinds) {
    EXPECT_EQ(entries.count(std::string(kind.id)), 1u) << kind.code;
  }
}

TEST(EventCatalog, EveryEntryTellsWhatHappenedItsCauseAndItsRemedy) {
  const std::set<std::string> fields = {
      "BUS",          "SLAVE",          "PARAMETER",      "CLIENT",         "CANSYNC_FILE",
      "CANSYNC_NEW",  "CANSYNC_OPTION", "CANSYNC_ACTION", "CANSYNC_WHAT",   "CANSYNC_OLD",
      "CANSYNC_LINE", "CANSYNC_RESULT", "CANSYNC_COLUMN", "CANSYNC_REFUSED"};
  std::map<std::string_view, std::string_view> word_of;
  for (const EventKind& kind : kEventKinds) word_of[kind.id] = kind.code;
  const std::regex shape(
      "Subject: .{10,80}\nDefined-By: cansyncd\nSupport: man:cansyncd\\(8\\)\n"
      "Documentation: man:(cansyncd\\(8\\)|cansync-dds\\(7\\)|cansync\\.toml\\(5\\))\n\n"
      "[A-Z][^]+\n\nCause: [^]+\n\nRemedy: [^]+\n*");
  for (const auto& [id, text] : catalog_entries()) {
    const std::string_view word = word_of[id];
    EXPECT_TRUE(std::regex_match(text, shape)) << word << "\n" << text;
    if (word.starts_with("slave_")) {
      EXPECT_NE(text.find("@SLAVE@"), std::string::npos) << word;
    }
    const std::regex field("@([A-Z_]+)@");
    for (std::sregex_iterator at(text.begin(), text.end(), field), end; at != end; ++at) {
      EXPECT_TRUE(fields.count((*at)[1])) << word << " names a field that no entry has: " << (*at)[1];
    }
  }
}

TEST(EventCatalog, JournalctlTakesIt) {
  std::string root = (fs::temp_directory_path() / "cansync-catalog-XXXXXX").string();
  ASSERT_NE(::mkdtemp(root.data()), nullptr);
  fs::create_directories(root + "/usr/lib/systemd/catalog");
  fs::create_directories(root + "/var/lib/systemd/catalog");
  fs::copy(kCatalog, root + "/usr/lib/systemd/catalog/");
  const std::string problems = output_of("journalctl --root=" + root + " --update-catalog 2>&1");
  EXPECT_EQ(problems, "");
  const std::string listed = output_of("journalctl --root=" + root + " --list-catalog 2>&1");
  for (const EventKind& kind : kEventKinds) {
    EXPECT_NE(listed.find(std::string(kind.id) + " cansyncd: "), std::string::npos) << kind.code;
  }
  std::error_code ignored;
  fs::remove_all(root, ignored);
}

}  // namespace
}  // namespace cansyncd
