#include "config/document.h"

#include <gtest/gtest.h>

#include <string>

namespace {

using config::Content;
using config::Document;
using config::Node;

TEST(ConfigDocument, EveryValueHasItsPlace) {
  const Document document = config::parse_document("[a]\nb = [1, \"x\"]\n", "f");
  ASSERT_EQ(document.nodes.size(), 2u);
  const Node& value = document.nodes[1];
  EXPECT_EQ(value.name(), "b");
  EXPECT_EQ(value.value.text, "[1, \"x\"]");
  EXPECT_EQ(value.key.line, 2u);
  EXPECT_EQ(value.key.column, 1u);
  EXPECT_EQ(value.where.column, 5u);
  ASSERT_EQ(value.items.size(), 2u);
  EXPECT_EQ(value.items[1].column, 9u);
}

TEST(ConfigDocument, ContentIsWhatStandsDirectlyInASection) {
  const Document document = config::parse_document(
      "top = 1\n[[a]]\nx = 1\n[[a.inner]]\ny = 1\n[[a.inner]]\n[[a]]\nx = 2\nz = 3\n[b]\nx = 4\n", "f");
  const Content root(document, nullptr);
  ASSERT_EQ(root.nodes().size(), 3u);
  EXPECT_EQ(root.find("top")->value.text, "1");
  EXPECT_EQ(root.find("b")->kind, Node::Kind::section);
  EXPECT_EQ(root.find("x"), nullptr);
  const auto sections = root.each("a");
  ASSERT_EQ(sections.size(), 2u);
  const Content first(document, sections[0]);
  EXPECT_EQ(first.nodes().size(), 2u) << "x, and inner once";
  EXPECT_EQ(first.each("inner").size(), 2u);
  EXPECT_EQ(first.where().line, 2u);
  const Content second(document, sections[1]);
  EXPECT_EQ(second.find("x")->value.text, "2");
  EXPECT_EQ(second.nodes().size(), 2u);
}

TEST(ConfigDocument, EachKindOfFileHasItsWords) {
  constexpr config::Wording kWording{
      .unreadable = "not readable: ", .no_toml = "no TOML: ", .allowed = "recipes"};
  const auto first = [&](const std::string& toml) {
    return config::problems_text(config::parse_document(toml, "f", kWording).problems);
  };
  EXPECT_TRUE(first("[a\n").starts_with("f:1:3: no TOML: ")) << first("[a\n");
  EXPECT_TRUE(first("[a\n").ends_with("; allowed: recipes\n")) << first("[a\n");
  std::string deep = "a";
  for (int i = 0; i < 20; ++i) deep += ".a";
  EXPECT_EQ(first(deep + " = 1\n"), "f:1:2: found a key of more than 16 parts; allowed: recipes\n");
  EXPECT_EQ(config::problems_text(config::read_document("/", kWording).problems),
            "/: not readable: it is a folder\n");
}

TEST(ConfigDocument, AFileOfAnotherEncodingIsToBeSavedAsUtf8) {
  const auto first = [](const std::string& toml) {
    return config::problems_text(config::parse_document(toml, "f").problems);
  };
  for (const std::string& start :
       {std::string("\xFF\xFE") + std::string("[\0", 2), std::string("\xFE\xFF\0[", 4),
        std::string("[\0b\0", 4), std::string("\0[\0b", 4)}) {
    EXPECT_NE(first(start).find("the file is UTF-16; save it as UTF-8"), std::string::npos) << first(start);
    EXPECT_TRUE(first(start).starts_with("f:1:1: ")) << first(start);
  }
  const std::string latin = first("a = \"\xE4\"\n");
  EXPECT_NE(latin.find("save the file as UTF-8"), std::string::npos) << latin;
  EXPECT_EQ(first("a = \"\xC3\xA4\"\n"), "");
}

/// The lines of [[a]] in a document that is read in part, and those of its problems.
std::string in_part(std::string_view toml) {
  const config::Document document = config::parse_document_in_part(toml, "f");
  std::string text;
  for (const Node* node : Content(document, nullptr).each("a"))
    text += std::to_string(node->where.line) + " ";
  text += "/";
  for (const config::Problem& problem : document.problems) text += " " + std::to_string(problem.where.line);
  return text;
}

TEST(ConfigDocument, InPartASectionThatIsNoTomlIsLeftOutAlone) {
  EXPECT_EQ(in_part("[[a]]\nx = 1\n[[a]]\nx = 2\n"), "1 3 /");
  EXPECT_EQ(in_part("[[a]]\nx = 1\n[[a]]\nx =\n[[a]]\nx = 3\n"), "1 5 / 4");
  EXPECT_EQ(in_part("[[a]]\nx = 1\n[[a]\nx = 2\n[[a]]\nx = 3\n"), "1 5 / 3");
  EXPECT_EQ(in_part("[[a]]\nx = \"open\n[[a]]\nx = 2\n"), "3 / 2");
  EXPECT_EQ(in_part("[[a]]\nx = [\"open\"\n[[a]]\nx = 2\n[[a]]\nx = 3\n"), "3 5 / 3")
      << "the list that does not end is to blame, and not the header in which that shows";
  EXPECT_EQ(in_part("nonsense\n[[a]]\nx = 1\n"), "2 / 1");
  EXPECT_EQ(in_part("nonsense\n"), "/ 1");
  EXPECT_EQ(in_part("[[a]]\nx = 1\nx = 2\n[[a]]\nx = 3"), "4 / 3");
  EXPECT_EQ(in_part(""), "/");
}

TEST(ConfigDocument, AFileOfAnotherKindIsNamed) {
  const auto said = [](std::string_view text) {
    const config::Document document = config::parse_document(text, "f");
    return document.problems.empty() ? std::string() : to_string(document.problems.front());
  };
  EXPECT_NE(
      said("version https://git-lfs.github.com/spec/v1\noid sha256:00\n")
          .find("this is not TOML: it looks like a Git LFS pointer; fetch the file itself: git lfs pull; "
                "allowed: "),
      std::string::npos);
  EXPECT_NE(said("{\"a\": 1}\n").find("it looks like JSON; allowed: "), std::string::npos)
      << "no way to convert it";
  EXPECT_NE(said("<?xml version=\"1.0\"?>\n").find("it looks like XML or HTML; allowed"), std::string::npos);
  EXPECT_NE(said(std::string_view("\x1F\x8B\x08\x00", 4)).find("a gzip archive; unpack it first"),
            std::string::npos);
  EXPECT_EQ(said("date = 1\nx =\n").find("it looks like"), std::string::npos);
}

TEST(ConfigProblems, LongListsOfWhatIsAllowedAreToldOnce) {
  const std::string list(120, 'x');
  const std::vector<config::Problem> problems = {{{"f", 1, 1}, "a", "no such option; allowed: " + list},
                                                 {{"f", 2, 1}, "b", "no such option; allowed: " + list},
                                                 {{"f", 3, 1}, "c", "no such option; allowed: y" + list},
                                                 {{"f", 4, 1}, "d", "found 5; allowed: 1..4"},
                                                 {{"f", 5, 1}, "e", "found 6; allowed: 1..4"}};
  EXPECT_EQ(config::problems_text(problems),
            "f:1:1: a: no such option; allowed: " + list +
                "\nf:2:1: b: no such option; allowed: as above\nf:3:1: c: no such option; allowed: y" + list +
                "\nf:4:1: d: found 5; allowed: 1..4\nf:5:1: e: found 6; allowed: 1..4\n");
}

TEST(ConfigProblems, AreToldInTheOrderOfTheFile) {
  std::vector<config::Problem> problems = {
      {{"f", 2, 1}, "b", "two"}, {{"f", 1, 9}, "", "one"}, {{"f"}, "", "zero"}};
  config::sort_by_place(problems);
  EXPECT_EQ(config::problems_text(problems), "f: zero\nf:1:9: one\nf:2:1: b: two\n");
  problems.resize(config::kProblemsShown + 2, problems.back());
  EXPECT_TRUE(config::problems_text(problems).ends_with("and 2 more problems\n"));
}

}  // namespace
