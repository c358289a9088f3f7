#include "config/reload.h"

#include <gtest/gtest.h>

#include "bakery.h"

namespace {

using Keys = std::vector<std::string>;

config::Changes compare(const std::string& before, const std::string& after, bool applies = true) {
  return config::compare(bakery::read(before).items, bakery::read(after).items,
                         [=](const config::Setting&) { return applies; });
}

TEST(ConfigReload, WhatMayChangeTakesEffectAndTheRestWaits) {
  const config::Changes changes = compare("[shop]\nloaves = 3\n", "[shop]\nloaves = 4\nopen = false\n");
  EXPECT_EQ(changes.applied, Keys{"shop.open"});
  EXPECT_EQ(changes.needs_restart, Keys{"shop.loaves"});
  ASSERT_EQ(changes.merged.items.size(), 2u);
  EXPECT_EQ(changes.merged.items[0].value.text, "3");
  EXPECT_EQ(changes.merged.items[1].value.text, "false");
}

TEST(ConfigReload, TheOwnerMayHoldAChangeBack) {
  const config::Changes changes = compare("", "[shop]\nopen = false\n", false);
  EXPECT_EQ(changes.needs_restart, Keys{"shop.open"});
  EXPECT_TRUE(changes.merged.items.empty());
}

TEST(ConfigReload, DefaultsAndLabelsAreNoChange) {
  const config::Changes changes = compare(
      "[[oven]]\nnumber = 1\n", "[shop]\nloaves = 12\n[[oven]]\nnumber = 1\n[[oven.tray]]\nnumber = 2\n");
  EXPECT_EQ(changes.applied, Keys{});
  EXPECT_EQ(changes.needs_restart, Keys{});
}

}  // namespace
