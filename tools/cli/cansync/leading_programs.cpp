#include "cli/cansync/leading_programs.h"

#include <fmt/format.h>

#include <bit>
#include <iterator>
#include <string_view>

#include "cli/text/values.h"

namespace cansync::cli {
namespace {

constexpr std::uint16_t kLastWithoutSync = 0x0003;  // w_OPTION_STATUS: 0x0001 to 0x0003 are stop

std::string gives(std::string_view writer, std::string_view telegrams) {
  return fmt::format("{} gives the reference values of {}", writer, telegrams);
}

std::string writers_of(const client::MasterStatus& status) {
  const std::string_view one = status.reference_release[0].writer;
  const std::string_view two = status.reference_release[1].writer;
  if (!one.empty() && one == two) return gives(one, "telegrams 1 and 2");
  std::string text = one.empty() ? "" : gives(one, "telegram 1");
  if (!two.empty()) text += (text.empty() ? "" : ", ") + gives(two, "telegram 2");
  return text;
}

}  // namespace

std::string leading_writers(const client::MasterStatus& status) {
  return status.option_status <= kLastWithoutSync ? "" : writers_of(status);
}

std::string leading_programs(const client::MasterStatus& status) {
  std::string writers = leading_writers(status);
  if (writers.empty() || status.slaves_released == 0) return writers;
  const bool several = std::popcount(status.slaves_released) > 1;
  return fmt::format("{}; {} {} {} a fault without them", writers, several ? "slaves" : "slave",
                     format_slave_set(status.slaves_released), several ? "report" : "reports");
}

}  // namespace cansync::cli
