#include "cli/cansync_cluster/verbs.h"

namespace cansync::cli {

const ProtocolVerbs cansync_cluster_verbs = {[](CLI::App& /*app*/, Verb& /*chosen*/) {}, nullptr};

}  // namespace cansync::cli
