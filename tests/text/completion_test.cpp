#include "text/completion.h"

#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace text {
namespace {

/// A program with two verbs, options of its own and of a verb, and every kind of argument.
class Completions : public testing::Test {
 protected:
  Completions() {
    app_.add_option("--bus", text_)->type_name("BUS");
    app_.add_flag("--json", flag_);
    auto* read = app_.add_subcommand("read", "");
    read->add_option("SLAVE", text_);
    read->add_option("STATE", text_)->type_name("on|off");
    read->add_option("FILE", list_);
    read->add_option("--priority", text_)->type_name("0|1|2");
    read->add_flag("-q,--quiet", flag_);
    app_.add_subcommand("record", "")->add_option("CHANNEL WHO", list_);
  }

  std::string at(std::vector<std::string_view> words) {
    return completions(app_, words, [this](std::string_view placeholder, const TypedLine& line) {
      asked_ = placeholder;
      line_ = line;
      return std::vector<std::string>{"3", "winder", "winch"};
    });
  }

  CLI::App app_;
  std::string text_;
  std::vector<std::string> list_;
  bool flag_ = false;
  std::string asked_;
  TypedLine line_;
};

TEST_F(Completions, VerbsComeFirst) {
  EXPECT_EQ(at({""}), "read\nrecord\n");
  EXPECT_EQ(at({"rec"}), "record\n");
  EXPECT_EQ(at({}), "read\nrecord\n");
  EXPECT_EQ(at({"--json", "--bus", "read", "rea"}), "read\n");
  EXPECT_EQ(at({"write", ""}), "");
}

TEST_F(Completions, OptionsOfTheVerbAndOfTheProgram) {
  EXPECT_EQ(at({"--"}), "--bus\n--help\n--json\n");
  EXPECT_EQ(at({"read", "--"}), "--bus\n--help\n--json\n--priority\n--quiet\n");
  EXPECT_EQ(at({"read", "3", "--q"}), "--quiet\n");
}

TEST_F(Completions, AVerbMayHaveASecondWord) {
  CLI::App app;
  auto* can = app.add_subcommand("can", "");
  can->add_option("ACTION", text_)->type_name("run|stop");
  can->add_subcommand("dump", "")->add_flag("--candump", flag_);
  const auto offered = [&app](std::vector<std::string_view> words) { return completions(app, words); };
  EXPECT_EQ(offered({"can", ""}), "dump\nrun\nstop\n");
  EXPECT_EQ(offered({"can", "dump", "--c"}), "--candump\n");
  EXPECT_EQ(offered({"can", "dump", ""}), "");
  EXPECT_EQ(offered({"can", "run", ""}), "");
  EXPECT_EQ(offered({"dump", ""}), "");
}

TEST_F(Completions, ValuesOfOptions) {
  EXPECT_EQ(at({"read", "--priority", ""}), "0\n1\n2\n");
  EXPECT_EQ(at({"read", "--priority=1"}), "--priority=1\n");
  EXPECT_EQ(at({"read", "--bus", "x"}), ":buses\n");
  EXPECT_EQ(at({"read", "--quiet="}), "");
  EXPECT_EQ(at({"read", "--nothing="}), "");
}

TEST_F(Completions, ArgumentsInTheirOrder) {
  EXPECT_EQ(at({"read", ""}), "3\nwinder\nwinch\n");
  EXPECT_EQ(asked_, "SLAVE");
  EXPECT_EQ(at({"read", "wi"}), "winder\nwinch\n");
  EXPECT_EQ(at({"read", "3", "o"}), "on\noff\n");
  EXPECT_EQ(at({"read", "-1", "on", "x"}), ":files\n");
  EXPECT_EQ(at({"read", "3", "on", "-", "x", ""}), ":files\n");
  EXPECT_EQ(at({"read", "3", "--", "--o"}), "");
  EXPECT_EQ(at({"read", "--", "3", "o"}), "on\noff\n");
}

TEST_F(Completions, ArgumentsThatComeByTurns) {
  at({"record", "1", ""});
  EXPECT_EQ(asked_, "WHO");
  at({"record", "1", "3", ""});
  EXPECT_EQ(asked_, "CHANNEL");
}

TEST_F(Completions, TheLastPartOfAList) {
  EXPECT_EQ(at({"read", "0,4-7,wind"}), "0,4-7,winder\n");
}

TEST_F(Completions, TheLookupSeesWhatWasTyped) {
  at({"--bus", "can1", "read", "-q", ""});
  EXPECT_EQ(line_.verb, "read");
  EXPECT_EQ(line_.options.at("--bus"), "can1");
  at({"read", "--bus=can2", ""});
  EXPECT_EQ(line_.options.at("--bus"), "can2");
  at({"record", "1", ""});
  EXPECT_EQ(line_.arguments, std::vector<std::string>{"1"});
}

TEST_F(Completions, WithoutALookupWhatIsKnownStays) {
  const std::vector<std::string_view> words{"read", ""};
  EXPECT_EQ(completions(app_, words), "");
}

TEST(WordsToComplete, AreThoseAfterTheOptionThatStandsFirst) {
  const char* const asked[] = {"p", "--complete", "read", ""};
  EXPECT_EQ(words_to_complete(4, asked), (std::vector<std::string_view>{"read", ""}));
  const char* const late[] = {"p", "read", "--complete", ""};
  EXPECT_TRUE(words_to_complete(4, late).empty());
  EXPECT_TRUE(words_to_complete(2, asked).empty());
}

}  // namespace
}  // namespace text
