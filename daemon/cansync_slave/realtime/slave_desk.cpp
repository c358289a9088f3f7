#include "daemon/cansync_slave/realtime/slave_desk.h"

#include <algorithm>
#include <span>
#include <utility>
#include <variant>

namespace cansyncd {
namespace {

constexpr std::uint16_t kSynchronizedBit = 0x8000;

}  // namespace

SlaveDesk::SlaveDesk(const cansync::SlaveServiceSettings& service, std::uint16_t parameter,
                     std::uint16_t bits, SlaveExchange& exchange)
    : parameter_(parameter), bits_(bits), exchange_(exchange), service_(service, *this) {
  set_synchronized(false);
}

void SlaveDesk::set_synchronized(bool synchronized) noexcept {
  const unsigned low = bits_ & ~unsigned{kSynchronizedBit};
  (void)service_.table().set_value(parameter_, synchronized ? low | kSynchronizedBit : low);
}

std::uint16_t SlaveDesk::status_word() const noexcept {
  return static_cast<std::uint16_t>(service_.table().value(parameter_).value_or(0));
}

std::optional<SlaveAction> SlaveDesk::take_action() noexcept {
  return std::exchange(action_, std::nullopt);
}

bool SlaveDesk::take_told() noexcept {
  return std::exchange(told_, false);
}

// --- from the application

void SlaveDesk::take_orders(can::Time now) noexcept {
  ApplicationOrder order;
  for (unsigned i = 0; i < SlaveExchange::kOrders && exchange_.orders.try_pop(order); ++i) {
    if (const auto* taken = std::get_if<TakeOver>(&order)) {
      take(*taken);
    } else if (const auto* answer = std::get_if<JobAnswer>(&order)) {
      take(*answer);
    } else if (const auto* reply = std::get_if<BlockReply>(&order)) {
      take(*reply);
    }
  }
  service_.jobs().at(now);
  service_.area().at(now);
}

void SlaveDesk::take(const TakeOver& order) noexcept {
  if (!order.same_application || !order.present) service_.jobs().set_application(false);
  if (!order.same_application || !order.blocks) service_.area().set_application(false);
  if (!order.present) return;
  service_.jobs().set_application(true);
  cansync::TakenOver taken = order.taken;
  taken.numbers[parameter_] = false;  // the status word is the daemon's
  service_.jobs().take_over(taken);
  if (order.blocks) service_.area().set_application(true);
}

void SlaveDesk::take(const JobAnswer& order) noexcept {
  if (!service_.jobs().answer(order.id, order.answer)) ++counters_.answers_unused;
}

void SlaveDesk::take(const BlockReply& order) noexcept {
  cansync::BlockArea& area = service_.area();
  const std::span<const std::uint8_t> data = std::span(order.data).first(order.bytes);
  bool taken = false;
  switch (order.kind) {
    case BlockReply::Kind::allow:
      taken = area.allow(order.id, data, order.length);
      break;
    case BlockReply::Kind::refuse:
      taken = area.refuse(order.id, order.error);
      break;
    case BlockReply::Kind::take:
      taken = area.take(order.id);
      break;
    case BlockReply::Kind::step:
      taken = area.step(order.id, data);
      break;
  }
  if (!taken) ++counters_.answers_unused;
}

// --- to the application

void SlaveDesk::tell(const ServiceReport& report) noexcept {
  told_ = true;
  if (!exchange_.jobs.try_push(report)) ++counters_.lost;
}

void SlaveDesk::asked(const cansync::AskedParameter& job) noexcept {
  ++counters_.jobs;
  tell(JobReport{now_, JobReport::Step::asked, job});
}

void SlaveDesk::dropped(std::uint64_t id) noexcept {
  ++counters_.jobs_dropped;
  cansync::AskedParameter job;
  job.id = id;
  tell(JobReport{now_, JobReport::Step::dropped, job});
}

void SlaveDesk::answered(std::uint64_t id) noexcept {
  ++counters_.jobs_answered;
  cansync::AskedParameter job;
  job.id = id;
  tell(JobReport{now_, JobReport::Step::answered, job});
}

void SlaveDesk::block_begun(const cansync::AskedBlock& block) noexcept {
  ++counters_.blocks;
  BlockReport report;
  report.when = now_;
  report.step = BlockReport::Step::begun;
  report.block = block;
  tell(report);
}

void SlaveDesk::block_complete(std::uint64_t /*id*/) noexcept {
  const std::span<const std::uint8_t> data = service_.area().data();
  BlockReport report;
  report.when = now_;
  report.step = BlockReport::Step::complete;
  report.block = service_.area().open();
  report.bytes = static_cast<std::uint16_t>(std::min(data.size(), report.data.size()));
  std::copy_n(data.begin(), report.bytes, report.data.begin());
  tell(report);
}

void SlaveDesk::step_asked(std::uint64_t /*id*/, const cansync::AskedStep& step) noexcept {
  BlockReport report;
  report.when = now_;
  report.step = BlockReport::Step::telegram;
  report.block = service_.area().open();
  report.offset = step.offset;
  report.bytes = step.bytes;
  std::copy(step.data.begin(), step.data.end(), report.data.begin());
  tell(report);
}

void SlaveDesk::block_ended(std::uint64_t id, cansync::BlockEnd end) noexcept {
  if (end == cansync::BlockEnd::done) ++counters_.blocks_done;
  BlockReport report;
  report.when = now_;
  report.step = BlockReport::Step::ended;
  report.block.id = id;
  report.end = end;
  tell(report);
}

}  // namespace cansyncd
