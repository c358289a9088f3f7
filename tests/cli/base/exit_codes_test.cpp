#include "cli/base/exit_codes.h"

#include <gtest/gtest.h>

#include <string>

namespace cansync::cli {
namespace {

using client::ReplyCode;

TEST(ExitCodes, FollowFromTheReply) {
  const std::pair<ReplyCode, int> table[] = {
      {ReplyCode::done, 0},           {ReplyCode::refused, 3},        {ReplyCode::slave_error, 4},
      {ReplyCode::word_expected, 4},  {ReplyCode::timeout, 5},        {ReplyCode::doubleword_expected, 4},
      {ReplyCode::no_answer, 5},      {ReplyCode::value_too_wide, 4}, {ReplyCode::cancelled, 7},
      {ReplyCode::master_stopped, 7}, {ReplyCode::no_reply, 6},       {ReplyCode::slave_lost, 5},
      {ReplyCode::replaced, 7},       {ReplyCode::no_daemon, 6},
  };
  for (const auto& [code, exit] : table)
    EXPECT_EQ(static_cast<int>(exit_code(code)), exit) << client::name(code);
}

TEST(ExitCodes, AreAllInTheHelp) {
  const std::string help = exit_code_help();
  for (int code = 0; code <= 9; ++code)
    EXPECT_NE(help.find("\n  " + std::to_string(code) + "  "), std::string::npos) << code;
}

}  // namespace
}  // namespace cansync::cli
