#include "cli/layer2/verbs.h"

#include "cli/layer2/configure_verb.h"
#include "cli/layer2/control_verbs.h"
#include "cli/layer2/dump_verb.h"
#include "cli/layer2/image_verb.h"
#include "cli/layer2/objects_verb.h"
#include "cli/layer2/script_verb.h"
#include "cli/layer2/send_verb.h"
#include "cli/layer2/state_verbs.h"
#include "cli/layer2/status_part.h"

namespace cansync::cli {
namespace {

void add_verbs_of_layer2(CLI::App& app, Verb& chosen) {
  CLI::App& can = add_can_verb(app, chosen);
  for (const AddVerbs add : {add_dump_verb, add_send_verb, add_queues_verb, add_timers_verb, add_script_verb,
                             add_objects_verb, add_image_verb, add_lead_verb, add_configure_verb})
    add(can, chosen);
}

}  // namespace

const ProtocolVerbs layer2_verbs = {add_verbs_of_layer2, &kFrameStatusPart};

}  // namespace cansync::cli
