#include "cli/connect/bus_connection.h"

namespace cansync::cli {

gateway::dds::ClientOptions domain_options(Session& session) {
  const Globals& globals = session.globals();
  gateway::dds::ClientOptions options;
  options.domain = globals.domain;
  options.interface = globals.interface;
  options.client_name = "cansync";
  options.security = globals.security;
  options.final_types = globals.final_types;
  options.wait = session.search_time();
  options.stop = &interrupt_flag();
  return options;
}

gateway::dds::ClientOptions bus_options(Session& session) {
  gateway::dds::ClientOptions options = domain_options(session);
  options.bus = session.bus();
  return options;
}

}  // namespace cansync::cli
