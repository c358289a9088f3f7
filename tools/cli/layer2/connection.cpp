#include "cli/layer2/connection.h"

#include "cli/base/interrupt.h"

namespace cansync::cli {

layer2::client::FrameClient connect_frames(Session& session) {
  session.expect_input("");  // a batch that only checks its lines goes no further
  const Globals& globals = session.globals();
  layer2::client::Options options;
  options.domain = globals.domain;
  options.bus = globals.bus;
  options.interface = globals.interface;
  options.client_name = "cansync";
  options.security = globals.security;
  options.final_types = globals.final_types;
  options.wait = session.search_time();
  options.stop = &interrupt_flag();
  try {
    return layer2::client::FrameClient(options);
  } catch (const layer2::client::NoDaemon& error) {
    if (interrupt_flag().load()) throw Interrupted();
    throw client::NoDaemon(error.what());
  } catch (const gateway::dds::SetupError& error) {
    throw client::SetupError(error.what());
  }
}

}  // namespace cansync::cli
