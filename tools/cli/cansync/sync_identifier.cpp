#include "cli/cansync/sync_identifier.h"

#include <fmt/format.h>

#include "can/typed/identifier.h"
#include "cli/cansync/trace_text.h"
#include "cli/text/values.h"

namespace cansync::cli {

std::uint32_t parse_sync_identifier(const std::string& text, Output& output) {
  if (text.empty()) return kSyncIdentifier;
  const auto identifier = can::typed_identifier(text);
  if (!identifier || identifier->extended)
    throw UsageError(fmt::format(
        "--sync: found '{}'; allowed: an identifier, hexadecimal as candump prints it: 000..7FF, or 0x0..0x7FF",
        text));
  if (const std::string said = can::read_as_hexadecimal(text); !said.empty())
    output.remark("--sync: " + said);
  return identifier->value;
}

}  // namespace cansync::cli
