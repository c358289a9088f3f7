// What is printed of the configuration is valid, and says all that there is.
#include <gtest/gtest.h>

#include <regex>
#include <sstream>
#include <string>

#include "cansync/config/options.h"
#include "config_text.h"

namespace cansyncd {
namespace {

TEST(ConfigDocuments, TheDefaultConfigurationIsValidAndChangesNothing) {
  const Config printed = good(config::default_file(options(), master_document_heads.file));
  const Config smallest = good(kSmallest);
  EXPECT_EQ(printed.master.command_channel.parameter_queue, smallest.master.command_channel.parameter_queue);
  EXPECT_EQ(printed.master.configured(), smallest.master.configured());
  EXPECT_EQ(printed.bus.name, smallest.bus.name);
}

TEST(ConfigDocuments, EveryCommentedExampleIsValidToo) {
  std::istringstream lines(config::default_file(options(), master_document_heads.file));
  std::string text;
  // Lines "# key = value" are examples; the array form of mappings stands beside the registers and stays out.
  const std::regex assignment(R"(# [a-z_012]+ = ["\[0-9].*)");
  for (std::string line; std::getline(lines, line);) {
    const bool example = std::regex_match(line, assignment) && line.find("_values_") == std::string::npos &&
                         line.find("_high_") == std::string::npos;
    text += (example ? line.substr(2) : line) + "\n";
  }
  // What reference.start_within needs beside it.
  EXPECT_EQ(good(text, {"process.poll_without_reference=true"}).slaves[0].name, "slave0");
  EXPECT_NE(text.find("\nactual_registers_2 = "), std::string::npos);
}

TEST(ConfigDocuments, EveryOptionIsExplained) {
  for (const Option& option : options().options()) {
    EXPECT_FALSE(option.help.empty()) << option.key;
    EXPECT_FALSE(option.initial.empty()) << option.key;
    EXPECT_TRUE(option.has_initial() || option.numbers_section() || !option.example.empty()) << option.key;
    EXPECT_EQ(option.type == OptionType::other, !option.words.empty()) << option.key;
    EXPECT_EQ(options().find(option.key), &option) << option.key;
  }
}

}  // namespace
}  // namespace cansyncd
