#include "cli/cansync/leading_programs.h"

#include <gtest/gtest.h>

#include <cstdio>

namespace cansync::cli {
namespace {

constexpr const char* kPlc = "'plc' (plc, process 123 on host cab)";

/// A master in run with slaves 0 to 3 that follow.
client::MasterStatus running_master() {
  client::MasterStatus status{};
  status.option_status = 0x0080;
  status.slaves_released = 0b1111;
  return status;
}

void give(client::MasterStatus& status, unsigned telegram, const char* writer) {
  std::snprintf(status.reference_release[telegram].writer, sizeof status.reference_release[telegram].writer,
                "%s", writer);
}

TEST(LeadingPrograms, NamesTheWriterAndTheSlavesThatFault) {
  client::MasterStatus status = running_master();
  EXPECT_EQ(leading_programs(status), "") << "no program gives values";
  give(status, 1, kPlc);
  EXPECT_EQ(leading_programs(status),
            std::string(kPlc) +
                " gives the reference values of telegram 2; slaves 0-3 report a fault without them");
  give(status, 0, kPlc);
  status.slaves_released = 0b100;
  EXPECT_EQ(leading_programs(status),
            std::string(kPlc) +
                " gives the reference values of telegrams 1 and 2; slave 2 reports a fault without them");
  give(status, 0, "'cansync' (cansync, process 7 on host cab)");
  EXPECT_NE(
      leading_programs(status).find("process 7 on host cab) gives the reference values of telegram 1, 'plc'"),
      std::string::npos);
}

TEST(LeadingPrograms, WithoutSyncNoProgramLeads) {
  client::MasterStatus status = running_master();
  give(status, 0, kPlc);
  for (std::uint16_t stopped = 1; stopped <= 3; ++stopped) {
    status.option_status = stopped;
    EXPECT_EQ(leading_programs(status), "") << stopped;
  }
  status.option_status = 0x0043;  // setup: SYNC runs
  EXPECT_NE(leading_programs(status), "");
}

}  // namespace
}  // namespace cansync::cli
