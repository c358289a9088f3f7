#include "cli/cansync/verbs.h"

#include "cli/cansync/status_lines.h"

namespace cansync::cli {
namespace {

void add_verbs_of_cansync(CLI::App& app, Verb& chosen) {
  // In the order of the help.
  for (const AddVerbs add : {add_slaves_verb, add_timing_verb, add_parameter_verbs, add_params_verb,
                             add_passport_verbs, add_restore_verb, add_transfer_verbs, add_command_verbs,
                             add_reference_verb, add_polling_verb, add_mapping_verb}) {
    add(app, chosen);
  }
}

}  // namespace

const ProtocolVerbs cansync_verbs = {add_verbs_of_cansync, &kMasterStatusPart};

}  // namespace cansync::cli
