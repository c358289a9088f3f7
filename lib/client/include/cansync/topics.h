#pragma once

#include "cansync.h"
#include "gateway.h"
#include "types.h"

/// The structs of the data model behind `MasterStatus`, `ActualValues` and the other topics of types.h, and
/// its constants (docs/dds-api.md), for programs that look into them. They are generated: no other header of
/// the library includes them, or Cyclone DDS's headers, which they need.
