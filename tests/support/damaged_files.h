#pragma once

#include <cstdlib>

namespace test {

/// How many damaged files a generator makes: as many as CANSYNC_DAMAGED_FILES says, `usual` without it.
inline unsigned damaged_files(unsigned usual) {
  const char* const wanted = std::getenv("CANSYNC_DAMAGED_FILES");  // NOLINT(concurrency-mt-unsafe)
  return wanted == nullptr ? usual : static_cast<unsigned>(std::strtoul(wanted, nullptr, 10));
}

}  // namespace test
