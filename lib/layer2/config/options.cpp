#include "layer2/config/options.h"

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
using config::OptionType;
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

void put_bytes(const Value& value, can::Frame& frame) {
  frame.dlc = static_cast<std::uint8_t>(value.items.size());
  std::transform(value.items.begin(), value.items.end(), frame.data.begin(),
                 [](const Scalar& item) { return static_cast<std::uint8_t>(std::get<std::int64_t>(item)); });
}

void put_data(Layer2Draft& draft, const Value& value) {
  put_bytes(value, node(draft).frame);
}

TimerConfig& timer(Layer2Draft& draft) {
  return draft.timers[draft.number].timer;
}
void put_timer_data(Layer2Draft& draft, const Value& value) {
  put_bytes(value, timer(draft).timer.frame);
}
layer2::MappedBytes& mapped(Layer2Draft& draft) {
  return draft.mapped[draft.number].bytes;
}

layer2::ObjectSettings& object(Layer2Draft& draft) {
  return draft.objects[draft.number].settings;
}

/// A script's lines.
bool takes_lines(const Layer2Draft& /*draft*/, const Value& value) {
  return value.kind == Value::Kind::list &&
         std::all_of(value.items.begin(), value.items.end(),
                     [](const Scalar& item) { return std::get_if<std::string>(&item) != nullptr; });
}
std::vector<std::string> lines_of(const Value& value) {
  std::vector<std::string> lines;
  for (const Scalar& item : value.items) lines.push_back(std::get<std::string>(item));
  return lines;
}

constexpr config::Option script_lines(std::string_view key, std::string_view help) {
  return example("[\"Send 0x000 2 1 0\", \"Wait 100\", \"Start 1\"]",
                 other(key, "a list of strings, a line of the script each", "([])", help));
}

constexpr config::Option from_one(config::Option option) {
  option.minimum = 1;
  return option;
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

constexpr auto kOverflows = std::to_array<Word<layer2::Overflow>>(
    {{"refuse_newest", layer2::Overflow::refuse_newest}, {"delete_oldest", layer2::Overflow::delete_oldest}});

constexpr auto kWriterLost = std::to_array<Word<WriterLost>>(
    {{"hold", WriterLost::hold}, {"zero", WriterLost::zero}, {"stop_sending", WriterLost::stop_sending}});

constexpr auto kNumbers =
    std::to_array<Word<layer2::ScriptNumbers>>({{"marked", layer2::ScriptNumbers::marked},
                                                {"decimal", layer2::ScriptNumbers::decimal},
                                                {"hexadecimal", layer2::ScriptNumbers::hexadecimal}});

constexpr std::int64_t kMostQueue = layer2::Station::kMostQueue;
constexpr std::int64_t kLongestTimeUs = 3'600'000'000;

constexpr auto kRows = std::to_array<Layer2Row>({
    // --- [bus]
    field(
        [](auto& d) -> auto& { return d.config.bus.bits_per_second; },
        one_number("bus.bit_rate", "10000|20000|50000|100000|125000|250000|500000|800000|1000000", "bit/s",
                   "Bit rate; a CAN interface must be set to the same.")),
    // --- [send]
    field(
        [](auto& d) -> auto& { return d.config.send.queue; },
        whole_number("send.queue", 1, kMostQueue, "requests",
                     "Requests of normal priority that may wait to be sent.")),
    field(
        [](auto& d) -> auto& { return d.config.send.high_queue; },
        whole_number("send.high_queue", 1, kMostQueue, "requests",
                     "Requests of high priority that may wait to be sent.")),
    chosen<kOverflows>(
        [](auto& d) -> auto& { return d.config.send.overflow; },
        word(
            "send.overflow",
            "More requests than a queue has room for: refuse_newest = they wait at their clients' turn, or are "
            "refused; delete_oldest = the oldest in the queue is not sent, and answered so.")),
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
    field(
        [](auto& d) -> auto& { return range(d).high_priority; },
        boolean("receive.high_priority", "Its frames overtake others that wait to be published.")),
    // --- [filter]
    field(
        [](auto& d) -> auto& { return d.config.node_filter; },
        whole_number(
            "filter.node", 0, 127, "",
            "In place of ranges: only frames are received that have this number, or 0, in the lower seven "
            "bits of their identifier; 0 = the ranges count.")),
    field(
        [](auto& d) -> auto& { return d.config.node_filter_extended; },
        boolean("filter.extended", "Of 29-bit identifiers; false = of 11-bit ones.")),
    // --- [queue]
    field(
        [](auto& d) -> auto& { return d.config.queues.receive; },
        whole_number("queue.receive", 1, kMostQueue, "frames",
                     "Received frames that may wait while those before are published.")),
    field(
        [](auto& d) -> auto& { return d.config.queues.receive_high; },
        whole_number("queue.receive_high", 1, kMostQueue, "frames", "Likewise, of ranges of high priority.")),
    chosen<kOverflows>(
        [](auto& d) -> auto& { return d.config.queues.overflow; },
        word("queue.receive_overflow", "Which frame is lost when there is no room.")),
    // --- [module]
    field(
        [](auto& d) -> auto& { return d.config.starts_in_run; },
        boolean("module.run", "The daemon starts in run; false = it stays in stop until it is told to run.")),
    field(
        [](auto& d) -> auto& { return d.config.run_follows; },
        string(
            "module.run_follows", OptionType::identifier, 0, 63,
            "Run and stop follow the program that writes RunLead under this name: without it the module is in "
            "stop; \"\" = they follow none.")),
    // --- [script]
    chosen<kNumbers>(
        [](auto& d) -> auto& { return d.config.script.rules.numbers; },
        word(
            "script.numbers",
            "What identifiers, lengths and data bytes without 0x are; marked = more than one digit needs 0x.")),
    field(
        [](auto& d) -> auto& { return d.config.script.rules.extended; },
        boolean("script.extended", "Identifiers in scripts have 29 bits; false = 11.")),
    {script_lines("script.power_on", "What is done when the daemon starts."),
     [](Layer2Draft& d, const Value& v) { d.config.script.power_on = lines_of(v); }, takes_lines},
    {script_lines("script.run", "What is done from stop to run, also at the start."),
     [](Layer2Draft& d, const Value& v) { d.config.script.run = lines_of(v); }, takes_lines},
    {script_lines("script.stop", "What is done from run to stop."),
     [](Layer2Draft& d, const Value& v) { d.config.script.stop = lines_of(v); }, takes_lines},
    // --- [window]
    field(
        [](auto& d) -> auto& { return d.config.window.used; },
        boolean(
            "window.used",
            "Requests are sent in the synchronous window alone, once timers 1 and 2 were started one directly "
            "after the other; these two send no frame then.")),
    duration<std::chrono::microseconds>(
        [](auto& d) -> auto& { return d.config.window.repeat; },
        whole_number("window.repeat_us", 1, kLongestTimeUs, "us", "Period of the window.")),
    duration<std::chrono::microseconds>(
        [](auto& d) -> auto& { return d.config.window.begin; },
        whole_number("window.begin_us", 0, kLongestTimeUs, "us", "Start of the window in its period.")),
    duration<std::chrono::microseconds>(
        [](auto& d) -> auto& { return d.config.window.end; },
        whole_number("window.end_us", 1, kLongestTimeUs, "us",
                     "End of the window in its period; no frame begins that would end later.")),
    field(
        [](auto& d) -> auto& { return d.config.window.holds_high; },
        boolean("window.high_priority", "Requests of high priority are held, too.")),
    // --- [mapping]
    {example("0x180", whole_number("mapping.identifier", "(none)", 0, kLargestIdentifier, "",
                                   "Telegrams received: their identifier where the mask has ones.")),
     [](Layer2Draft& d, const Value& v) { d.mapping_identifier = whole<std::uint32_t>(v); }},
    {example("0x700",
             whole_number(
                 "mapping.mask", "(none)", 0, kLargestIdentifier, "",
                 "Bits of the identifier that count; 0 = every frame belongs to the mapping. Frames that "
                 "belong to it and are not in the table are dropped. Without a mask only the identifiers "
                 "of the table belong to it.")),
     [](Layer2Draft& d, const Value& v) { d.mapping_mask = whole<std::uint32_t>(v); }},
    field(
        [](auto& d) -> auto& { return d.config.mapping.rule.extended; },
        boolean("mapping.extended", "29-bit identifiers; false = 11-bit ones.")),
    duration<std::chrono::milliseconds>(
        [](auto& d) -> auto& { return d.config.mapping.interval; },
        whole_number("mapping.interval_ms", 1, 65535, "ms", "Between two times of sending.")),
    field(
        [](auto& d) -> auto& { return d.config.mapping.on_change; },
        boolean("mapping.on_change",
                "Only telegrams are sent whose bytes have changed since they were sent.")),
    field(
        [](auto& d) -> auto& { return d.config.mapping.first_always; },
        boolean("mapping.first_always", "With on_change: each telegram is sent once at the start.")),
    chosen<kWriterLost>(
        [](auto& d) -> auto& { return d.config.writer_lost; },
        word(
            "mapping.writer_lost",
            "When the program that owns the image that is sent has gone, has given it up, or may write no more: "
            "stop_sending = the image is not sent until a program writes it, from all 0 on; zero = its bytes become 0; hold = it is "
            "sent on as it is.")),
    // --- [[mapped]]
    {config::rows::label("mapped.number", Layer2Draft::kMostMapped - 1, "Place in the table."),
     [](Layer2Draft& d, const Value&) { d.mapped[d.number].given = true; }},
    {example("0x181", whole_number("mapped.identifier", "0", 0, kLargestIdentifier, "",
                                   "Identifier of the telegram.")),
     [](Layer2Draft& d, const Value& v) { mapped(d).identifier = whole<std::uint32_t>(v); }},
    field(
        [](auto& d) -> auto& { return mapped(d).output; },
        boolean("mapped.output", "The telegram is sent; false = it is received.")),
    field(
        [](auto& d) -> auto& { return mapped(d).offset; },
        whole_number("mapped.offset", 0, 7, "B", "First byte in the telegram.")),
    field(
        [](auto& d) -> auto& { return mapped(d).address; },
        whole_number("mapped.address", 0, 1023, "B", "First byte in the process image of its direction.")),
    field(
        [](auto& d) -> auto& { return mapped(d).size; },
        whole_number("mapped.size", 1, 8, "B", "Bytes; offset and size are at most 8 together.")),
    // --- [[timer]]
    {from_one(config::rows::label("timer.number", layer2::Timers::kMost, "Number of the timer.")),
     [](Layer2Draft& d, const Value&) { d.timers[d.number].given = true; }},
    {example("0x080",
             whole_number("timer.identifier", "0", 0, kLargestIdentifier, "", "Identifier of its frame.")),
     [](Layer2Draft& d, const Value& v) { timer(d).timer.frame.id = whole<std::uint32_t>(v); }},
    field(
        [](auto& d) -> auto& { return timer(d).timer.frame.extended; },
        boolean("timer.extended", "The identifier has 29 bits; false = 11.")),
    {example("[0x01, 0x02]",
             other("timer.data", "a list of at most eight numbers 0..255", "([])", "Its data bytes.")),
     put_timer_data, takes_data},
    field(
        [](auto& d) -> auto& { return timer(d).timer.frame.remote; },
        boolean("timer.remote", "A remote frame: it asks for as many bytes as `data` has.")),
    duration<std::chrono::microseconds>(
        [](auto& d) -> auto& { return timer(d).timer.period; },
        whole_number("timer.period_us", 100, kLongestTimeUs, "us", "Between two of its frames.")),
    duration<std::chrono::microseconds>(
        [](auto& d) -> auto& { return timer(d).timer.phase; },
        whole_number("timer.phase_us", 0, kLongestTimeUs, "us", "From its start to its first frame.")),
    field(
        [](auto& d) -> auto& { return timer(d).timer.cyclic; },
        boolean("timer.cyclic", "It goes on; false = it sends one frame and stops.")),
    // --- [[object]]
    {config::rows::label("object.number", layer2::MessageObjects::kMost - 1,
                         "Number of the message object: the lowest sends first, and receives first."),
     [](Layer2Draft& d, const Value&) { d.objects[d.number].given = true; }},
    field(
        [](auto& d) -> auto& { return object(d).transmit; },
        boolean("object.transmit", "It sends; false = it receives.")),
    {example("0x201", whole_number("object.identifier", "0", 0, kLargestIdentifier, "",
                                   "Identifier that it sends, or receives where the mask has ones.")),
     [](Layer2Draft& d, const Value& v) { object(d).rule.identifier = whole<std::uint32_t>(v); }},
    {example("0x7FF", whole_number("object.mask", "(all bits)", 0, kLargestIdentifier, "",
                                   "Of an object that receives: bits of the identifier that count.")),
     [](Layer2Draft& d, const Value& v) { object(d).rule.mask = whole<std::uint32_t>(v); }},
    field(
        [](auto& d) -> auto& { return object(d).rule.extended; },
        boolean("object.extended", "29-bit identifiers; false = 11-bit ones.")),
    duration<std::chrono::milliseconds>(
        [](auto& d) -> auto& { return object(d).timeout; },
        whole_number("object.timeout_ms", 0, kLongestTime, "ms",
                     "Of an object that sends: a job that was not sent by then is aborted; 0 = never.")),
    field(
        [](auto& d) -> auto& { return object(d).tell; },
        boolean("object.tell", "Each frame that it sent or received is an event.")),
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

/// In the order of the documents.
constexpr auto kSections = std::to_array<config::Section>({
    {"bus", "", ""},
    {"realtime", "", ""},
    {"recorder", "", ""},
    {"dds", "", ""},
    {"access", "", ""},
    {"metrics", "", ""},
    {"sim", "", ""},
    {"send", "", ""},
    {"receive", "numbers",
     "Once for each range of identifiers that is received. Without any, every frame is."},
    {"filter", "", ""},
    {"queue", "", ""},
    {"module", "", ""},
    {"script", "",
     "Scripts for power-on, run and stop: `Send ID LENGTH BYTE...`, `Fetch ID [LENGTH]`, `Start TIMER`, `Stop TIMER`, `Wait MS`, `// ...`."},
    {"timer", "numbers", "Once for each timer, 1 to 16. A script or a command starts it."},
    {"object", "numbers",
     "Once for each message object, 0 to 31. One that receives is closed until a client opens it."},
    {"window", "", ""},
    {"mapping", "", ""},
    {"mapped", "numbers",
     "Once for each place of a telegram's bytes in the process image. Without any there is none."},
    {"node", "numbers", "Once for each simulated node beside the daemon on a simulated bus."},
});

}  // namespace

const config::Rows<Layer2Draft>& layer2_option_rows() {
  static const config::Rows<Layer2Draft> all(
      kSections,
      {{std::span<const DaemonRow>(kProtocol), &Layer2Draft::config},
       {std::span<const DaemonRow>(rows::without_intervals(rows::daemon_options())), &Layer2Draft::config},
       {std::span<const DaemonRow>(rows::without_intervals(rows::access_options())), &Layer2Draft::config},
       {rows::record_options(), &Layer2Draft::config},
       {rows::metrics_options(), &Layer2Draft::config},
       std::span<const Layer2Row>(kRows)});
  return all;
}

const config::Table& layer2_options() {
  return layer2_option_rows().table();
}

}  // namespace cansyncd
