#include "cli/cansync_slave/verbs.h"

#include <fmt/format.h>

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "cansync_slave/client/slave_client.h"
#include "cli/base/interrupt.h"
#include "cli/cansync_slave/status_part.h"
#include "cli/connect/bus_verb.h"
#include "cli/text/column_help.h"
#include "cli/text/values.h"

namespace cansync::cli {
namespace {

using cansync_slave::client::SlaveClient;

std::vector<Table::Column> reference_columns() {
  constexpr auto left = Table::Align::left;
  constexpr auto right = Table::Align::right;
  std::vector<Table::Column> columns = {
      {"TIME", left, "when the telegram's last bit was on the bus, in the time zone of this computer", 23},
      {"INTERVAL", right, "number of the interval in which it came", 10},
      {"TELEGRAM", right, "1: WRC1, values 0..3; 2: WRC2, values 4..7", 8}};
  for (const char* value : {"VALUE0", "VALUE1", "VALUE2", "VALUE3", "VALUE4", "VALUE5", "VALUE6", "VALUE7"})
    columns.push_back(
        {value, right, "reference value of that number, raw; - before its telegram came once", 11});
  return columns;
}

bool came(std::uint8_t bits, unsigned telegram) {
  return ((bits >> telegram) & 1u) != 0;
}

/// Raw, with the sign that its width gives it; empty before its telegram came.
std::string reference_text(const cansync_slave_ReferencesReceived& sample, unsigned value) {
  if (!came(sample.ever, value / 4)) return "-";
  const bool word = ((sample.words >> value) & 1u) != 0;
  return fmt::format("{}", as_signed(sample.raw[value], word ? Width::word : Width::doubleword));
}

/// Writes samples until `count` are there; 0: without end.
class ReferenceLines {
 public:
  ReferenceLines(Output& output, std::uint64_t count)
      : output_(output), table_(reference_columns()), count_(count) {}

  void show(const cansync_slave_ReferencesReceived& sample);
  bool enough() const noexcept { return count_ != 0 && shown_ >= count_; }

 private:
  void show_json(const cansync_slave_ReferencesReceived& sample, unsigned telegram);

  Output& output_;
  Table table_;
  std::uint64_t count_;
  std::uint64_t shown_ = 0;
};

void ReferenceLines::show_json(const cansync_slave_ReferencesReceived& sample, unsigned telegram) {
  JsonArray raw;
  for (const std::uint32_t value : sample.raw) raw.add(value);
  JsonObject object;
  object.add("time_ns", sample.receive_time)
      .add("interval", sample.interval[telegram])
      .add("telegram", telegram + 1)
      .add("raw", raw)
      .add("ever", sample.ever)
      .add("lost", sample.lost);
  output_.object(object);
}

void ReferenceLines::show(const cansync_slave_ReferencesReceived& sample) {
  if (enough()) return;
  const unsigned telegram = came(sample.arrived, 1) ? 1 : 0;
  if (output_.json()) {
    show_json(sample, telegram);
  } else {
    if (shown_ == 0) output_.line(table_.heading());
    std::vector<std::string> cells = {time_text(sample.receive_time, true),
                                      fmt::format("{}", sample.interval[telegram]),
                                      fmt::format("{}", telegram + 1)};
    for (unsigned value = 0; value < 8; ++value) cells.push_back(reference_text(sample, value));
    output_.line(table_.line(cells));
  }
  ++shown_;
}

ExitCode references_verb(Session& session, bool follow, const std::string& count_text) {
  const std::uint64_t count = count_text.empty() && !follow ? 1 : parse_end_count(count_text);
  auto client = connect_bus<SlaveClient>(session);
  ReferenceLines lines(session.output(), count);
  SlaveClient::Listener listener;
  listener.references = [&lines](const cansync_slave_ReferencesReceived& sample) { lines.show(sample); };
  constexpr auto kLook = std::chrono::milliseconds(200);
  const auto end = std::chrono::steady_clock::now() + session.search_time();
  while (!interrupt_flag().load() && !lines.enough()) {
    if (!client.receive(kLook, listener) && stays_gone(client)) {
      return end_without_daemon(session, client.place());
    }
    if (follow || lines.enough() || std::chrono::steady_clock::now() < end) continue;
    session.output().remark("no reference values have come; see `cansync status`");
    return ExitCode::failed;
  }
  return ExitCode::done;
}

void add_references(CLI::App& app, Verb& chosen) {
  auto* references = app.add_subcommand("references", "show the reference values that the master sent last");
  references->group("The daemon as a slave");
  auto count = std::make_shared<std::string>();
  auto follow = std::make_shared<bool>(false);
  references->add_flag("--follow", *follow, "every telegram, until Ctrl-C");
  references->add_option("--count", *count, "end after so many telegrams")->type_name("N");
  references->footer(
      "Of a bus with bus.protocol = \"cansync-slave\": one line for each telegram with values.\n" +
      columns_help(reference_columns()));
  references->callback([count, follow, &chosen] {
    chosen = [count, follow](Session& session) { return references_verb(session, *follow, *count); };
  });
}

void add_verbs_of_cansync_slave(CLI::App& app, Verb& chosen) {
  CLI::App& slave =
      add_protocol_verb(app, "slave", "show reference values, release actual values, answer parameter jobs",
                        "The daemon as a slave");
  add_references(slave, chosen);
  add_actual_verb(slave, chosen);
  add_serve_verb(slave, chosen);
}

constexpr FormerVerb kFormerSlaveVerbs[] = {
    {"references", "slave", "references"}, {"actual", "slave", "actual"}, {"serve", "slave", "serve"}};

}  // namespace

const ProtocolVerbs cansync_slave_verbs = {add_verbs_of_cansync_slave, &kSlaveStatusPart, kFormerSlaveVerbs};

}  // namespace cansync::cli
