#pragma once

/// Every function block of the CANsync master (docs/client-library.md).
#include "function_blocks/bc_ma.h"
#include "function_blocks/comm_control_ma.h"
#include "function_blocks/controlword_ma.h"
#include "function_blocks/init.h"
#include "function_blocks/mode_ma.h"
#include "function_blocks/par_read_ma.h"
#include "function_blocks/par_write_ma.h"
#include "function_blocks/pd_cfg_ma.h"
#include "function_blocks/pd_cfg_read_ma.h"
#include "function_blocks/pd_comm_ma.h"
#include "function_blocks/pd_comm_read_ma.h"
#include "function_blocks/updownload_ma.h"
