#include "daemon/layer2/config/options.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <span>
#include <string_view>
#include <vector>

#include "config/fields.h"
#include "config/print.h"
#include "daemon/options/rows.h"

namespace cansyncd {
namespace {

using namespace config::rows;  // the table reads better without the prefix in every line
using config::Scalar;

using Layer2Row = config::Row<Layer2Draft>;

Layer2Draft::Range& range(Layer2Draft& draft) {
  return draft.ranges[draft.number];
}
SimNodeConfig& node(Layer2Draft& draft) {
  return draft.nodes[draft.number].node;
}

constexpr std::size_t kMostData = 8;

bool takes_data(const Layer2Draft& /*draft*/, const Value& value) {
  return value.kind == Value::Kind::list && value.items.size() <= kMostData &&
         std::all_of(value.items.begin(), value.items.end(), [](const Scalar& item) {
           const auto* number = std::get_if<std::int64_t>(&item);
           return number != nullptr && *number >= 0 && *number <= 255;
         });
}

void put_data(Layer2Draft& draft, const Value& value) {
  can::Frame& frame = node(draft).frame;
  frame.dlc = static_cast<std::uint8_t>(value.items.size());
  std::transform(value.items.begin(), value.items.end(), frame.data.begin(),
                 [](const Scalar& item) { return static_cast<std::uint8_t>(std::get<std::int64_t>(item)); });
}

constexpr std::int64_t kLargestIdentifier = can::kExtendedIdentifierMask;
constexpr std::int64_t kLongestTime = 3'600'000;

constexpr auto kProtocol = std::to_array<DaemonRow>({
    {rows::protocol_option(kLayer2Protocol, "\"layer2\""), [](DaemonConfig&, const Value&) {}},
});

constexpr auto kKinds =
    std::to_array<Word<layer2::FrameKinds>>({{"data_and_remote", layer2::FrameKinds::data_and_remote},
                                             {"data", layer2::FrameKinds::data},
                                             {"remote", layer2::FrameKinds::remote}});

constexpr auto kRows = std::to_array<Layer2Row>({
    // --- [bus]
    field(
        [](auto& d) -> auto& { return d.config.bus.bits_per_second; },
        one_number("bus.bit_rate", "10000|20000|50000|100000|125000|250000|500000|800000|1000000", "bit/s",
                   "Bit rate; a CAN interface must be set to the same.")),
    // --- [send]
    field(
        [](auto& d) -> auto& { return d.config.send.queue; },
        whole_number("send.queue", 1, 256, "requests",
                     "Requests that may wait to be sent; more wait at their clients' turn, or are refused.")),
    duration<std::chrono::milliseconds>(
        [](auto& d) -> auto& { return d.config.send.timeout; },
        whole_number("send.timeout_ms", 1, kLongestTime, "ms",
                     "Monitoring time of requests that name none: until the frame stands on the bus.")),
    // --- [[receive]]
    {config::rows::label("receive.number", layer2::RangeFilter::kMostRanges - 1,
                         "Place among the ranges: of several that take a frame the first counts."),
     [](Layer2Draft& d, const Value&) { range(d).given = true; }},
    {example("0x000", whole_number("receive.first", "(0)", 0, kLargestIdentifier, "",
                                   "First identifier that is received.")),
     [](Layer2Draft& d, const Value& v) { range(d).first = whole<std::uint32_t>(v); }},
    {example("0x7FF", whole_number("receive.last", "(the largest)", 0, kLargestIdentifier, "",
                                   "Last identifier that is received.")),
     [](Layer2Draft& d, const Value& v) { range(d).last = whole<std::uint32_t>(v); }},
    field(
        [](auto& d) -> auto& { return range(d).extended; },
        boolean("receive.extended", "29-bit identifiers; false = 11-bit ones.")),
    chosen<kKinds>(
        [](auto& d) -> auto& { return range(d).kinds; },
        word("receive.kinds", "Which kinds of frames are received.")),
    // --- [[node]]
    {config::rows::label("node.number", 31, "Number of the simulated node."),
     [](Layer2Draft& d, const Value&) { d.nodes[d.number].given = true; }},
    field(
        [](auto& d) -> auto& { return node(d).frame.id; },
        whole_number("node.identifier", 0, kLargestIdentifier, "", "Identifier of its data frame.")),
    field(
        [](auto& d) -> auto& { return node(d).frame.extended; },
        boolean("node.extended", "The identifier has 29 bits; false = 11.")),
    {example("[0x01, 0x02]", other("node.data", "a list of at most eight numbers 0..255", "([])",
                                   "Its data bytes. With a period the first counts up.")),
     put_data, takes_data},
    duration<std::chrono::milliseconds>(
        [](auto& d) -> auto& { return node(d).period; },
        whole_number("node.period_ms", 0, kLongestTime, "ms",
                     "Between two of its frames; 0 = sent as the answer to remote frames alone.")),
});

/// Options of the daemon that mean nothing without slaves, intervals and SYNC edges.
constexpr auto kWithoutEffect =
    std::to_array<std::string_view>({"recorder.syncs_missed", "recorder.slave_lost", "recorder.second_master",
                                     "dds.interval_topic", "access.profile_rules"});

std::vector<DaemonRow> with_effect(std::span<const DaemonRow> rows) {
  std::vector<DaemonRow> wanted;
  std::copy_if(rows.begin(), rows.end(), std::back_inserter(wanted), [](const DaemonRow& row) {
    return std::find(kWithoutEffect.begin(), kWithoutEffect.end(), row.option.key) == kWithoutEffect.end();
  });
  return wanted;
}

/// In the order of the documents.
constexpr auto kSections = std::to_array<config::Section>({
    {"bus", "", ""},
    {"realtime", "", ""},
    {"recorder", "", ""},
    {"dds", "", ""},
    {"access", "", ""},
    {"sim", "", ""},
    {"send", "", ""},
    {"receive", "numbers",
     "Once for each range of identifiers that is received. Without any, every frame is."},
    {"node", "numbers", "Once for each simulated node beside the daemon on a simulated bus."},
});

constexpr std::string_view kMarkdownHead = R"(
# Configuration with bus.protocol = "layer2"

General CAN frames, which nobody interprets ([layer2.md](layer2.md)). The smallest file is `bus.protocol = "layer2"` alone: a
simulated bus without other nodes, from which every frame is received.

After SIGHUP the options marked "running" take effect at once.
)";

constexpr std::string_view kConfigHead =
    R"(# Configuration of cansyncd for general CAN frames with every option. What is not commented out stands at its default;
# delete what you do not change. Printed by `cansyncd --print-default-config --set bus.protocol=layer2`.
)";

constexpr std::string_view kManHead =
    ".Sh OPTIONS WITH BUS.PROTOCOL = LAYER2\n"
    "General CAN frames.\n"
    "Those that do not say \"changes while running\" need a restart.\n";

}  // namespace

const config::Rows<Layer2Draft>& layer2_option_rows() {
  static const config::Rows<Layer2Draft> all(
      kSections, {{std::span<const DaemonRow>(kProtocol), &Layer2Draft::config},
                  {std::span<const DaemonRow>(with_effect(rows::daemon_options())), &Layer2Draft::config},
                  {std::span<const DaemonRow>(with_effect(rows::access_options())), &Layer2Draft::config},
                  std::span<const Layer2Row>(kRows)});
  return all;
}

const config::Table& layer2_options() {
  return layer2_option_rows().table();
}

std::string layer2_options_markdown() {
  return config::options_markdown(layer2_options(), kMarkdownHead);
}

std::string layer2_options_man() {
  return config::options_man(layer2_options(), kManHead);
}

std::string layer2_default_config() {
  return config::default_file(layer2_options(), kConfigHead);
}

}  // namespace cansyncd
