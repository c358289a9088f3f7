#pragma once

#include <cansync/cansync_c_slave.h>

#include "cansync_slave.h"

/// From the data model to the plain structs of the C face of a slave. Pure. Internal to lib/client.
namespace cansync::client::c_face {

cansync_slave_event event_of(const cansync_slave_ReferencesReceived& sample);
cansync_slave_event event_of(const cansync_slave_MonitoredValues& sample);
cansync_slave_event event_of(const cansync_slave_ActionReceived& sample);
cansync_slave_event event_of(const cansync_slave_ParameterJob& sample);
cansync_slave_event event_of(const cansync_slave_BlockJob& sample);
cansync_slave_state state_of(const cansync_slave_SlaveSideStatus& status);

}  // namespace cansync::client::c_face
