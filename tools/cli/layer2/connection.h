#pragma once

#include "cli/base/session.h"
#include "layer2/client/frame_client.h"

namespace cansync::cli {

/// A connection to the daemon of a bus of general frames. Throws client::NoDaemon, client::SetupError,
/// Interrupted, ArgumentsAreRight.
layer2::client::FrameClient connect_frames(Session& session);

}  // namespace cansync::cli
