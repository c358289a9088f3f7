#include <cansync/function_blocks/comm_control_ma.h>

#include <string>

namespace cansync::client::function_blocks {

void COMM_CONTROL_MA::call() {
  const auto code = [](SINT number, BOOL enabled) { return enabled ? std::int32_t{number} : kUnchanged; };
  const std::array<std::int32_t, 3> cursors = {code(si_SL_NR_CTRL, x_EN_CTRL), code(si_SL_NR_PAR, x_EN_PAR),
                                               code(si_SL_NR_UDL, x_EN_UDL)};
  if (cursors != cursors_) {
    cursors_ = cursors;
    cursors_slot_.enter([cursors](Client& client) {
      return client.cursors({.control_word = cursors[0], .parameter = cursors[1], .transfer = cursors[2]});
    });
    // -1 and -2 mean something to the daemon that the manual does not know.
    for (const auto& [number, enabled] :
         {std::pair(si_SL_NR_CTRL, x_EN_CTRL), {si_SL_NR_PAR, x_EN_PAR}, {si_SL_NR_UDL, x_EN_UDL}}) {
      if (enabled && number < 0 && number != kAutomaticNumber)
        cursors_slot_.refuse(RefusalCause::field, "client: slave " + std::to_string(number) +
                                                      ": out of range; allowed 0..31, -128 automatic");
    }
  }
  if (si_MAX_SL_NR == -1 && maximum_.value_or(0) < 0) {
    maximum_.reset();
    maximum_slot_.withdraw();
  }
  if (si_MAX_SL_NR != -1 && si_MAX_SL_NR != maximum_) {
    maximum_ = si_MAX_SL_NR;
    if (si_MAX_SL_NR < 0)
      maximum_slot_.refuse(RefusalCause::field, "client: si_MAX_SL_NR " + std::to_string(si_MAX_SL_NR) +
                                                    ": out of range; allowed 0..31, -1 unchanged");
    else
      maximum_slot_.enter(
          [number = si_MAX_SL_NR](Client& client) { return client.polling({.maximum_slave = number}); });
  }
  cursors_slot_.poll();
  maximum_slot_.poll();
}

}  // namespace cansync::client::function_blocks
