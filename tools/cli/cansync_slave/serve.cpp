#include <fmt/format.h>

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cansync/slave/block_area.h"
#include "cansync/slave/parameter_table.h"
#include "cansync/telegram/errors.h"
#include "cansync_slave/client/application.h"
#include "cansync_slave/config/parameter_rows.h"
#include "cli/base/interrupt.h"
#include "cli/base/left_out.h"
#include "cli/base/own_process.h"
#include "cli/cansync_slave/verbs.h"
#include "cli/connect/bus_verb.h"
#include "cli/text/column_help.h"
#include "cli/text/values.h"
#include "config/document.h"
#include "config/problem.h"
#include "config/rows.h"
#include "config/settings.h"
#include "profile/named.h"
#include "profile/scaling.h"
#include "text/counts.h"

namespace cansync::cli {
namespace {

using cansync_slave::NamedParameter;
using cansync_slave::ParameterSections;
using cansync_slave::client::Application;
using cansync_slave::client::Duties;
using cansync_slave::client::SlaveClient;

/// Start addresses under which downloads are kept.
constexpr std::size_t kServedBlocks = 16;

struct ServeTexts {
  std::string file;
  std::string profile;
  bool blocks = false;
  std::string strength = "1";
  std::string count;
};

const config::Rows<ParameterSections>& serve_rows() {
  static const std::vector<config::Section> sections = {cansync_slave::kParameterSection};
  static const config::Rows<ParameterSections> rows(
      sections, {config::Part<ParameterSections>(cansync_slave::parameter_rows())});
  return rows;
}

/// The parameters of a profile (null: none) and of a file (empty: none), as [[parameter]] of the daemon's
/// configuration. Throws UsageError.
std::vector<NamedParameter> parameters_of(const profile::Profile* profile, const std::string& path) {
  config::Settings settings;
  if (!path.empty()) settings = config::resolve(config::read_document(path), serve_rows().table());
  std::vector<config::Problem> problems = std::move(settings.problems);
  ParameterSections sections;
  std::map<std::string, config::Position> places;
  for (const config::Setting& setting : settings.items) {
    if (setting.numbers.empty()) continue;
    sections.number = static_cast<unsigned>(setting.numbers.front());
    places[setting.key] = setting.where;
    if (auto text = serve_rows().apply(*setting.option, setting.value, sections))
      problems.push_back({setting.where, setting.key, std::move(*text)});
  }
  std::vector<NamedParameter> parameters = cansync_slave::named_parameters(
      sections, profile, [&](const std::string& key, const std::string& text) {
        const auto place = places.find(key);
        problems.push_back({place == places.end() ? config::Position{path, 0, 0} : place->second, key, text});
      });
  if (problems.empty() && parameters.empty())
    problems.push_back({{path, 0, 0}, "", "found no [[parameter]]; allowed: one and more"});
  config::sort_by_place(problems);
  if (!problems.empty()) throw UsageError(config::problems_message(problems));
  return parameters;
}

std::vector<Table::Column> serve_columns() {
  constexpr auto left = Table::Align::left;
  constexpr auto right = Table::Align::right;
  return {
      {"TIME", left, "when the master's telegram came, in the time zone of this computer", 23},
      {"JOB", right, "its number, given by the daemon", 8},
      {"KIND", left, "read, write, upload or download", 8},
      {"NUMBER", right, "parameter, or start address", 10},
      {"NAME", left, "of the parameter; - without one", 16},
      {"VALUE", right, "value that was read or written, of a name in its unit; of a block its bytes", 11},
      {"RESULT", left,
       "ok, or the error number that the master was answered with; dropped: it was not answered by this, and "
       "nothing was written",
       9}};
}

/// One thing that was asked and how it was answered.
struct Served {
  bool dropped = false;  ///< the answer was not the one that the master got
  std::int64_t time = 0;
  std::uint64_t job = 0;
  const char* kind = "";
  std::uint32_t number = 0;
  std::string name;
  std::string value;
  std::int64_t raw = 0;
  unsigned error = 0;
};

/// Answers from a table of its own. Shows, counts and applies an answer when the daemon says that the master got
/// it; another program may have been asked meanwhile, or the master asks for something else.
class Server {
 public:
  Server(Output& output, const std::vector<NamedParameter>& parameters, std::uint64_t count)
      : output_(output),
        lines_(serve_columns()),
        table_(cansync_slave::definitions_of(parameters)),
        count_(count) {
    for (const NamedParameter& one : parameters) {
      if (!one.description.name.empty()) names_[one.definition.number] = one.description;
    }
  }

  void serve(Application& application, const cansync_slave_ParameterJob& job);
  void serve(Application& application, const cansync_slave_BlockJob& job);

  std::uint64_t served() const noexcept { return served_; }
  bool enough() const noexcept { return count_ != 0 && served_ >= count_; }
  /// What could not be handed to DDS; empty: nothing.
  const std::string& problem() const noexcept { return problem_; }

 private:
  void begin_block(Application& application, const cansync_slave_BlockJob& job);
  bool possible(const cansync_slave_BlockJob& job) const;
  void move_telegram(Application& application, const cansync_slave_BlockJob& job);
  static std::string in_unit(const profile::Parameter& named, std::uint32_t raw);
  void answer(Application& application, const cansync_slave_ParameterJob& job);
  void end_parameter(const cansync_slave_ParameterJob& end);
  void end_block(const cansync_slave_BlockJob& end);
  void show(const Served& served);

  Output& output_;
  Table lines_;
  ParameterTable table_;
  std::map<std::uint16_t, profile::Parameter> names_;
  std::uint64_t count_;
  std::uint64_t served_ = 0;
  bool headed_ = false;
  /// The parameter job that was answered here, and whose end has not come yet.
  struct Answered {
    cansync_slave_ParameterJob job = {};
    Served shown;
  };
  std::optional<Answered> answered_;
  std::map<std::uint32_t, std::vector<std::uint8_t>> blocks_;  ///< by start address
  std::vector<std::uint8_t> coming_;                           ///< a download, telegram by telegram
  cansync_slave_BlockJob open_ = {};                           ///< its sequence is not looked at
  unsigned refused_ = 0;                                       ///< with which the open block was
  std::string problem_;
};

void Server::show(const Served& served) {
  if (!served.dropped) ++served_;
  if (output_.json()) {
    output_.object(JsonObject()
                       .add("time_ns", served.time)
                       .add("job", served.job)
                       .add("kind", served.kind)
                       .add("number", served.number)
                       .add("name", served.name)
                       .add("raw", served.raw)
                       .add("error_code", served.error)
                       .add("dropped", served.dropped));
    return;
  }
  if (!std::exchange(headed_, true)) output_.line(lines_.heading());
  output_.line(
      lines_.line({time_text(served.time, true), fmt::format("{}", served.job), served.kind,
                   fmt::format("{}", served.number), served.name.empty() ? "-" : served.name, served.value,
                   served.dropped      ? "dropped"
                   : served.error == 0 ? "ok"
                                       : fmt::format("0x{:04X}", served.error)}));
}

void Server::serve(Application& application, const cansync_slave_ParameterJob& job) {
  if (!application.is_asked(job)) return;
  if (job.step != cansync_slave_JOB_ASKED) return end_parameter(job);
  if (enough()) return;
  // One is open at a time: the end of the one before was lost on the way.
  if (answered_) {
    cansync_slave_ParameterJob lost = answered_->job;
    lost.step = cansync_slave_JOB_DROPPED;
    end_parameter(lost);
  }
  answer(application, job);
}

void Server::answer(Application& application, const cansync_slave_ParameterJob& job) {
  const auto number = ParameterNumber::from(job.parameter);
  const auto element = Element::from(job.element);
  ParameterAnswer answer;
  answer.error = ParameterError::not_present;
  if (number && element && job.sub_slave == 0) {
    answer = job.write ? table_.check(*number, job.doubleword, job.value) : table_.read(*number, *element);
  }
  const auto error = static_cast<std::uint16_t>(answer.error);
  problem_ =
      error == 0 ? application.answer(job, answer.value, answer.doubleword) : application.refuse(job, error);
  const std::uint32_t raw = job.write ? job.value : answer.value;
  const std::int64_t value =
      as_signed(raw, answer.doubleword || job.doubleword ? Width::doubleword : Width::word);
  const bool known = error == 0 || job.write;
  const auto named = job.sub_slave == 0 ? names_.find(job.parameter) : names_.end();
  const bool has_name = named != names_.end();
  answered_ = Answered{job,
                       {.time = job.time,
                        .job = job.job,
                        .kind = job.write ? "write" : "read",
                        .number = job.parameter,
                        .name = has_name ? named->second.name : "",
                        .value = !known     ? "-"
                                 : has_name ? in_unit(named->second, raw)
                                            : fmt::format("{}", value),
                        .raw = known ? value : 0,
                        .error = error}};
}

void Server::end_parameter(const cansync_slave_ParameterJob& end) {
  if (!answered_ || answered_->job.job != end.job) return;
  Answered answered = *std::exchange(answered_, std::nullopt);
  answered.shown.dropped = end.step != cansync_slave_JOB_ANSWERED;
  const cansync_slave_ParameterJob& job = answered.job;
  const auto number = ParameterNumber::from(job.parameter);
  if (job.write && answered.shown.error == 0 && !answered.shown.dropped && number)
    static_cast<void>(table_.write(*number, job.doubleword, job.value));
  show(answered.shown);
}

/// "12.5 rpm".
std::string Server::in_unit(const profile::Parameter& named, std::uint32_t raw) {
  const std::string number = profile::scaled_text(named, profile::raw_number(named, raw));
  return named.unit.empty() ? number : number + " " + named.unit;
}

/// There is room for a download; of an upload something lies there, and goes as a whole if that is asked.
bool Server::possible(const cansync_slave_BlockJob& job) const {
  const auto block = blocks_.find(job.address);
  if (job.download) return block != blocks_.end() || blocks_.size() < kServedBlocks;
  return block != blocks_.end() && (!job.whole || block->second.size() <= kBlockAreaBytes);
}

void Server::begin_block(Application& application, const cansync_slave_BlockJob& job) {
  open_ = job;
  refused_ = 0;
  coming_.clear();
  if (!possible(job)) {
    refused_ = static_cast<unsigned>(TransferError::not_possible);
    problem_ = application.refuse(job, static_cast<std::uint16_t>(refused_));
    return;
  }
  if (job.download) {
    problem_ = application.allow(job);
    return;
  }
  coming_ = blocks_.at(job.address);
  problem_ = job.whole ? application.allow(job, coming_)
                       : application.allow(job, {}, static_cast<std::uint16_t>(coming_.size()));
}

void Server::move_telegram(Application& application, const cansync_slave_BlockJob& job) {
  const std::size_t end = std::size_t{job.offset} + job.bytes;
  if (coming_.size() < end) coming_.resize(end);
  if (!job.download) {
    problem_ = application.step(job, std::span(coming_).subspan(job.offset, job.bytes));
    return;
  }
  std::copy_n(job.data._buffer, std::min<std::size_t>(job.data._length, job.bytes),
              coming_.begin() + job.offset);
  problem_ = application.step(job);
}

void Server::serve(Application& application, const cansync_slave_BlockJob& job) {
  if (enough() || !application.is_asked(job)) return;
  switch (job.step) {
    case cansync_slave_BLOCK_BEGUN:
      begin_block(application, job);
      break;
    case cansync_slave_BLOCK_COMPLETE:
      coming_.assign(job.data._buffer, job.data._buffer + job.data._length);
      problem_ = application.take(job);
      break;
    case cansync_slave_BLOCK_TELEGRAM:
      move_telegram(application, job);
      break;
    case cansync_slave_BLOCK_ENDED:
      end_block(job);
      break;
  }
}

void Server::end_block(const cansync_slave_BlockJob& end) {
  if (end.job != open_.job) return;
  const bool done = end.result == cansync_slave_BLOCK_DONE;
  const bool refused = end.result == cansync_slave_BLOCK_REFUSED;
  if (done && open_.download) blocks_[open_.address] = coming_;
  const std::size_t bytes = refused ? 0 : coming_.size();
  show({.dropped = !done && !refused,
        .time = end.time,
        .job = open_.job,
        .kind = open_.download ? "download" : "upload",
        .number = open_.address,
        .name = "",
        .value = text::counted(bytes, "byte"),
        .raw = static_cast<std::int64_t>(bytes),
        .error = done      ? 0
                 : refused ? refused_
                           : static_cast<unsigned>(TransferError::cancelled_by_slave)});
}

/// Says on a change whom the daemon takes for the application, when that is not this process: what it refuses
/// and what waits behind a stronger one would hear nothing for ever.
class Hearing {
 public:
  /// What is to be told now; empty: nothing. `application`: of the daemon's newest status.
  std::string look(std::string_view application) {
    const auto now = std::chrono::steady_clock::now();
    if (application != application_) {
      application_ = application;
      since_ = now;
      told_ = false;
    }
    // The status comes once a second, and one application follows another within that.
    if (told_ || now - since_ < std::chrono::milliseconds(2500)) return {};
    told_ = true;
    if (application.find(own_) != std::string_view::npos) return {};
    if (application.empty())
      return "the daemon does not take this application; `cansync events` has the reason "
             "(application_refused)";
    return fmt::format("answers come from {}; this application waits, --strength gives it more weight",
                       application);
  }

 private:
  std::string own_ = name_of_this_process();
  std::string application_;
  std::chrono::steady_clock::time_point since_ = std::chrono::steady_clock::now();
  bool told_ = false;
};

/// Of a profile's parameters the status word stays the daemon's; one that a file alone names is refused by
/// it.
void leave_to_daemon(SlaveClient& client, const profile::Profile* profile,
                     std::vector<NamedParameter>& parameters) {
  if (profile == nullptr) return;
  const auto status = client.status(std::chrono::seconds(2));
  if (!status || profile->find(std::uint32_t{status->status_parameter}) == nullptr) return;
  std::erase_if(parameters, [&status](const NamedParameter& one) {
    return one.definition.number == status->status_parameter;
  });
}

ExitCode serve_verb(Session& session, const ServeTexts& texts) {
  constexpr std::int64_t kStrongest = 2'147'483'647;
  const auto strength = static_cast<std::int32_t>(parse_integer(texts.strength, "--strength", 0, kStrongest));
  const std::uint64_t count = parse_end_count(texts.count);
  if (texts.file.empty() && texts.profile.empty())
    throw UsageError("FILE: is missing; allowed: a file with [[parameter]], --profile PROFILE, or both");
  std::shared_ptr<const profile::Profile> profile;
  if (!texts.profile.empty()) {
    profile::NamedProfile read = profile::load_typed(texts.profile, session.profiles());
    tell_left_out(session.output(), texts.profile, read.left_out);
    profile = std::move(read.profile);
  }
  std::vector<NamedParameter> parameters = parameters_of(profile.get(), texts.file);
  Duties duties;
  duties.blocks = texts.blocks;
  auto client = connect_bus<SlaveClient>(session);
  leave_to_daemon(client, profile.get(), parameters);
  for (const NamedParameter& one : parameters) duties.parameters.push_back(one.definition.number);
  Server server(session.output(), parameters, count);
  Application application(client, duties, strength);
  SlaveClient::Listener listener;
  listener.parameter_job = [&](const cansync_slave_ParameterJob& job) { server.serve(application, job); };
  listener.block_job = [&](const cansync_slave_BlockJob& job) { server.serve(application, job); };
  constexpr auto kTurn = std::chrono::milliseconds(100);
  Hearing hearing;
  while (!interrupt_flag().load() && !server.enough()) {
    std::string problem = application.keep();
    if (problem.empty()) problem = server.problem();
    if (!problem.empty()) return session.finish({client::ReplyCode::no_reply, problem}, {}, "serve", "");
    if (!client.receive(kTurn, listener) && stays_gone(client)) {
      return end_without_daemon(session, client.place());
    }
    if (const auto status = client.status(std::chrono::milliseconds(0))) {
      if (const std::string told = hearing.look(status->application); !told.empty())
        session.output().remark(told);
    }
  }
  session.output().remark(fmt::format("{} answered; {}{} are given back", server.served(),
                                      text::counted(duties.parameters.size(), "parameter"),
                                      texts.blocks ? " and blocks" : ""));
  return ExitCode::done;
}

}  // namespace

void add_serve_verb(CLI::App& app, Verb& chosen) {
  auto* serve = app.add_subcommand("serve", "answer the master's parameter jobs until Ctrl-C");
  serve->group("The daemon as a slave");
  auto texts = std::make_shared<ServeTexts>();
  serve->add_option(
      "FILE", texts->file,
      "TOML file with a [[parameter]] for each number that is taken over, beside those of --profile");
  serve
      ->add_option("--profile", texts->profile,
                   "drive profile whose parameters are taken over: a name or a file")
      ->type_name("PROFILE");
  serve->add_flag(
      "--blocks", texts->blocks,
      "uploads and downloads, too: a download is kept under its start address, one of up to 16, until the "
      "end, and an upload gives what lies there");
  serve
      ->add_option("--strength", texts->strength,
                   "an application that answers is displaced by a stronger one alone; 0 and more (default 1)")
      ->type_name("N");
  serve->add_option("--count", texts->count, "end after so many answers")->type_name("N");
  serve->footer(
      "Of a bus with bus.protocol = \"cansync-slave\". FILE has the same [[parameter]] as the daemon's "
      "configuration; while\nthis runs, its values are what the master reads and writes. One line for each answer.\n" +
      columns_help(serve_columns()));
  run_when_named(*serve, chosen, texts, serve_verb);
}

}  // namespace cansync::cli
