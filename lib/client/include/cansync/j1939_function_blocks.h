#pragma once

/// The function blocks of SAE J1939 of a CAN 300 PRO (docs/client-library.md).
#include "function_blocks/j1939/canrcv_sae_j1939.h"
#include "function_blocks/j1939/cansend_sae_j1939.h"
