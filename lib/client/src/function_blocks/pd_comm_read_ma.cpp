#include <cansync/function_blocks/pd_comm_read_ma.h>

namespace cansync::client::function_blocks {

void PD_COMM_READ_MA::call() {
  const ActualValueInbox::News news = inbox_.take();
  si_RD_SL_NR1_RECEIVED = si_RD_SL_NR2_RECEIVED = 0;
  if (si_SL_NR < 0 || static_cast<std::size_t>(number(si_SL_NR)) >= news.arrived.size()) return;
  const auto slave = static_cast<std::size_t>(number(si_SL_NR));
  if ((news.arrived[slave] & 1u) != 0) si_RD_SL_NR1_RECEIVED = 1;
  if ((news.arrived[slave] & 2u) != 0) si_RD_SL_NR2_RECEIVED = 2;
  for (std::size_t i = 0; i < a_RD_VALUES.size(); ++i) {
    if (((news.arrived[slave] >> (i / 4)) & 1u) != 0) a_RD_VALUES[i] = news.values[slave][i];
  }
}

}  // namespace cansync::client::function_blocks
