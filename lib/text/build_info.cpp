#include "text/build_info.h"

#include "build_commit.h"  // made at each build by build_commit.cmake

namespace text {

std::string_view build_text() noexcept {
  return CANSYNC_VERSION " (" CANSYNC_BUILD_COMMIT ", " CANSYNC_BUILD_TYPE ")";
}

std::string_view package_version() noexcept {
  return CANSYNC_BUILD_PACKAGE;
}

}  // namespace text
