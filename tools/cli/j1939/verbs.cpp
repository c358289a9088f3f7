#include "cli/j1939/verbs.h"

#include <fmt/format.h>

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cli/base/files.h"
#include "cli/base/interrupt.h"
#include "cli/connect/bus_verb.h"
#include "cli/connect/gateway_reply.h"
#include "cli/dbc/dbc_file.h"
#include "cli/j1939/group_signals.h"
#include "cli/j1939/message_lines.h"
#include "cli/j1939/status_part.h"
#include "cli/text/column_help.h"
#include "cli/text/values.h"
#include "cli/trace/follow_source.h"
#include "cli/trace/trace_source.h"
#include "j1939/client/message_client.h"
#include "j1939/client/recorded_bus.h"
#include "j1939/dds/texts.h"
#include "j1939/name.h"
#include "text/counts.h"

namespace cansync::cli {
namespace {

using j1939::client::MessageClient;

/// The arguments of `transmit` and `request` as they were typed.
struct MessageTexts {
  std::string pgn;
  std::string data;
  std::string file;
  std::string dbc;
  std::vector<std::string> settings;
  std::string to;
  std::string priority;
};

/// Those of `messages`.
struct MessagesTexts {
  std::string file;  ///< of a recording; empty: the messages of the daemon
  std::string interface;
  std::string count;
  std::string dbc;
};

/// To whom, and with which priority, when that was said.
j1939::client::Message with_choice(j1939::client::Message message, const MessageTexts& texts) {
  if (!texts.to.empty()) message.destination = parse_address(texts.to, "--to");
  if (!texts.priority.empty())
    message.priority = static_cast<std::uint8_t>(parse_integer(texts.priority, "--priority", 0, 7));
  return message;
}

j1939::client::Message parse_message(const MessageTexts& texts, Output& output) {
  j1939::client::Message message;
  if (!texts.settings.empty()) {
    if (texts.dbc.empty() || !texts.data.empty() || !texts.file.empty())
      throw UsageError("--set: it needs --dbc and the name of a message, and neither DATA nor --file");
    message = encode_group(load_signals(texts.dbc, output), texts.pgn, texts.settings);
    // The file may be of another machine, where that address is another node.
    if (message.destination != j1939::kGlobalAddress && texts.to.empty())
      throw UsageError(fmt::format(
          "--to: missing; by the file, message '{}' is for address {}: allowed is --to {}, another "
          "address, or all",
          texts.pgn, message.destination, message.destination));
    return with_choice(std::move(message), texts);
  }
  if (!texts.dbc.empty()) throw UsageError("--dbc: it needs --set NAME=VALUE");
  message.pgn = parse_pgn(texts.pgn);
  if (!texts.data.empty() && !texts.file.empty())
    throw UsageError("DATA and --file: the bytes are given twice; give one of them");
  message.data =
      texts.file.empty() ? parse_bytes(texts.data) : read_file(texts.file, j1939_LONG_MESSAGE_BYTES);
  // In packets, seven is what the standard says.
  message.priority = message.data.size() > 8 ? 7 : 6;
  return with_choice(std::move(message), texts);
}

/// Whom a message is for, or is asked.
std::string target_text(std::uint8_t address) {
  return address == 255 ? "all" : fmt::format("address {}", address);
}

ExitCode transmit_verb(Session& session, const MessageTexts& texts) {
  const j1939::client::Message message = parse_message(texts, session.output());
  auto client = connect_bus<MessageClient>(session);
  (void)client.status(session.search_time());
  const auto result = client.request(j1939_MESSAGE_SEND, message, session.monitoring_ms());
  JsonObject object;
  object.add("pgn", message.pgn)
      .add("priority", message.priority)
      .add("destination", message.destination)
      .add("length", static_cast<std::uint32_t>(message.data.size()))
      .add("sent_time_ns", result.sent_time)
      .add("answer_code", result.answer_code);
  const std::string where =
      fmt::format("PGN {} to {}", pgn_text(message.pgn), target_text(message.destination));
  return session.finish(reply_of(result), object, where, where + " sent");
}

ExitCode request_verb(Session& session, const MessageTexts& texts) {
  const j1939::client::Message message = parse_message(texts, session.output());
  auto client = connect_bus<MessageClient>(session);
  (void)client.status(session.search_time());
  const auto result = client.request(j1939_MESSAGE_ASK, message, session.monitoring_ms());
  JsonObject object;
  object.add("pgn", message.pgn)
      .add("destination", message.destination)
      .add("data", bytes_json(result.data))
      .add("answer_time_ns", result.sent_time)
      .add("answer_code", result.answer_code);
  const auto reply = reply_of(result);
  const std::string where =
      fmt::format("request for PGN {} to {}", pgn_text(message.pgn), target_text(message.destination));
  if (!reply.ok() || message.destination == 255) return session.finish(reply, object, where, where + " sent");
  if (!session.json()) session.output().line(bytes_text(result.data));
  return session.finish(reply, object, where, result.data.empty() ? where + " acknowledged" : "");
}

ExitCode daemon_messages(Session& session, MessageLines& lines) {
  auto client = connect_bus<MessageClient>(session);
  constexpr auto kLook = std::chrono::milliseconds(200);
  const auto receive = [&] {
    const bool present = client.receive(
        kLook, [&lines](const j1939_MessageBatch& batch) { lines.show(batch); },
        [&lines](const j1939_LongMessage& message) { lines.show(message); });
    lines.flush();
    return present;
  };
  return receive_until(session, client, receive, [&lines] { return lines.enough(); });
}

/// What of the frames is in no message.
ExitCode tell_counters(Output& output, const j1939::client::RecordedBus::Counters& counters) {
  if (counters.foreign != 0)
    output.remark(text::counted(counters.foreign, "frame is", "frames are") +
                  " not J1939 (11-bit identifiers, remote and error frames)");
  if (counters.incomplete != 0)
    output.remark(text::counted(counters.incomplete, "multi-packet message is", "multi-packet messages are") +
                  " incomplete: packets are missing, or the connection was aborted");
  if (counters.refused != 0)
    output.remark(text::counted(counters.refused, "multi-packet message was", "multi-packet messages were") +
                  " left out: the announcement is wrong, or too many were sent at the same time");
  return counters.incomplete + counters.refused == 0 ? ExitCode::done : ExitCode::in_part;
}

ExitCode recorded_messages(Output& output, TraceSource& source, MessageLines& lines,
                           const std::string& interface) {
  RecordedInterfaces interfaces(interface);
  j1939::client::RecordedBus bus;
  const auto take = [&](const can::CandumpLine& line) {
    const auto number = interfaces.take(line.interface);
    if (!number) return;
    const auto message = bus.receive(*number, line.frame, line.time);
    if (message)
      lines.show({message->end.count(), line.interface, message->number, message->priority, message->source,
                  message->destination, message->transport, std::nullopt, message->data});
  };
  const ExitCode read =
      follow_source(source, output, {take, [&lines] { lines.flush(); }, [&lines] { return lines.enough(); }});
  // What `--count` cut off is not incomplete.
  const ExitCode messages = lines.enough() ? ExitCode::done : tell_counters(output, bus.counters());
  const ExitCode left_out = interfaces.end(output);
  for (const ExitCode code : {read, messages, left_out})
    if (code != ExitCode::done) return code;
  return ExitCode::done;
}

ExitCode messages_verb(Session& session, const MessagesTexts& texts) {
  const std::uint64_t count = parse_end_count(texts.count);
  if (texts.file.empty() && !texts.interface.empty())
    throw UsageError("--only-interface: found without FILE; allowed: with a recording");
  dbc::Database names;
  if (!texts.dbc.empty()) names = load_signals(texts.dbc, session.output());
  const std::string bus = texts.file.empty() ? session.bus() : std::string();  // a recording needs none
  MessageLines lines(session.output(), count, bus, std::move(names));
  if (texts.file.empty()) return daemon_messages(session, lines);
  session.expect_input(texts.file);
  return recorded_messages(session.output(), *open_log(texts.file), lines, texts.interface);
}

std::vector<Table::Column> address_columns() {
  constexpr auto left = Table::Align::left;
  constexpr auto right = Table::Align::right;
  return {{"ADDRESS", right, "claimed by another node; with an asterisk: the daemon's own", 7},
          {"NAME", left, "the 64 bits of its NAME, hexadecimal; of two the lower is the stronger", 16},
          {"IDENTITY", right, "serial number in the NAME", 8},
          {"MAKER", right, "code of the manufacturer", 5},
          {"FUNCTION", right, "code of the function, behind a dot its instance", 8},
          {"GROUP", right, "industry group", 5},
          {"ARBITRARY", left, "yes: it takes another address when it loses its own", 9}};
}

ExitCode addresses_verb(Session& session) {
  auto client = connect_bus<MessageClient>(session);
  const auto status = expect_told(client.status(session.search_time()), "NodeStatus", client.place());
  const auto others = expect_told(client.addresses(session.search_time()), "AddressTable", client.place());
  Table table(address_columns());
  const auto show = [&](int address, std::uint64_t name, bool own) {
    const j1939::NameFields fields = j1939::fields_of(name);
    if (session.json()) {
      JsonObject object;
      object.add("address", address)
          .add("own", own)
          .add("name", fmt::format("{:016X}", name))
          .add("identity", fields.identity)
          .add("manufacturer", fields.manufacturer)
          .add("ecu_instance", fields.ecu_instance)
          .add("function_instance", fields.function_instance)
          .add("function", fields.function)
          .add("vehicle_system", fields.vehicle_system)
          .add("vehicle_system_instance", fields.vehicle_system_instance)
          .add("industry_group", fields.industry_group)
          .add("arbitrary_address", fields.arbitrary_address);
      session.output().object(object);
      return;
    }
    table.add({fmt::format("{}{}", own ? "*" : "", address), fmt::format("{:016X}", name),
               fmt::format("{}", fields.identity), fmt::format("{}", fields.manufacturer),
               fmt::format("{}.{}", fields.function, fields.function_instance),
               fmt::format("{}", fields.industry_group), fields.arbitrary_address ? "yes" : "no"});
  };
  if (status.address >= 0) show(status.address, status.node_name, true);
  for (const j1939_ClaimedAddress& other : others) show(other.address, other.node_name, false);
  if (!session.json()) session.output().table(table);
  return ExitCode::done;
}

std::vector<Table::Column> fault_columns() {
  constexpr auto left = Table::Align::left;
  constexpr auto right = Table::Align::right;
  return {{"FROM", right, "address of the node that tells the fault", 4},
          {"WHEN", left, "active (DM1), or previous (DM2)", 8},
          {"SPN", right, "suspect parameter number", 6},
          {"FMI", right, "failure mode identifier, 0 to 31", 3},
          {"TIMES", right, "how often it occurred; -: not told", 5},
          {"LAMPS", left,
           "lamps of the node that are on: malfunction, stop (red), warning (amber), protect; -: none", 8},
          {"MODE", left, "what the failure mode means; no fault: the node reports none", 0}};
}

/// The lamps that are on.
std::string lamps_on(const j1939_FaultList& list) {
  constexpr std::uint8_t kOn = 1;
  std::string text;
  const std::pair<std::uint8_t, const char*> all[] = {{list.malfunction_lamp, "malfunction"},
                                                      {list.red_stop_lamp, "stop"},
                                                      {list.amber_warning_lamp, "warning"},
                                                      {list.protect_lamp, "protect"}};
  for (const auto& [lamp, name] : all) {
    if (lamp == kOn) text += fmt::format("{}{}", text.empty() ? "" : ",", name);
  }
  return text.empty() ? "-" : text;
}

const char* lamp_text(std::uint8_t lamp) {
  constexpr const char* kLampStates[] = {"off", "on", "reserved", "not-available"};
  return kLampStates[lamp & 3];
}

JsonObject fault_json(const j1939::client::Faults& faults) {
  JsonArray codes;
  for (const j1939_TroubleCode& code : faults.codes) {
    JsonObject one;
    one.add("spn", code.spn).add("fmi", code.fmi).add("occurrences", code.occurrences);
    one.add("old_conversion", code.old_conversion);
    codes.add_json(one.text());
  }
  JsonObject object;
  object.add("source", faults.list.source)
      .add("active", faults.list.active)
      .add("time_ns", faults.list.receive_time)
      .add("malfunction_lamp", lamp_text(faults.list.malfunction_lamp))
      .add("red_stop_lamp", lamp_text(faults.list.red_stop_lamp))
      .add("amber_warning_lamp", lamp_text(faults.list.amber_warning_lamp))
      .add("protect_lamp", lamp_text(faults.list.protect_lamp))
      .add("codes", codes);
  return object;
}

ExitCode faults_verb(Session& session) {
  auto client = connect_bus<MessageClient>(session);
  Table table(fault_columns());
  std::size_t told = 0;
  // What the daemon keeps comes at once; nodes tell theirs once a second.
  constexpr auto kLook = std::chrono::milliseconds(300);
  for (const auto& [key, faults] : client.faults(kLook)) {
    if (session.json()) {
      session.output().object(fault_json(faults));
      continue;
    }
    const std::string from = fmt::format("{}", key.first);
    const std::string when = key.second ? "active" : "previous";
    const std::string lamps = lamps_on(faults.list);
    for (const j1939_TroubleCode& code : faults.codes) {
      table.add({from, when, fmt::format("{}", code.spn), fmt::format("{}", code.fmi),
                 code.occurrences == 127 ? std::string("-") : fmt::format("{}", code.occurrences), lamps,
                 std::string(j1939::dds::failure_mode(code.fmi))});
    }
    if (faults.codes.empty())
      table.add({from, when, "-", "-", "-", lamps, lamps == "-" ? "no fault" : "lamps without a code"});
    ++told;
  }
  if (session.json()) return ExitCode::done;
  session.output().table(table);
  if (told == 0)
    session.output().remark(
        "no node has reported its faults since the daemon started: no DM1 or DM2 was received");
  return ExitCode::done;
}

constexpr std::string_view kOfJ1939 = "Of a bus with bus.protocol = \"j1939\"";

void add_messages(CLI::App& app, Verb& chosen) {
  auto* messages =
      app.add_subcommand("messages", "J1939: show the messages of other nodes, or of a recording");
  messages->group("J1939");
  auto texts = std::make_shared<MessagesTexts>();
  messages->add_option("FILE", texts->file,
                       "a recording instead of the daemon's messages: a candump log, what candump shows on a "
                       "screen, or a pcapng capture; - = standard input");
  messages
      ->add_option("--only-interface", texts->interface, "with FILE: only the frames of this CAN interface")
      ->type_name("NAME");
  messages->add_option("--count", texts->count, "end after so many messages")->type_name("N");
  add_signal_files(*messages, texts->dbc, "name messages and signals by");
  messages->footer(fmt::format("{}: whole messages that its ranges take, until Ctrl-C. Of a FILE\n"
                               "all messages, those between other nodes too, without a daemon.\n",
                               kOfJ1939) +
                   columns_help(message_columns()));
  run_when_named(*messages, chosen, texts, messages_verb);
}

void add_send(CLI::App& app, Verb& chosen) {
  auto* transmit = app.add_subcommand("send", "send a message");
  transmit->group("J1939");
  auto texts = std::make_shared<MessageTexts>();
  transmit->add_option("PGN", texts->pgn, "group in five hexadecimal digits, or 0x..")->required();
  transmit->add_option("DATA", texts->data,
                       "up to 1785 bytes of two hexadecimal digits, e.g. 0102FF; none: no data");
  transmit->add_option("--file", texts->file, "take the bytes from a file, up to 1048576, instead of DATA")
      ->type_name("FILE");
  add_signal_files(*transmit, texts->dbc, "PGN is the name of a message in");
  transmit
      ->add_option("--set", texts->settings,
                   "with --dbc: a signal, in its unit; all others are not available")
      ->type_name("NAME=VALUE")
      ->allow_extra_args(false);
  transmit->add_option("--to", texts->to, "address of the node it is for, 0..253, or all (the default)")
      ->type_name("ADDRESS");
  transmit->add_option("--priority", texts->priority, "0 (most urgent) to 7; default 6, in packets 7")
      ->type_name("N");
  transmit->footer(fmt::format(
      "{}. Over 8 bytes go in packets: to all as a broadcast, to one node by a\nconnection; over 1785 to one node alone, as "
      "many as the daemon's transport.most_bytes allows. Done means that it was on "
      "the bus whole, by a connection that it was acknowledged.",
      kOfJ1939));
  run_when_named(*transmit, chosen, texts, transmit_verb);
}

void add_request(CLI::App& app, Verb& chosen) {
  auto* request = app.add_subcommand("request", "request a message from a node");
  request->group("J1939");
  auto texts = std::make_shared<MessageTexts>();
  request->add_option("PGN", texts->pgn, "group in five hexadecimal digits, or 0x..")->required();
  request->add_option("--to", texts->to, "address of the node that is asked, 0..253, or all (the default)")
      ->type_name("ADDRESS");
  request->add_option("--priority", texts->priority, "of the request, 0 (most urgent) to 7; default 6")
      ->type_name("N");
  request->footer(fmt::format(
      "{}. Prints the bytes of the node's answer. Asked of all it is done when it\nwas sent; the answers come as "
      "messages (cansync j1939 messages).",
      kOfJ1939));
  run_when_named(*request, chosen, texts, request_verb);
}

void add_addresses(CLI::App& app, Verb& chosen) {
  auto* addresses = app.add_subcommand("addresses", "list the claimed addresses");
  addresses->group("J1939");
  addresses->footer(fmt::format("{}: the claims that were heard, and the daemon's own.\n", kOfJ1939) +
                    columns_help(address_columns()));
  addresses->callback([&chosen] { chosen = addresses_verb; });
}

void add_faults(CLI::App& app, Verb& chosen) {
  auto* faults = app.add_subcommand("faults", "list the diagnostic trouble codes of other nodes (DM1, DM2)");
  faults->group("J1939");
  faults->footer(fmt::format("{}: what DM1 and DM2 said last.\n", kOfJ1939) + columns_help(fault_columns()));
  faults->callback([&chosen] { chosen = faults_verb; });
}

void add_verbs_of_j1939(CLI::App& app, Verb& chosen) {
  CLI::App& j1939 =
      add_protocol_verb(app, "j1939", "receive and send messages, list addresses and faults", "J1939");
  for (const AddVerbs add : {add_messages, add_send, add_request, add_addresses, add_faults})
    add(j1939, chosen);
}

constexpr FormerVerb kFormerNodeVerbs[] = {{"messages", "j1939", "messages"},
                                           {"transmit", "j1939", "send"},
                                           {"request", "j1939", "request"},
                                           {"addresses", "j1939", "addresses"},
                                           {"faults", "j1939", "faults"}};

}  // namespace

const ProtocolVerbs j1939_verbs = {add_verbs_of_j1939, &kJ1939StatusPart, kFormerNodeVerbs};

}  // namespace cansync::cli
