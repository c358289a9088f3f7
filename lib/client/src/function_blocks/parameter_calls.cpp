#include <cansync/function_blocks/par_read_ma.h>
#include <cansync/function_blocks/par_write_ma.h>

namespace cansync::client::function_blocks {

void PAR_READ_MA::call(Clock::time_point now) {
  const std::optional<ParameterReply> reply = step(false, 0, now);
  if (!reply) return;
  ud_PAR_VALUE = reply->value;
  x_PAR_FORMAT_READ = reply->doubleword;
}

void PAR_WRITE_MA::call(Clock::time_point now) {
  (void)step(true, ud_PAR_VALUE, now);
}

}  // namespace cansync::client::function_blocks
