#include "config/print.h"

#include <gtest/gtest.h>

#include "bakery.h"

namespace {

TEST(ConfigPrint, TheDefaultFileShowsEveryOptionAndIsTaken) {
  const std::string file = config::default_file(bakery::rows().table(), "# Bakery\n");
  EXPECT_EQ(
      file,
      "# Bakery\n"
      "\n[shop]\n# The shop.\n"
      "# Where it is. And where not. Allowed: 1..8 letters, digits, '_', '.' or '-', in quotes.\n"
      "town = \"Ulm\"\n"
      "# Loaves a day. Allowed: 0..99 loaves.\nloaves = 12\n"
      "# Is it open? Allowed: true or false.\nopen = true\n"
      "# Between two loaves. Allowed: 0..9999 ms.\nrest_ms = 1500\n"
      "# Day without bread. Allowed: \"monday\" or \"sunday\".\nclosed = \"sunday\"\n"
      "# Doors. Allowed: an even number. Default: as the law says.\n# doors = 4\n"
      "\n[[oven]]\n# Once for each oven.\n# Which oven. Allowed: 1..4. Default: required.\nnumber = 1\n"
      "# What heats it. Allowed: \"gas\" or \"wood\".\nheat = \"gas\"\n"
      "\n[[oven.tray]]\n# Which tray. Allowed: 0..9. Default: required.\nnumber = 0\n"
      "# What is on it. Allowed: a string of 1..5 bytes, no digit or '-' first, no ',' or '=', no control\n"
      "# character, no blank at its ends. Default: none.\n# bread = \"rye\"\n");
  EXPECT_EQ(config::problems_text(bakery::read(file).problems), "");
}

TEST(ConfigPrint, TheMarkdownPageHasATableForEachSection) {
  const std::string page = config::options_markdown(bakery::rows().table(), "# Bakery\n");
  EXPECT_TRUE(page.starts_with("# Bakery\n\n## [shop]\nThe shop.\n\n| option | default |")) << page;
  EXPECT_NE(page.find("| `loaves` | `12` | 0..99 loaves | restarting | Loaves a day. |\n"),
            std::string::npos);
  EXPECT_NE(page.find("| `open` | `true` | true or false | running | Is it open? |\n"), std::string::npos);
}

TEST(ConfigPrint, TheManualPageHasASentenceALine) {
  const std::string page = config::options_man(bakery::rows().table(), ".Sh OPTIONS\n");
  EXPECT_NE(page.find(".It Cm town\nWhere it is.\nAnd where not.\nAllowed: 1..8 letters"), std::string::npos)
      << page;
  EXPECT_NE(page.find(".Ss [[oven.tray]]\n.Bl"), std::string::npos) << page;
}

}  // namespace
