#include "daemon/service/pending_restart.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

/// A made-up tree with the process's memory map, its libraries and the version that the package has left.
namespace cansyncd {
namespace {

namespace fs = std::filesystem;

constexpr const char* kProgram = "/usr/sbin/cansyncd";
constexpr const char* kDds = "/usr/lib/x86_64-linux-gnu/libddsc.so.0debian";

class ReplacedOnDisk : public testing::Test {
 protected:
  ReplacedOnDisk() : root_(fs::temp_directory_path() / ("pending_restart_" + std::to_string(getpid()))) {
    fs::remove_all(root_);
    for (const char* path : {kProgram, kDds}) write(path, "old");
    maps("");
    version("1.0-1");
  }
  ~ReplacedOnDisk() override { fs::remove_all(root_); }

  fs::path place(const std::string& path) const { return root_ / fs::path(path).relative_path(); }
  void write(const std::string& path, const std::string& text) const {
    fs::create_directories(place(path).parent_path());
    std::ofstream(place(path)) << text;
  }
  void version(const std::string& text) const { write(ReplacedFiles::kVersionFile, text + "\n"); }
  /// As a package manager does it: the new file is written beside the old one and takes its name. The old
  /// one keeps its inode for as long as the process has it, here by a second name.
  void replace(const std::string& path) const {
    write(path + ".dpkg-new", "new");
    fs::rename(place(path), place(path + ".kept"));
    fs::rename(place(path + ".dpkg-new"), place(path));
  }
  /// `mark`: behind the name of the library.
  void maps(const std::string& mark, const std::string& more = "") const {
    write("/proc/self/maps",
          std::string("5580c0000000-5580c0100000 r--p 00000000 fe:01 11 ") + kProgram + "\n" +
              "5580c0100000-5580c0200000 r-xp 00100000 fe:01 11 " + kProgram + "\n" +
              "7f0000000000-7f0000100000 r-xp 00000000 fe:01 12                         " + kDds + mark +
              "\n7f0000200000-7f0000300000 rw-p 00000000 00:00 0 \n"
              "7ffd00000000-7ffd00021000 rw-p 00000000 00:00 0                          [stack]\n"
              "7ffd00022000-7ffd00024000 r-xp 00000000 00:00 0                          [vdso]\n" +
              more);
  }
  ReplacedFiles files(const std::string& package = "1.0-1") const { return {root_, package}; }

  const fs::path root_;
};

TEST_F(ReplacedOnDisk, NothingIsSaidOfWhatIsAsItWas) {
  EXPECT_EQ(files().look(), PendingRestart());
}

TEST_F(ReplacedOnDisk, AnotherVersionOfThePackage) {
  const ReplacedFiles running = files();
  version("1.1-1");
  maps(" (deleted)");
  replace(kProgram);
  const PendingRestart found = running.look();
  EXPECT_EQ(found.installed_version, "1.1-1");
  EXPECT_EQ(found.reason,
            "cansyncd 1.1-1 is installed, 1.0-1 runs; replaced on disk since the start: libddsc.so.0debian");
}

TEST_F(ReplacedOnDisk, ALibraryAlone) {
  const ReplacedFiles running = files();
  maps(" (deleted)");
  const PendingRestart found = running.look();
  EXPECT_EQ(found.installed_version, "");
  EXPECT_EQ(found.reason, "replaced on disk since the start: libddsc.so.0debian");
}

// A name that another file has taken, without the kernel's mark: the old file still has a name elsewhere.
TEST_F(ReplacedOnDisk, AnotherFileUnderTheSameName) {
  const ReplacedFiles running = files();
  replace(kDds);
  EXPECT_EQ(running.look().reason, "replaced on disk since the start: libddsc.so.0debian");
}

TEST_F(ReplacedOnDisk, TheSameVersionInstalledAgain) {
  const ReplacedFiles running = files();
  replace(kProgram);
  EXPECT_EQ(running.look().reason, "replaced on disk since the start: cansyncd");
}

TEST_F(ReplacedOnDisk, AProgramThatIsFromNoPackageHasNoVersionToCompare) {
  const ReplacedFiles running = files("");
  version("9.9-1");
  EXPECT_EQ(running.look(), PendingRestart());
}

TEST_F(ReplacedOnDisk, AVersionFileThatIsMissingSaysNothing) {
  const ReplacedFiles running = files();
  fs::remove(place(ReplacedFiles::kVersionFile));
  EXPECT_EQ(running.look(), PendingRestart());
}

TEST_F(ReplacedOnDisk, WhatIsNoFileOfAPackageIsLeftOut) {
  const ReplacedFiles running = files();
  maps("",
       "7f0000400000-7f0000500000 r-xp 00000000 fe:01 13 /home/me/build/cansyncd (deleted)\n"
       "7f0000600000-7f0000700000 rw-s 00000000 00:01 14 /memfd:pages (deleted)\n"
       "7f0000800000-7f0000900000 r--p 00000000 fe:01 15 /usr/lib/locale/locale-archive (deleted)\n");
  EXPECT_EQ(running.look(), PendingRestart());
}

TEST_F(ReplacedOnDisk, AMapThatCannotBeReadSaysNothing) {
  const ReplacedFiles running = files();
  fs::remove(place("/proc/self/maps"));
  EXPECT_EQ(running.look(), PendingRestart());
}

}  // namespace
}  // namespace cansyncd
