#include "client/src/function_blocks/layer2/saia_checks.h"

#include <fmt/format.h>

#include "can/frame.h"

namespace cansync::client::function_blocks {

std::string no_object(INT number) {
  return fmt::format("client: ObjID {}: no such object; allowed 0..31", number);
}

std::string wrong_identifier(DWORD identifier, bool extended) {
  return fmt::format("client: MsgID 0x{:X}: allowed 0..0x{:X}{}", identifier,
                     extended ? can::kExtendedIdentifierMask : can::kStandardIdentifierMask,
                     extended ? "" : ", or with IDE up to 0x1FFFFFFF");
}

std::string not_set_up(INT number, const char* what) {
  return fmt::format(
      "client: ObjID {}: it is not set up as one that {}, or belongs to the mapping (28, 29) or "
      "the queues (30, 31); call CAN_CFGO, also after another start of the daemon",
      number, what);
}

std::string not_asked(bool full, const std::string& problem) {
  return full ? "client: too many requests are open; call again when some have ended" : "client: " + problem;
}

std::string not_loaded(INT number) {
  return fmt::format("client: DBNr {}: not loaded; call FrameConnection::load_data_block first", number);
}

}  // namespace cansync::client::function_blocks
