#include "cansync/config/bus_budget_text.h"

#include <fmt/format.h>

#include <chrono>
#include <string_view>

#include "text/counts.h"

namespace cansyncd {
namespace {

using cansync::Duration;

double microseconds_of(Duration duration) noexcept {
  return std::chrono::duration<double, std::micro>(duration).count();
}

std::string percent(unsigned permille) {
  return fmt::format("{}.{} %", permille / 10, permille % 10);
}

std::string polling_line(std::string_view name, unsigned round, Duration interval) {
  if (round == 0) return fmt::format("{}: nobody is asked\n", name);
  return fmt::format("{}: every slave asked once in {}, {:.3f} ms\n", name, text::counted(round, "interval"),
                     microseconds_of(round * interval) / 1000);
}

}  // namespace

std::string budget_text(const BusBudget& budget) {
  std::string out =
      fmt::format("bus budget at {} bit/s: intervals of {:.0f} us, {} each\n", budget.bits_per_second,
                  microseconds_of(budget.interval), text::counted(budget.capacity_bits, "bit"));
  out += "telegram  bytes  bits at most  planned us  latest start us  latest end us\n";
  for (const SlotBudget& slot : budget.slots) {
    out += fmt::format("{:<8}  {:>5}  {:>12}  {:>10.0f}  {:>15.0f}  {:>13.0f}\n", slot.name, slot.bytes,
                       slot.bits, microseconds_of(slot.planned), microseconds_of(slot.latest),
                       microseconds_of(slot.end));
  }
  out += fmt::format("bus load: idle {}, typical {}, worst {}\n", percent(budget.idle),
                     percent(budget.typical), percent(budget.worst));
  out += polling_line("RDC1", budget.polling_round[0], budget.interval);
  out += polling_line("RDC2", budget.polling_round[1], budget.interval);
  if (budget.polling_apart != 0) out += polling_line("RDC1 or RDC2", budget.polling_apart, budget.interval);
  out +=
      fmt::format("parameter read: at least {:.0f} us on the bus, at most one in {} per slave\n",
                  microseconds_of(budget.parameter_least), text::counted(budget.parameter_round, "interval"));
  out += fmt::format("transfer of {}: at least {:.3f} s, {} (blocks of {})\n",
                     text::counted(kTransferBytes, "byte"), microseconds_of(budget.transfer_least) / 1e6,
                     text::counted(budget.transfer_intervals, "interval"),
                     text::counted(budget.transfer_block, "byte"));
  if (budget.sync_delay > Duration{0}) {
    out += fmt::format("SYNC frame: up to {:.0f} us late behind the longest command\n",
                       microseconds_of(budget.sync_delay));
  }
  return out;
}

}  // namespace cansyncd
