#pragma once

/// Headings of the verbs in `cansync --help`, those of docs/command-line-verbs.md. A protocol's own stand in
/// its folder. Each verb names its group (`CLI::App::group`); a test finds one that does not.
namespace cansync::cli {

inline constexpr const char* kLookingVerbs = "Looking at the line";
inline constexpr const char* kParameterVerbs = "Parameters and transfers";
inline constexpr const char* kSetVerbs = "Parameter sets";
inline constexpr const char* kCommandVerbs = "Commands";
inline constexpr const char* kValueVerbs = "Values and polling";
inline constexpr const char* kManyVerbs = "Many commands";

}  // namespace cansync::cli
