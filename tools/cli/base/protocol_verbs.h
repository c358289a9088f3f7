#pragma once

#include <span>
#include <string_view>

#include "cli/base/status_part.h"
#include "cli/base/verbs.h"

namespace cansync::cli {

/// A verb that had another name: it still works, and says the new one.
struct FormerVerb {
  std::string_view was;       ///< one word
  std::string_view protocol;  ///< first word of the new name
  std::string_view verb;      ///< second word
};

/// What a protocol adds to the command line.
struct ProtocolVerbs {
  AddVerbs add;              ///< its verbs
  const StatusPart* status;  ///< what `status` shows of it; null: nothing, its buses are of other protocols
  std::span<const FormerVerb> former = {};  ///< of its verbs
};

/// The verb of a protocol below which its verbs are.
inline CLI::App& add_protocol_verb(CLI::App& app, const char* name, const char* description,
                                   const char* group) {
  CLI::App* verb = app.add_subcommand(name, description);
  verb->group(group);
  verb->require_subcommand(1);
  return *verb;
}

}  // namespace cansync::cli
