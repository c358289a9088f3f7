#include <fmt/format.h>

#include <memory>
#include <stdexcept>
#include <string>
#include <utility>

#include "cansync/config/file.h"
#include "cli/base/files.h"
#include "cli/base/verb_groups.h"
#include "cli/cansync/sync_identifier.h"
#include "cli/cansync/trace_text.h"
#include "cli/text/column_help.h"
#include "cli/text/slave_list.h"
#include "cli/trace/follow_source.h"
#include "cli/trace/trace_source.h"
#include "cli/trace/trace_writer.h"
#include "cli/trace/verbs.h"

namespace cansync::cli {
namespace {

struct TraceTexts {
  std::string source;
  std::string slave;
  std::string count = "0";
  std::string sync;
  std::string pcapng;
  std::string config;  ///< of a daemon; empty: a running one is asked for names
  bool candump = false;
  bool force = false;
};

JsonObject telegram_object(const TracedTelegram& telegram, const can::CandumpLine& line) {
  JsonObject object;
  object.add("time_us", telegram.time.count());
  telegram.after_sync ? object.add("after_sync_us", telegram.after_sync->count())
                      : object.add_null("after_sync_us");
  object.add("interface", line.interface).add("identifier", line.frame.id).add("channel", telegram.channel);
  telegram.slave ? object.add("slave", *telegram.slave) : object.add_null("slave");
  JsonArray data;
  for (unsigned i = 0; i < line.frame.dlc && i < line.frame.data.size(); ++i) data.add(line.frame.data[i]);
  return object.add("data", data).add("text", telegram.words);
}

/// One run of the verb.
class Tracer {
 public:
  Tracer(Output& output, const TraceTexts& texts, std::uint32_t slaves, std::uint32_t sync)
      : output_(output), candump_(texts.candump), slaves_(slaves), text_(sync) {
    if (texts.pcapng.empty()) return;
    expect_new_file(texts.pcapng, "--pcapng", texts.force);
    capture_.emplace(texts.pcapng, output, "--pcapng");
  }

  void show(const can::CandumpLine& line) {
    const TracedTelegram telegram = text_.describe(line);
    if (slaves_ != 0 && (telegram.slaves & slaves_) == 0) return;
    if (capture_) {
      capture_->write(line.time, line.interface, line.frame);
    } else if (output_.json()) {
      waiting_ += telegram_object(telegram, line).text() + '\n';
    } else if (candump_) {
      std::array<char, can::kCandumpLineLimit> text{};
      waiting_.append(text.data(), can::write_candump_line(line.time, line.interface, line.frame, text));
    } else {
      if (shown_ == 0) waiting_ += trace_heading() + '\n';
      waiting_ += trace_line(telegram) + '\n';
    }
    ++shown_;
    if (waiting_.size() >= kMostWaiting) flush();
  }

  void flush() {
    if (capture_) capture_->flush();
    if (!waiting_.empty()) output_.bytes(std::exchange(waiting_, {}));
  }

  std::int64_t shown() const noexcept { return shown_; }

 private:
  static constexpr std::size_t kMostWaiting = 65536;

  Output& output_;
  bool candump_;
  std::optional<TraceCapture> capture_;
  std::uint32_t slaves_;  ///< mask; 0: everything is shown
  TraceText text_;
  std::int64_t shown_ = 0;
  std::string waiting_;  ///< data that are not written yet
};

/// Mask of a list of slaves; names are those of `texts.config`, or of a running daemon.
std::uint32_t wanted_slaves(Session& session, const TraceTexts& texts) {
  if (texts.slave.empty()) return 0;
  if (texts.config.empty()) return session.slave_mask(texts.slave);
  const cansyncd::ConfigFile file = cansyncd::load_config(texts.config, {});
  if (!file.problems.empty())
    throw std::runtime_error(fmt::format("{}; `cansyncd --check {}` tells everything that is wrong",
                                         config::to_string(file.problems.front()), texts.config));
  const cansyncd::Config& line = file.config;
  const auto name_of = [&line](unsigned slave) { return std::string_view(line.slaves[slave].name); };
  const auto find = [&](std::string_view name) {
    for (unsigned slave = 0; slave < kSlaves; ++slave)
      if (line.master.slaves[slave].configured && name_of(slave) == name) return static_cast<int>(slave);
    return -1;
  };
  const auto configured = [&line] { return line.master.configured().bits; };
  const auto problem = [&](std::string_view name) {
    std::string names;
    for (unsigned slave = 0; slave < kSlaves; ++slave)
      if (line.master.slaves[slave].configured && !name_of(slave).empty())
        names += fmt::format("{}{}", names.empty() ? "" : ", ", name_of(slave));
    return fmt::format("'{}': no slave of {} has this name; allowed: 0..31 or {}", name, texts.config,
                       names.empty() ? "a name, but none has one" : names);
  };
  return parse_slave_list(texts.slave, {find, configured, problem});
}

ExitCode trace_verb(Session& session, const TraceTexts& texts) {
  const std::int64_t count = parse_integer(texts.count, "--count", 0, 1'000'000'000);
  const std::uint32_t sync = parse_sync_identifier(texts.sync, session.output());
  if (texts.candump && session.json())
    throw UsageError("--candump: found together with --json; allowed: one of the two");
  if (!texts.pcapng.empty() && (texts.candump || session.json()))
    throw UsageError("--pcapng: found together with --candump or --json; allowed: one of the three");
  const std::uint32_t slaves = wanted_slaves(session, texts);
  session.expect_input(texts.source);
  const auto source = open_trace_source(texts.source, sync);
  Tracer tracer(session.output(), texts, slaves, sync);
  return follow_source(
      *source, session.output(),
      {[&tracer](const can::CandumpLine& line) { tracer.show(line); }, [&tracer] { tracer.flush(); },
       [&tracer, count] { return count != 0 && tracer.shown() == count; }});
}

}  // namespace

void add_trace_verb(CLI::App& app, Verb& chosen) {
  auto* trace = app.add_subcommand("trace", "the frames of a line in words, from a log or live");
  trace->group(kLookingVerbs);
  auto texts = std::make_shared<TraceTexts>();
  trace
      ->add_option(
          "SOURCE", texts->source,
          "a candump text log (candump -L, or the trace of the simulated line) or a pcapng capture, - for "
          "standard input, or a SocketCAN interface, which is only listened to")
      ->required();
  trace
      ->add_option("--slave", texts->slave,
                   "only what concerns these slaves: number, name, or a list such as 1,3,5-9")
      ->type_name("SLAVE");
  trace
      ->add_option("--config", texts->config,
                   "configuration of cansyncd that names the slaves, instead of a running daemon")
      ->type_name("FILE");
  trace->add_option("--count", texts->count, "end after N frames; 0 = all (default)")->type_name("N");
  trace
      ->add_option("--sync", texts->sync,
                   "identifier of the frame that marks SYNC, hexadecimal, 000..7FF (default 080)")
      ->type_name("ID");
  trace->add_flag("--candump", texts->candump, "write the frames as a candump text log instead");
  trace
      ->add_option("--pcapng", texts->pcapng,
                   "write the frames as a pcapng capture into FILE instead; - = stdout")
      ->type_name("FILE");
  trace->add_flag("--force", texts->force, "replace the FILE of --pcapng when it is there already");
  trace->footer(
      "No daemon is needed, except to look up a slave's name. Lines that are no frames are named and "
      "counted;\n"
      "then the exit code is 11, or 1 when there is no frame at all.\n"
      "Examples:\n"
      "  candump -L can0 | cansync trace - --slave 3\n"
      "  cansync trace can0 --pcapng - | wireshark -k -i -\n" +
      columns_help(trace_columns()));
  trace->callback(
      [texts, &chosen] { chosen = [texts](Session& session) { return trace_verb(session, *texts); }; });
}

}  // namespace cansync::cli
