#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <memory>

#include "cli/base/verb_groups.h"
#include "cli/connect/bus_connection.h"
#include "cli/connect/gateway_reply.h"
#include "cli/jobs/verbs.h"
#include "cli/text/column_help.h"
#include "dds/bounded_text.h"
#include "dds/overview/desk_client.h"

namespace cansync::cli {
namespace {

using gateway::dds::DeskClient;
using gateway::dds::OpenRequestsNow;
using gateway::dds::text;

/// A daemon that tells something of requests tells it at once.
constexpr std::chrono::milliseconds kForTheFirst{2000};

/// Throws Ended when the daemon tells nothing of requests.
OpenRequestsNow open_requests(DeskClient& desk) {
  if (auto now = desk.open(kForTheFirst)) return *std::move(now);
  if (interrupt_flag().load()) throw Interrupted();
  throw std::runtime_error(
      fmt::format("the daemon (cansyncd {}, bus.protocol \"{}\") tells nothing of requests: its protocol has "
                  "none, or it is older than this program",
                  text(desk.gateway_status().version), text(desk.gateway_status().protocol)));
}

double seconds_open(std::int64_t time) {
  const std::int64_t now = std::chrono::duration_cast<std::chrono::nanoseconds>(
                               std::chrono::system_clock::now().time_since_epoch())
                               .count();
  return static_cast<double>(std::max(now - time, std::int64_t{0})) / 1e9;
}

std::string state_of(const gateway_OpenRequest& request) {
  if (request.waits)
    return request.behind == 0 ? std::string("waits") : fmt::format("behind {}", request.behind);
  if (request.total == 0) return "runs";
  return fmt::format("{} %", std::uint64_t{100} * request.done / request.total);
}

std::vector<Table::Column> job_columns() {
  constexpr auto left = Table::Align::left;
  constexpr auto right = Table::Align::right;
  return {{"JOB", right, "its number, for `cancel`; each start of a daemon has other numbers"},
          {"STATE", left,
           "how far a transfer is; runs = its turn has come; behind 7 = it waits for the end of job 7, and "
           "nothing of it was sent"},
          {"FOR s", right, "seconds since the daemon has it"},
          {"WHAT", left, "what was asked for"},
          {"WHOSE", left, "name, process and computer of its client, as that says itself"}};
}

JsonObject job_object(const OpenRequestsNow& now, const gateway_OpenRequest& request) {
  JsonObject object;
  object.add("job", request.job)
      .add("waits", static_cast<bool>(request.waits))
      .add("behind", request.behind)
      .add("time_ns", request.time)
      .add("text", text(request.text))
      .add("done", request.done)
      .add("total", request.total)
      .add("client", text(request.name))
      .add("owner", owner_of(now, request));
  return object;
}

/// What one sample had no room for.
void tell_rest(Output& output, std::size_t shown, std::size_t all, std::string_view what) {
  if (shown < all) output.remark(fmt::format("{} of {} {} are shown", shown, all, what));
}

ExitCode jobs_verb(Session& session) {
  auto desk = connect_bus<DeskClient>(session);
  const OpenRequestsNow now = open_requests(desk);
  Table table(job_columns());
  for (const gateway_OpenRequest& request : now.requests) {
    if (session.json()) {
      session.output().object(job_object(now, request));
      continue;
    }
    table.add({fmt::to_string(request.job), state_of(request),
               fmt::format("{:.1f}", seconds_open(request.time)), std::string(text(request.text)),
               owner_of(now, request)});
  }
  if (!session.json()) session.output().table(table);
  tell_rest(session.output(), now.requests.size(), now.open, "open requests");
  return ExitCode::done;
}

std::vector<Table::Column> client_columns() {
  constexpr auto left = Table::Align::left;
  return {{"NAME", left, "that the client gave itself; - = it has asked for nothing yet"},
          {"PROGRAM", left, "name of its process"},
          {"PROCESS", Table::Align::right, "its number"},
          {"HOST", left, "the computer it runs on"},
          {"OPEN", Table::Align::right, "requests of its that are not answered"}};
}

std::string or_dash(std::string_view word) {
  return word.empty() ? "-" : std::string(word);
}

ExitCode clients_verb(Session& session) {
  auto desk = connect_bus<DeskClient>(session);
  const OpenRequestsNow now = open_requests(desk);
  Table table(client_columns());
  for (const gateway_ConnectedProgram& program : now.programs) {
    if (session.json()) {
      session.output().object(JsonObject()
                                  .add("name", text(program.name))
                                  .add("program", text(program.program))
                                  .add("process", program.process)
                                  .add("host", text(program.host))
                                  .add("open", program.open));
      continue;
    }
    table.add({or_dash(text(program.name)), or_dash(text(program.program)),
               program.process == 0 ? "-" : fmt::to_string(program.process), or_dash(text(program.host)),
               fmt::to_string(program.open)});
  }
  if (!session.json()) session.output().table(table);
  tell_rest(session.output(), now.programs.size(), now.connected, "connected programs");
  return ExitCode::done;
}

ExitCode cancel_verb(Session& session, const std::string& typed) {
  constexpr std::int64_t kHighestJob = std::int64_t{1} << 53;
  // Time for the slave to be told, too.
  constexpr std::chrono::milliseconds kForTheEnd{2000};
  const auto job = static_cast<std::uint64_t>(parse_integer(typed, "JOB", 1, kHighestJob));
  auto desk = connect_bus<DeskClient>(session);
  const DeskClient::EndedOther ended = desk.end(job);
  const client::Reply reply = reply_of(ended);
  std::string done;
  if (reply.ok()) {
    done = fmt::format("{} {}", ended.what,
                       desk.wait_end(job, kForTheEnd)
                           ? "is ended"
                           : "is being ended; what stands on the bus already ends by itself");
  }
  JsonObject object;
  object.add("job", job).add("ended", ended.what);
  return session.finish(reply, object, fmt::format("job {}", job), done);
}

}  // namespace

void add_job_verbs(CLI::App& app, Verb& chosen) {
  auto* jobs = app.add_subcommand("jobs", "requests of all programs that the daemon has not answered yet");
  jobs->group(kLookingVerbs);
  jobs->footer(columns_help(job_columns()));
  jobs->callback([&chosen] { chosen = jobs_verb; });

  auto* cancel = app.add_subcommand("cancel", "end a job, whoever's it is");
  cancel->group(kLookingVerbs);
  auto job = std::make_shared<std::string>();
  cancel->add_option("JOB", *job, "number of the job, as `jobs` shows it")->required();
  cancel->footer(
      "Its client is told that it was cancelled. A transfer is cancelled at the slave, too, which keeps what "
      "had come.\nWith DDS Security engineers may do it.");
  cancel->callback(
      [job, &chosen] { chosen = [job](Session& session) { return cancel_verb(session, *job); }; });

  auto* clients = app.add_subcommand("clients", "programs that are connected to the daemon");
  clients->group(kLookingVerbs);
  clients->footer(columns_help(client_columns()));
  clients->callback([&chosen] { chosen = clients_verb; });
}

}  // namespace cansync::cli
