#include <cansync/function_blocks/bc_ma.h>
#include <cansync/function_blocks/controlword_ma.h>
#include <cansync/topics.h>

#include <utility>

#include "client/src/function_blocks/slaves.h"

namespace cansync::client::function_blocks {

void CONTROLWORD_MA::call() {
  if (x_EN) {
    if (auto problem = slave_problem(*client_, si_SL_NR_CTRL)) {
      slot_.refuse(problem->cause, std::move(problem->reason));
    } else {
      slot_.enter([slave = static_cast<std::uint32_t>(number(si_SL_NR_CTRL)),
                   word = w_CONTROLWORD](Client& client) { return client.control_word(slave, word); });
    }
  }
  slot_.poll();
  x_OK = slot_.sent();
}

void BroadcastBlock::call() {
  if (x_EN) {
    Broadcast broadcast;
    broadcast.priority = range_;
    broadcast.action = us_BC_CMD_NR;
    broadcast.data_byte = static_cast<std::uint8_t>(si_BC_BYTE);
    broadcast.data_word = static_cast<std::uint16_t>(i_BC_WORD);
    broadcast.slave_mask = d_SL_MASK;
    slot_.enter([broadcast](Client& client) { return client.broadcast(broadcast); });
  }
  slot_.poll();
  x_OK = slot_.sent();
}

}  // namespace cansync::client::function_blocks
