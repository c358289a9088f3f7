// A schedule in words.
#include <iomanip>
#include <sstream>

#include "cansync/settings/timing.h"
#include "plan.h"

namespace cansyncd::campaign {
namespace {

void describe_settings(std::ostream& out, const Plan& plan) {
  const cansync::MasterSettings& settings = plan.settings;
  const cansync::CommandChannelSettings& channel = settings.command_channel;
  const auto intervals = [&](cansync::Duration time) { return time / plan.interval(); };
  out << "line: " << cansync::slot_times(settings.bit_rate).bits_per_second << " bit/s, slaves";
  for (const sim::DriveSettings& drive : plan.drives) out << " " << +drive.slave.number.value();
  out << "\ncommand channel: " << (channel.serving == cansync::Serving::scan ? "scan" : "work conserving")
      << ", minimum share " << channel.minimum_share << ", queues " << channel.parameter_queue << "/"
      << channel.transfer_queue << "/" << channel.broadcast_queue << ", monitoring "
      << intervals(channel.parameter_monitoring) << "/" << intervals(channel.transfer_monitoring) << "/"
      << intervals(channel.command_monitoring) << " intervals, repeat writes "
      << channel.repeat_unanswered_writes << ", repeats " << +channel.telegram_repeats << ", block retries "
      << +channel.block_retries << ", address step " << +channel.address_step << "\nstart: enable rule "
      << static_cast<int>(settings.startup.enable) << ", status period "
      << intervals(settings.startup.status_period) << " intervals, lost after "
      << +settings.startup.lost_after << ", target " << static_cast<int>(plan.target)
      << "\ndrives: lock time " << intervals(plan.drives.front().lock_time)
      << " intervals (first drive), busy " << plan.drives.front().memory.busy_replies << ", upload length "
      << plan.drives.front().memory.upload_length << "\nthread: rings " << plan.sizes.requests << "/"
      << plan.sizes.terminals << "/" << plan.sizes.reports << ", transmit queue " << plan.transmit_queue
      << ", " << (plan.rare_looks ? "woken by slots" : "woken by frames") << "\n";
}

void describe_fault(std::ostream& out, const sim::Fault& fault) {
  out << "fault: " << name(fault.kind) << " in " << fault.from << ".." << fault.to << ", probability "
      << fault.probability;
  if (fault.count != sim::Fault::kNoLimit) out << ", count " << fault.count;
  if (fault.node) out << ", slave " << +*fault.node;
  out << std::hex;
  if (fault.mask != 0) out << ", identifier 0x" << fault.identifier << "/0x" << fault.mask;
  if (fault.kind == sim::FaultKind::lost) {
    out << ", receivers 0x" << fault.receivers.bits << (fault.lost_to_master ? " and master" : "");
  }
  if (fault.kind == sim::FaultKind::inject) out << ", identifier 0x" << fault.frame.id;
  out << std::dec;
  if (fault.delay.count() != 0) out << ", delay " << fault.delay.count() / 1000 << " us";
  out << "\n";
}

}  // namespace

std::string describe(const Plan& plan) {
  std::ostringstream out;
  out << "seed " << plan.seed << ", faults up to interval " << plan.last_fault;
  if (plan.stop_at != 0) out << ", stopped in interval " << plan.stop_at;
  out << "\n";
  describe_settings(out, plan);
  for (const sim::Fault& fault : plan.faults) describe_fault(out, fault);
  for (const PowerCycle& cycle : plan.power_cycles) {
    out << "slave " << +plan.drives[cycle.slave].slave.number.value()
        << " is switched off and on in interval " << cycle.at << "\n";
  }
  for (const Window& hang : plan.hangs)
    out << "the gateway hangs in " << hang.from << ".." << hang.to << "\n";
  for (const Lateness& late : plan.lateness) {
    out << "the thread wakes late in " << late.when.from << ".." << late.when.to << ", " << late.per_mille
        << " times in a thousand, up to " << late.most.count() / 1000 << " us\n";
  }
  const Mix& mix = plan.mix;
  out << "in a thousand intervals: parameters " << mix.parameters << ", transfers " << mix.transfers
      << ", control words " << mix.control_words << ", broadcasts " << mix.broadcasts << ", settings "
      << mix.settings << ", modes " << mix.modes << ", cancels " << mix.cancels << ", departures "
      << mix.departures << ", bursts " << mix.bursts << ", reference values " << mix.references
      << ", words that stop " << mix.stop_words << "\n";
  const WriterPlan& writers = plan.writers;
  if (writers.strengths.empty()) return out.str();
  out << "programs that give reference values, with their strengths:";
  for (const std::int32_t strength : writers.strengths) out << " " << strength;
  out << "; hold " << writers.hold << ", maximum age " << writers.maximum_age.count() << " ms, deadline "
      << writers.deadline.count() << " ms\n";
  return out.str();
}

}  // namespace cansyncd::campaign
