#include "j1939/config/options.h"

#include <algorithm>
#include <array>
#include <span>
#include <string_view>
#include <vector>

#include "config/fields.h"
#include "daemon_config/rows.h"

namespace cansyncd {
namespace {

using namespace config::rows;  // the table reads better without the prefix in every line
using config::Scalar;

using J1939Row = config::Row<J1939Draft>;

J1939Draft::Range& pgn_range(J1939Draft& draft) {
  return draft.ranges[draft.number];
}
j1939::Provided& offer(J1939Draft& draft) {
  return draft.provided[draft.number].provided;
}
SimEcuConfig& ecu(J1939Draft& draft) {
  return draft.ecus[draft.number].ecu;
}

bool takes_message(const J1939Draft& /*draft*/, const Value& value) {
  return value.kind == Value::Kind::list && value.items.size() <= j1939::kMostBytes &&
         std::all_of(value.items.begin(), value.items.end(), [](const Scalar& item) {
           const auto* number = std::get_if<std::int64_t>(&item);
           return number != nullptr && *number >= 0 && *number <= 255;
         });
}

std::vector<std::uint8_t> message_bytes(const Value& value) {
  std::vector<std::uint8_t> data;
  for (const Scalar& item : value.items)
    data.push_back(static_cast<std::uint8_t>(std::get<std::int64_t>(item)));
  return data;
}

constexpr std::int64_t kLongestMessageTime = 3'600'000;
constexpr std::string_view kMessageData = "a list of at most 1785 numbers 0..255";

constexpr auto kJ1939ProtocolRow = std::to_array<DaemonRow>({
    {rows::protocol_option(kJ1939Protocol, "\"j1939\""), [](DaemonConfig&, const Value&) {}},
});

constexpr auto kJ1939Rows = std::to_array<J1939Row>({
    // --- [bus]
    field(
        [](auto& d) -> auto& { return d.config.bus.bits_per_second; },
        one_number("bus.bit_rate", "125000|250000|500000|1000000", "bit/s",
                   "Bit rate; a CAN interface must be set to the same. J1939 knows 250000 and 500000.")),
    // --- [address]
    {whole_number("address.preferred", "(none: it listens only)", 0, 253, "",
                  "Address that the daemon claims first."),
     [](J1939Draft& d, const Value& v) { d.config.preferred = whole<j1939::Address>(v); }},
    field(
        [](auto& d) -> auto& { return d.config.name.arbitrary_address; },
        boolean(
            "address.arbitrary",
            "It takes another address when it loses its own to a stronger NAME; the highest bit of its NAME.")),
    field(
        [](auto& d) -> auto& { return d.config.first_other; },
        whole_number("address.first_other", 0, 253, "", "First address that it may take instead.")),
    field(
        [](auto& d) -> auto& { return d.config.last_other; },
        whole_number("address.last_other", 0, 253, "", "Last address that it may take instead.")),
    field(
        [](auto& d) -> auto& { return d.config.takes_commands; },
        boolean("address.takes_commands", "Other nodes may command it to an address (PGN 65240).")),
    field(
        [](auto& d) -> auto& { return d.config.contest; },
        boolean(
            "address.contest",
            "The daemon claims its address immediately, and takes it from a node with a weaker NAME. false: "
            "it requests all addresses first, and leaves an address that another node has to that node.")),
    // --- [name]
    field(
        [](auto& d) -> auto& { return d.config.name.identity; },
        whole_number("name.identity", 0, 0x1FFFFF, "",
                     "Serial number; with the manufacturer it must be on this bus once.")),
    field(
        [](auto& d) -> auto& { return d.config.name.manufacturer; },
        whole_number("name.manufacturer", 0, 0x7FF, "", "Code of the manufacturer, given by SAE.")),
    field(
        [](auto& d) -> auto& { return d.config.name.ecu_instance; },
        whole_number("name.ecu_instance", 0, 7, "", "Which of several controllers of one function.")),
    field(
        [](auto& d) -> auto& { return d.config.name.function_instance; },
        whole_number("name.function_instance", 0, 31, "", "Which of several like functions.")),
    field(
        [](auto& d) -> auto& { return d.config.name.function; },
        whole_number("name.function", 0, 255, "", "Function, by the tables of the standard.")),
    field(
        [](auto& d) -> auto& { return d.config.name.vehicle_system; },
        whole_number("name.vehicle_system", 0, 127, "", "Vehicle system, by the tables of the standard.")),
    field(
        [](auto& d) -> auto& { return d.config.name.vehicle_system_instance; },
        whole_number("name.vehicle_system_instance", 0, 15, "", "Which of several like vehicle systems.")),
    field(
        [](auto& d) -> auto& { return d.config.name.industry_group; },
        whole_number("name.industry_group", 0, 7, "",
                     "Industry group: 0 global, 1 road, 2 agriculture, 5 industry.")),
    // --- [send]
    field(
        [](auto& d) -> auto& { return d.config.send.queue; },
        whole_number("send.queue", 1, 64, "requests",
                     "Messages that may wait to be sent, of one client half of them; more wait for their "
                     "client's turn, or are refused.")),
    duration<std::chrono::milliseconds>(
        [](auto& d) -> auto& { return d.config.send.timeout; },
        whole_number(
            "send.timeout_ms", 1, kLongestMessageTime, "ms",
            "Monitoring time of requests that name none, to their reply; in packets 200 ms more for each.")),
    // --- [transport]
    field(
        [](auto& d) -> auto& { return d.config.transport.window; },
        whole_number("transport.window", 1, 255, "packets",
                     "Packets of a connection that other nodes are asked for at once.")),
    field(
        [](auto& d) -> auto& { return d.config.transport.most_bytes; },
        whole_number(
            "transport.most_bytes", 1785, 1'048'576, "bytes",
            "Longest message, in both directions; over 1785 by the extended transport protocol. Memory for "
            "some is taken at the start.")),
    duration<std::chrono::milliseconds>(
        [](auto& d) -> auto& { return d.config.transport.interval; },
        whole_number("transport.broadcast_interval_ms", 10, 200, "ms",
                     "Between two packets of a broadcast; the standard wants 50 to 200.")),
    // --- [listen]
    field(
        [](auto& d) -> auto& { return d.config.between_others; },
        boolean("listen.between_others",
                "Messages in one frame from one other node to another are received too.")),
    // --- [[receive]]
    {config::rows::label("receive.number", j1939::PgnFilter::kMostRanges - 1,
                         "Place among the ranges: of several that take a message the first counts."),
     [](J1939Draft& d, const Value&) { d.ranges[d.number].given = true; }},
    {example("0xFEF1",
             whole_number("receive.first", "(0)", 0, j1939::kLargestPgn, "", "First PGN that is received.")),
     [](J1939Draft& d, const Value& v) { pgn_range(d).first = whole<j1939::Pgn>(v); }},
    {example("0xFEF1", whole_number("receive.last", "(as first, or the largest)", 0, j1939::kLargestPgn, "",
                                    "Last PGN that is received.")),
     [](J1939Draft& d, const Value& v) { pgn_range(d).last = whole<j1939::Pgn>(v); }},
    {whole_number("receive.source", "(every)", 0, 254, "", "Address of the only node it is received from."),
     [](J1939Draft& d, const Value& v) { pgn_range(d).source = whole<j1939::Address>(v); }},
    // --- [[provide]]
    {config::rows::label("provide.number", 31, "Number of the group that other nodes may request."),
     [](J1939Draft& d, const Value&) { d.provided[d.number].given = true; }},
    field(
        [](auto& d) -> auto& { return offer(d).number; },
        whole_number("provide.pgn", 0, j1939::kLargestPgn, "", "PGN.")),
    field(
        [](auto& d) -> auto& { return offer(d).priority; },
        whole_number("provide.priority", 0, 7, "", "Priority; in packets 7 by the standard.")),
    {example("[0x01, 0x02]", other("provide.data", kMessageData, "([]: a client answers)",
                                   "The bytes that the daemon answers with.")),
     [](J1939Draft& d, const Value& v) { offer(d).data = message_bytes(v); }, takes_message},
    duration<std::chrono::milliseconds>(
        [](auto& d) -> auto& { return offer(d).period; },
        whole_number(
            "provide.period_ms", 0, 3'600'000, "ms",
            "Between two times that the daemon sends it to all by itself, while it holds an address; 0 = "
            "on request alone.")),
    // --- [[ecu]]
    {config::rows::label("ecu.number", 31, "Number of the simulated node."),
     [](J1939Draft& d, const Value&) { d.ecus[d.number].given = true; }},
    field(
        [](auto& d) -> auto& { return ecu(d).address; },
        whole_number("ecu.address", 0, 253, "", "Address that it claims.")),
    {whole_number("ecu.identity", "(1000 and its number)", 0, 0x1FFFFF, "",
                  "Serial number in its NAME, whose other fields are 0: the lower, the stronger."),
     [](J1939Draft& d, const Value& v) { d.ecus[d.number].identity = whole<std::uint32_t>(v); }},
    field(
        [](auto& d) -> auto& { return ecu(d).name.arbitrary_address; },
        boolean("ecu.arbitrary", "It takes another address when it loses its own.")),
    field(
        [](auto& d) -> auto& { return ecu(d).group; },
        whole_number("ecu.pgn", 0, j1939::kLargestPgn, "",
                     "PGN that it sends, and gives to who requests it.")),
    field(
        [](auto& d) -> auto& { return ecu(d).priority; },
        whole_number("ecu.priority", 0, 7, "", "Priority of that.")),
    field(
        [](auto& d) -> auto& { return ecu(d).destination; },
        whole_number("ecu.destination", 0, 255, "", "Whom it sends it to; 255 = all.")),
    {example("[0x01, 0x02]",
             other("ecu.data", kMessageData, "([])", "Its bytes; without any it sends and gives nothing.")),
     [](J1939Draft& d, const Value& v) { ecu(d).data = message_bytes(v); }, takes_message},
    duration<std::chrono::milliseconds>(
        [](auto& d) -> auto& { return ecu(d).period; },
        whole_number("ecu.period_ms", 0, kLongestMessageTime, "ms",
                     "Between two of its messages; 0 = on request alone.")),
    field(
        [](auto& d) -> auto& { return ecu(d).counts; },
        boolean("ecu.counts",
                "Its first byte counts the messages that it sends with a period. false: its bytes stay as "
                "they are, such as the lamps of a DM1.")),
});

/// In the order of the documents.
constexpr auto kJ1939Sections = std::to_array<config::Section>({
    {"bus", "", ""},
    {"address", "", ""},
    {"name", "", ""},
    {"realtime", "", ""},
    {"recorder", "", ""},
    {"dds", "", ""},
    {"access", "", ""},
    {"metrics", "", ""},
    {"sim", "", ""},
    {"send", "", ""},
    {"transport", "", ""},
    {"listen", "", ""},
    {"receive", "numbers", "Once for each range of groups that is received. Without any, every group is."},
    {"provide", "numbers",
     "Once for each group that other nodes may request, or that the daemon sends again and again."},
    {"ecu", "numbers", "Once for each simulated node beside the daemon on a simulated bus."},
});

}  // namespace

const config::Rows<J1939Draft>& j1939_option_rows() {
  static const config::Rows<J1939Draft> all(
      kJ1939Sections,
      {{std::span<const DaemonRow>(kJ1939ProtocolRow), &J1939Draft::config},
       {std::span<const DaemonRow>(rows::without_intervals(rows::daemon_options())), &J1939Draft::config},
       {std::span<const DaemonRow>(rows::without_intervals(rows::access_options())), &J1939Draft::config},
       {rows::record_options(), &J1939Draft::config},
       {rows::metrics_options(), &J1939Draft::config},
       std::span<const J1939Row>(kJ1939Rows)});
  return all;
}

const config::Table& j1939_options() {
  return j1939_option_rows().table();
}

}  // namespace cansyncd
