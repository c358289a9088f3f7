#include <fmt/format.h>

#include <memory>

#include "cli/base/files.h"
#include "cli/base/verb_groups.h"
#include "cli/cansync/transfer_turn.h"
#include "cli/cansync/verbs.h"
#include "cli/text/progress.h"
#include "text/counts.h"

namespace cansync::cli {
namespace {

/// The arguments as they were typed.
struct TransferOptions {
  std::string slave;
  std::string address;
  std::string length;  ///< upload
  std::string file;
  std::string sub_slave = "0";
  std::string block_size = "0";
};

constexpr std::int64_t kLongestTransfer = 16'777'216;  // bytes
constexpr std::int64_t kLongestBlock = 4092;           // bytes

/// Everything but slave, length and data. Numbers are checked before the slave's name, so that a wrong one is
/// told without a daemon.
client::TransferRequest parse_request(Session& session, const TransferOptions& options) {
  client::TransferRequest request;
  request.address = parse_raw(options.address, "ADDRESS", Width::doubleword);
  request.sub_slave = static_cast<std::uint32_t>(parse_integer(options.sub_slave, "--sub-slave", 0, 65535));
  request.block_size =
      static_cast<std::uint32_t>(parse_integer(options.block_size, "--block-size", 0, kLongestBlock));
  request.timeout_ms = session.monitoring_ms();
  return request;
}

/// An ended transfer.
struct Transferred {
  client::TransferReply reply;
  double seconds = 0.0;  ///< that its intervals took on the bus; waiting for its turn is not among them
};

Transferred run_job(Session& session, const client::TransferRequest& request) {
  // Asked before: a transfer that is done must not fail for want of a status.
  const auto interval = static_cast<double>(session.client().master_status().interval_length);
  ProgressBar bar(stderr);
  TransferTurn turn(session);
  Transferred ended;
  ended.reply = session.ask(
      request.download ? Effect::changes : Effect::reads,
      [&] { return turn.begin(session.client().submit(request)); },
      [&](std::uint32_t done, std::uint32_t total) {
        bar.update(done, total);
        turn.look(done);
      });
  turn.settle(ended.reply);
  ended.seconds = static_cast<double>(ended.reply.intervals) * interval / 1e9;
  return ended;
}

/// E.g. "3000 bytes in 120 intervals, 0.960 s, 3125 bytes/s".
std::string transferred_text(const Transferred& ended) {
  const std::string pace =
      ended.seconds > 0.0 ? fmt::format(", {:.0f} bytes/s", ended.reply.done / ended.seconds) : "";
  return fmt::format("{} in {}, {:.3f} s{}", text::counted(ended.reply.done, "byte"),
                     text::counted(ended.reply.intervals, "interval"), ended.seconds, pace);
}

ExitCode finish(Session& session, const client::TransferRequest& request, const Transferred& ended) {
  const client::TransferReply& reply = ended.reply;
  JsonObject object;
  object.add("slave", request.slave)
      .add("sub_slave", request.sub_slave)
      .add("address", request.address)
      .add("bytes", reply.done)
      .add("error_code", reply.error_code)
      .add("error_offset", reply.error_offset)
      .add("intervals", reply.intervals)
      .add("seconds", ended.seconds)
      .add("repeated_telegrams", reply.repeated_telegrams)
      .add("repeated_blocks", reply.repeated_blocks);
  const std::string where =
      fmt::format("slave {}, {} at 0x{:X}, after {}", request.slave, request.download ? "download" : "upload",
                  request.address, text::counted(reply.done, "byte"));
  return session.finish(
      reply, object, where,
      (session.several() ? fmt::format("slave {}: ", request.slave) : "") + transferred_text(ended));
}

ExitCode upload_one(Session& session, const client::TransferRequest& request, const std::string& path) {
  const bool to_stdout = path == "-";
  std::optional<ReplacementFile> file;
  if (!to_stdout) file.emplace(path);
  const Transferred ended = run_job(session, request);
  const std::vector<std::uint8_t>& data = ended.reply.data;
  std::string kept;
  if (ended.reply.ok()) {
    if (to_stdout)
      session.output().bytes({reinterpret_cast<const char*>(data.data()), data.size()});
    else
      kept = file->commit_and_keep(data);
  }
  if (!kept.empty())
    session.output().remark(fmt::format("{} had other contents; they are in {}", path, kept));
  return finish(session, request, ended);
}

ExitCode upload_verb(Session& session, const TransferOptions& options) {
  if (options.file == "-" && session.json())
    throw UsageError("FILE: '-' and --json both want standard output; name a file");
  client::TransferRequest request;
  const auto length =
      static_cast<std::uint32_t>(parse_integer(options.length, "LENGTH", 1, kLongestTransfer));
  request = parse_request(session, options);
  request.length = length;
  const std::vector<unsigned> slaves = session.slaves(options.slave);
  const std::vector<std::string> files = session.files(options.file, slaves);
  return session.for_each(
      slaves,
      [&](std::size_t index) {
        request.slave = slaves[index];
        return upload_one(session, request, files[index]);
      },
      Session::Lines::grouped);
}

ExitCode download_verb(Session& session, const TransferOptions& options) {
  client::TransferRequest request = parse_request(session, options);
  request.download = true;
  const std::vector<unsigned> slaves = session.slaves(options.slave);
  session.expect_input(options.file);
  request.data = read_file(options.file, static_cast<std::size_t>(kLongestTransfer));
  return session.for_each(
      slaves,
      [&](std::size_t index) {
        request.slave = slaves[index];
        return finish(session, request, run_job(session, request));
      },
      Session::Lines::grouped);
}

void add_common(CLI::App& verb, TransferOptions& options) {
  verb.add_option("--sub-slave", options.sub_slave,
                  "participant below the slave, 0..65535; 0 = the slave itself (default)")
      ->type_name("S");
  verb.add_option(
          "--block-size", options.block_size,
          "bytes of one block, 1..4092; 0 = the slave's limit in the daemon's configuration (default)")
      ->type_name("N");
}

}  // namespace

void add_transfer_verbs(CLI::App& app, Verb& chosen) {
  auto* upload = app.add_subcommand("upload", "bring data from a slave into a file");
  upload->group(kParameterVerbs);
  auto upload_options = std::make_shared<TransferOptions>();
  upload->add_option("SLAVE", upload_options->slave, kSlavesHelp)->required();
  upload->add_option("ADDRESS", upload_options->address, "start address; 0x00..0xFF are the slave's own")
      ->required();
  upload->add_option("LENGTH", upload_options->length, "bytes wanted, 1..16777216")->required();
  upload
      ->add_option(
          "FILE", upload_options->file,
          "file to write, replaced when all has come; - = standard output; for several slaves a name with "
          "{slave} or {name} in it")
      ->required();
  add_common(*upload, *upload_options);
  upload->footer(
      "The slave may fix the length itself; the file then has that length.\nCtrl-C cancels on the bus.");
  upload->callback([upload_options, &chosen] {
    chosen = [upload_options](Session& session) { return upload_verb(session, *upload_options); };
  });

  auto* download = app.add_subcommand("download", "bring a file into a slave");
  download->group(kParameterVerbs);
  auto download_options = std::make_shared<TransferOptions>();
  download->add_option("SLAVE", download_options->slave, kSlavesHelp)->required();
  download->add_option("ADDRESS", download_options->address, "start address; 0x00..0xFF are the slave's own")
      ->required();
  download
      ->add_option("FILE", download_options->file,
                   "file to read, 1..16777216 bytes, the same for every slave; - = standard input")
      ->required();
  add_common(*download, *download_options);
  download->footer("Ctrl-C cancels on the bus; the slave then keeps what had come.");
  download->callback([download_options, &chosen] {
    chosen = [download_options](Session& session) { return download_verb(session, *download_options); };
  });
}

}  // namespace cansync::cli
