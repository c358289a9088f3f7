#include <array>

#include "cansync/config/rows.h"
#include "config/fields.h"

namespace cansyncd {
namespace {

using namespace config::rows;  // the table reads better without the prefix in every line
using namespace rows;

using cansync::EnableRule;

constexpr auto kTarget = std::to_array<Word<StartTarget>>(
    {{"none", StartTarget::none}, {"setup", StartTarget::setup}, {"active", StartTarget::active}});
constexpr auto kAfterOtherMaster = std::to_array<Word<AfterOtherMaster>>(
    {{"continue", AfterOtherMaster::resume}, {"command", AfterOtherMaster::command}});

constexpr auto kOnSecondMaster = std::to_array<Word<cansync::OnSecondMaster>>(
    {{"report", cansync::OnSecondMaster::report}, {"stop", cansync::OnSecondMaster::stop}});

constexpr auto kEnable = std::to_array<Word<EnableRule>>({{"all_synchronized", EnableRule::all_synchronized},
                                                          {"all_responding", EnableRule::all_responding},
                                                          {"any", EnableRule::any}});

constexpr auto kOnDuplicate = std::to_array<Word<cansync::OnDuplicate>>(
    {{"hold", cansync::OnDuplicate::hold}, {"report", cansync::OnDuplicate::report}});

constexpr auto kBusRows = std::to_array<Row>({
    // --- [bus]
    {one_number("bus.bit_rate", "", "125000|250000|500000|1000000", "bit/s",
                "Bit rate; it fixes the interval: 8, 4, 2 or 1 ms."),
     [](Draft& d, const Value& v) {
       d.config.bus.bits_per_second = whole<std::uint32_t>(v);
       d.config.master.bit_rate = cansync::slot_times_for(d.config.bus.bits_per_second)->bit_rate;
     },
     nullptr, [](Draft& d) { return value_of(d.config.bus.bits_per_second); }},
    {example("50",
             whole_number(
                 "bus.send_margin_us", "(50 bit times)", 0, 1000, "us",
                 "How long before its latest start a telegram is sent; takes up the thread's lateness.")),
     [](Draft& d, const Value& v) {
       d.config.master.send_margin = std::chrono::microseconds(whole<std::int64_t>(v));
     }},
    // --- [startup]
    chosen<kTarget>(
        [](auto& d) -> auto& { return d.config.startup.target; },
        word("startup.target",
             "How far the daemon goes by itself: none = waits for mode commands; setup = SYNC and command "
             "channel; active = setup, then run as soon as `enable` allows.")),
    duration<std::chrono::milliseconds>(
        [](auto& d) -> auto& { return d.config.startup.listen; },
        whole_number("startup.listen_ms", 1, 60'000, "ms",
                     "How long the daemon listens before its first frame and before its first frame after "
                     "bus-off, a pulled cable or a missing interface. It sends no frame and no SYNC edge "
                     "while another master sends. At least one interval. On a simulated bus the daemon "
                     "listens only when this option is given.")),
    chosen<kAfterOtherMaster>(
        [](auto& d) -> auto& { return d.config.startup.after_other_master; },
        word("startup.after_other_master",
             "What the daemon does when another master has been quiet for 3 s: continue = it goes on to "
             "`target`; command = it waits for a mode command.")),
    chosen<kOnSecondMaster>(
        [](auto& d) -> auto& { return d.config.master.startup.on_second_master; },
        word("startup.on_second_master",
             "What the daemon does when another master sends while the bus is in run: report = it goes on "
             "and reports it; stop = it stops sending until the other one has gone. Outside run it always "
             "stops.")),
    chosen<kEnable>(
        [](auto& d) -> auto& { return d.config.master.startup.enable; },
        word("startup.enable",
             "When run may begin: every configured slave responds and is synchronized, every one "
             "responds, or at once.")),
    field(
        [](auto& d) -> auto& { return d.config.master.startup.activate_command; },
        whole_number("startup.activate_command", 2, 255, "",
                     "Command number of the action \"SYNC mode: activate\" (unconfirmed).")),
    field(
        [](auto& d) -> auto& { return d.config.master.startup.activate_data; },
        whole_number("startup.activate_data", 0, 255, "", "Data byte of that action (unconfirmed).")),
    {whole_number("startup.status_parameter", 0, 4095, "",
                  "Parameter number of the status word of slaves that do not give their own (unconfirmed)."),
     [](Draft& d, const Value& v) {
       for (auto& slave : d.config.master.slaves) slave.status_parameter = whole<std::uint16_t>(v);
     },
     nullptr, [](Draft& d) { return value_of(slave_settings(d).status_parameter); }},
    duration<std::chrono::milliseconds>(
        [](auto& d) -> auto& { return d.config.master.startup.status_period; },
        whole_number("startup.status_period_ms", 0, 3'600'000, "ms",
                     "How often each slave's status word is read in run; 0 = never.")),
    field(
        [](auto& d) -> auto& { return d.config.master.startup.lost_after; },
        whole_number(
            "startup.lost_after", 1, 255, "telegrams",
            "Unanswered telegrams in a row until a slave counts as lost. Then its jobs end, and new ones are "
            "refused until it answers again.")),
    field(
        [](auto& d) -> auto& { return d.config.master.startup.enabling_control_bits; },
        whole_number(
            "startup.enabling_control_bits", 0, 65535, "",
            "A control word with all of these bits enables a drive. It is refused for a slave that is lost, or "
            "was away or lost SYNC and is not released yet; others always pass, so that a drive can be stopped. "
            "0 = none is refused.")),
    field(
        [](auto& d) -> auto& { return d.config.master.startup.census; },
        boolean(
            "startup.census",
            "In setup each slave number that is not configured is asked once for its status word; a drive that "
            "answers is reported (event unknown_slave).")),
    chosen<kOnDuplicate>(
        [](auto& d) -> auto& { return d.config.master.startup.on_duplicate; },
        word(
            "startup.on_duplicate",
            "When two drives answer as one slave (event duplicate_slave): hold = the slave is held out and run does "
            "not begin; report = the event alone.")),
    // --- [sim]
    {example("[0]", other("sim.drives", kSlavesWords, "(every configured slave)",
                          "Slaves that have a simulated drive; the others stay silent.")),
     [](Draft& d, const Value& v) { d.config.drives.slaves = slave_mask(d.config, v); }, takes_slaves},
    duration<std::chrono::milliseconds>(
        [](auto& d) -> auto& { return d.config.drives.lock_time; },
        whole_number("sim.lock_time_ms", 0, 60'000, "ms",
                     "Time from activation to bit 15 of a drive's status word.")),
    field(
        [](auto& d) -> auto& { return d.config.drives.memory; },
        whole_number("sim.memory_bytes", 4096, 16'777'216, "bytes",
                     "Memory of each drive for uploads and downloads.")),
    field(
        [](auto& d) -> auto& { return d.config.drives.missing_references; },
        whole_number("sim.missing_references", 0, 65535, "intervals",
                     "Intervals in a row without reference values until a drive faults; 0 = never.")),
    field(
        [](auto& d) -> auto& { return d.config.drives.missing_edges; },
        whole_number("sim.missing_edges", 2, 65535, "edges",
                     "SYNC edges missing in a row until a drive faults.")),
});

}  // namespace

std::span<const Row> rows::bus_options() {
  return kBusRows;
}

}  // namespace cansyncd
