// The profiles of this project are right, and that of the simulated drive says what the simulated drive does.
#include <gtest/gtest.h>

#include <filesystem>

#include "cansync/sim/drive_parameters.h"
#include "profile/reader.h"

namespace profile {
namespace {

namespace fs = std::filesystem;
using Definition = sim::ParameterDefinition;

Access access_of(const Definition& definition) {
  switch (definition.access) {
    case Definition::Access::read_write:
      return Access::read_write;
    case Definition::Access::read_only:
      return Access::read_only;
    case Definition::Access::not_available:
      break;
  }
  return Access::none;
}

TEST(ShippedProfiles, AreRight) {
  int files = 0;
  for (const auto& entry : fs::directory_iterator(CANSYNC_SOURCE_DIR "/config/profiles")) {
    EXPECT_EQ(problems_text(read(entry.path().string()).problems, entry.path().string()), "");
    ++files;
  }
  EXPECT_EQ(files, 2);
}

TEST(ShippedProfiles, TheSimulatedDriveHasExactlyTheseParameters) {
  const Reading reading = read(CANSYNC_SOURCE_DIR "/config/profiles/simulated-drive.toml");
  ASSERT_TRUE(reading.profile);
  const std::vector<Definition> definitions = sim::standard_parameters();
  EXPECT_EQ(reading.profile->parameters.size(), definitions.size());
  for (const Definition& definition : definitions) {
    SCOPED_TRACE(definition.number);
    const Parameter* parameter = reading.profile->find(definition.number);
    ASSERT_NE(parameter, nullptr);
    EXPECT_EQ(parameter->format == Format::doubleword, definition.doubleword);
    EXPECT_EQ(parameter->access, access_of(definition));
    EXPECT_EQ(parameter->limited, definition.limited);
    if (!definition.limited) continue;
    EXPECT_EQ(parameter->minimum, definition.minimum);
    EXPECT_EQ(parameter->maximum, definition.maximum);
    EXPECT_EQ(parameter->is_signed, definition.minimum < 0);
  }
}

}  // namespace
}  // namespace profile
