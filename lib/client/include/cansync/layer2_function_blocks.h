#pragma once

/// The function blocks of layer 2: FC 65 to 67 of a CAN 300 PRO, SFB 400 to 413 of a Saia PCD
/// (docs/client-library.md).
#include "function_blocks/layer2/can_cfg.h"
#include "function_blocks/layer2/can_cfgo.h"
#include "function_blocks/layer2/can_cfgq.h"
#include "function_blocks/layer2/can_dmap.h"
#include "function_blocks/layer2/can_rx.h"
#include "function_blocks/layer2/can_rxq.h"
#include "function_blocks/layer2/can_stat.h"
#include "function_blocks/layer2/can_tx.h"
#include "function_blocks/layer2/can_txq.h"
#include "function_blocks/layer2/canctrl.h"
#include "function_blocks/layer2/canrcv.h"
#include "function_blocks/layer2/cansend.h"
#include "function_blocks/layer2/data_blocks.h"
