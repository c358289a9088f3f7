#include "cli/layer2/dump_verb.h"

#include <fmt/format.h>

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cli/base/files.h"
#include "cli/base/interrupt.h"
#include "cli/connect/bus_verb.h"
#include "cli/dbc/dbc_file.h"
#include "cli/layer2/dump_filter.h"
#include "cli/layer2/dump_form.h"
#include "cli/text/column_help.h"
#include "cli/text/values.h"
#include "cli/trace/follow_source.h"
#include "cli/trace/trace_source.h"
#include "layer2/client/frame_client.h"
#include "layer2/dds/convert.h"
#include "text/counts.h"

namespace cansync::cli {
namespace {

/// The arguments of `can dump` as they were typed.
struct DumpTexts {
  std::string file;  ///< of a recording; empty: the frames of the daemon
  std::string interface;
  std::string count;
  std::vector<std::string> identifiers;
  std::string kind;
  bool candump = false;
  std::string write;
  std::string dbc;
  bool force = false;
};

/// Writes the frames that are wanted until `count` are there; 0: without end.
class Dump {
 public:
  Dump(Output& output, DumpFilter filter, DumpForm::Choice form, std::string bus, std::uint64_t count)
      : output_(output),
        filter_(std::move(filter)),
        form_(output, std::move(form)),
        bus_(std::move(bus)),
        count_(count) {}

  /// Those of a daemon.
  void take(const layer2_FrameBatch& batch);
  /// One of a daemon or of a recording.
  void take(const DumpedFrame& frame) {
    if (!filter_.takes(frame.frame)) return;
    form_.write(frame);
    ++shown_;
  }
  void flush() { form_.flush(); }
  bool enough() const noexcept { return count_ != 0 && shown_ == count_; }
  std::uint64_t shown() const noexcept { return shown_; }

 private:
  void tell_missed(const layer2_FrameBatch& batch);

  Output& output_;
  DumpFilter filter_;
  DumpForm form_;
  std::string bus_;  ///< the daemon's
  std::uint64_t count_;
  std::uint64_t shown_ = 0;
  std::uint64_t number_ = 0;  ///< of the last batch; 0: none yet
  std::uint64_t next_ = 0;    ///< number of the frame that comes next
  std::uint64_t lost_ = 0;
};

void Dump::tell_missed(const layer2_FrameBatch& batch) {
  if (number_ != 0 && batch.number <= number_) {
    output_.remark("the daemon was started anew; frames may have been missed");
    number_ = 0;
  }
  if (number_ != 0 && batch.first > next_)
    output_.remark(text::counted(batch.first - next_, "frame was missed", "frames were missed") +
                   ", for this program reads too slowly");
  if (number_ != 0 && batch.lost != lost_)
    output_.remark(text::counted(batch.lost - lost_, "frame") + " came faster than the daemon could publish");
  number_ = batch.number;
  next_ = batch.first + batch.frames._length;
  lost_ = batch.lost;
}

void Dump::take(const layer2_FrameBatch& batch) {
  tell_missed(batch);
  for (std::uint32_t i = 0; i < batch.frames._length && !enough(); ++i) {
    const layer2_ReceivedFrame& received = batch.frames._buffer[i];
    take({received.receive_time, layer2::dds::to_core(received.received), bus_,
          TakenBy{received.range_index, received.high_priority}});
  }
}

DumpFilter filter_of(const DumpTexts& texts) {
  DumpFilter filter;
  for (const std::string& list : texts.identifiers) filter.add_identifiers(list);
  if (!texts.kind.empty()) filter.set_kind(texts.kind);
  return filter;
}

ExitCode dump_daemon(Session& session, Dump& dump) {
  auto client = connect_bus<layer2::client::FrameClient>(session);
  constexpr auto kLook = std::chrono::milliseconds(200);
  const auto receive = [&] {
    const bool present = client.receive(kLook, [&dump](const layer2_FrameBatch& batch) { dump.take(batch); });
    dump.flush();
    return present;
  };
  return receive_until(session, client, receive, [&dump] { return dump.enough(); });
}

/// Error frames are what a controller saw, and no frames of a node.
ExitCode dump_recording(Output& output, TraceSource& source, Dump& dump, const std::string& interface) {
  RecordedInterfaces interfaces(interface);
  std::uint64_t errors = 0;
  const auto take = [&](const can::CandumpLine& line) {
    if (!interfaces.take(line.interface)) return;
    if (line.frame.error) {
      ++errors;
    } else {
      dump.take({std::chrono::nanoseconds(line.time).count(), line.frame, line.interface, std::nullopt});
    }
  };
  const ExitCode read =
      follow_source(source, output, {take, [&dump] { dump.flush(); }, [&dump] { return dump.enough(); }});
  if (errors != 0)
    output.remark(text::counted(errors, "error frame is", "error frames are") +
                  " not shown; `cansync trace` shows them");
  const ExitCode left_out = interfaces.end(output);
  return read == ExitCode::done ? left_out : read;
}

ExitCode dump_verb(Session& session, const DumpTexts& texts) {
  const std::uint64_t count = parse_end_count(texts.count);
  if (int{texts.candump} + int{!texts.write.empty()} + int{session.json()} > 1)
    throw UsageError("--candump, --write, --json: found more than one; allowed: one of the three");
  if (texts.file.empty() && !texts.interface.empty())
    throw UsageError("--only-interface: found without FILE; allowed: with a recording");
  const DumpFilter filter = filter_of(texts);
  if (!texts.write.empty()) expect_new_file(texts.write, "--write", texts.force);
  DumpForm::Choice form{texts.candump, texts.write, {}};
  if (!texts.dbc.empty()) form.names = load_signals(texts.dbc, session.output());
  std::unique_ptr<TraceSource> source;
  if (!texts.file.empty()) {
    session.expect_input(texts.file);
    source = open_log(texts.file);
  }
  const std::string bus = source ? std::string() : session.bus();  // a recording names its interfaces itself
  Dump dump(session.output(), filter, std::move(form), bus, count);
  const ExitCode code =
      source ? dump_recording(session.output(), *source, dump, texts.interface) : dump_daemon(session, dump);
  if (!texts.write.empty() && texts.write != "-")
    session.output().remark(text::counted(dump.shown(), "frame") + " written to " + texts.write);
  return code;
}

}  // namespace

void add_dump_verb(CLI::App& can, Verb& chosen) {
  auto* dump = can.add_subcommand("dump", "Show the frames of a bus, or of a recording");
  auto texts = std::make_shared<DumpTexts>();
  dump->add_option(
      "FILE", texts->file,
      "a recording instead of the daemon's frames: a candump log, what candump shows on a screen, "
      "or a pcapng capture; - = standard input");
  dump->add_option("--only-interface", texts->interface, "with FILE: only the frames of this CAN interface")
      ->type_name("NAME");
  dump->add_option("--count", texts->count, "end after so many frames")->type_name("N");
  dump->add_option("--id", texts->identifiers,
                   "these identifiers alone: 123, 18DAF110, 100-1FF, 120:7F0 (identifier:mask), with commas "
                   "between")
      ->type_name("LIST")
      ->expected(1)
      ->take_all();
  dump->add_option("--kind", texts->kind, "data frames or remote frames alone")->type_name("data|remote");
  add_signal_files(*dump, texts->dbc, "name messages and signals by");
  dump->add_flag("--candump", texts->candump, "write a text log as candump -L does instead");
  dump->add_option("--write", texts->write, "write a pcapng capture into FILE instead; - = stdout")
      ->type_name("FILE");
  dump->add_flag("--force", texts->force, "replace the FILE of --write when it is there already");
  dump->footer(
      "Of a bus with bus.protocol = \"layer2\": frames of other nodes that its ranges take, until Ctrl-C. Of a\n"
      "FILE all frames, without a daemon; what is not understood is reported, and the exit code is then 11.\n"
      "Examples:\n"
      "  cansync can dump --write - | wireshark -k -i -\n"
      "  cansync can dump drive.log --dbc machine.dbc --id 100-1FF\n" +
      columns_help(dump_columns()));
  run_when_named(*dump, chosen, texts, dump_verb);
}

}  // namespace cansync::cli
