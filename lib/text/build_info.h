#pragma once

#include <string_view>

/// What a program was built of. Pure; any thread.
namespace text {

/// "0.1.0 (3f2a1bc, RelWithDebInfo)": the version, the commit (with `-dirty` when files were changed) or the
/// version of the package, and the build type.
std::string_view build_text() noexcept;

/// Version of the package that the program was built for, as "0.1.0-1"; empty: it was built for none.
std::string_view package_version() noexcept;

}  // namespace text
