#pragma once

#include <cansync/function_blocks/types.h>

#include <string>

/// Checks that SFB 400 to 413 share. Internal to the function blocks.
namespace cansync::client::function_blocks {

/// Why a PortID is refused.
inline constexpr const char* kOnlyPort = "client: PortID: allowed 0";
/// Numbers of data blocks: 1..32767.
inline constexpr const char* kBlockNumbers = "client: DBNr: allowed 1..32767";

/// The number of an organisation block for interrupts (Saia 4.2).
constexpr bool is_routine(INT number) noexcept {
  return number >= 40 && number <= 47;
}

/// The number of a message object (Saia 4.2.2).
constexpr bool is_object(INT number) noexcept {
  return number >= 0 && number <= 31;
}

/// Why an ObjID is refused.
std::string no_object(INT number);
/// Why a MsgID is refused that its width has no room for.
std::string wrong_identifier(DWORD identifier, bool extended);
/// Why access to an object is denied that does not do what is wanted: "sends", "receives".
std::string not_set_up(INT number, const char* what);
/// Why the daemon was not asked: too many requests are open, or one could not be written.
std::string not_asked(bool full, const std::string& problem);
/// A data block is not loaded.
std::string not_loaded(INT number);

}  // namespace cansync::client::function_blocks
