#include <cansync/cansync_c_slave.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <deque>
#include <functional>
#include <iterator>
#include <memory>
#include <new>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "cansync_slave/client/application.h"
#include "cansync_slave/client/release_writer.h"
#include "client/src/c_face/handle.h"
#include "client/src/c_face/slave_events.h"
#include "client/src/cansync_slave/slave_link.h"
#include "client/src/causes.h"
#include "client/src/set_up.h"
#include "dds/bounded_text.h"
#include "text/counts.h"

namespace {

namespace client = cansync::client;
using client::c_face::event_of;
using client::c_face::fail;
using client::c_face::guarded;
using SlaveClient = ::cansync_slave::client::SlaveClient;
using std::chrono::milliseconds;

constexpr std::size_t kMostEvents = 1000;
constexpr std::size_t kBlockBytes = sizeof(cansync_slave_event::data);
constexpr milliseconds kFirstState{2000};
constexpr milliseconds kReplyTime{3000};
/// A quarter of the silence after which the daemon takes an application for none.
constexpr milliseconds kPresence{500};

}  // namespace

namespace cansync::client::c_face {

/// A job as the program knows it: each start of the daemon numbers its own from 1, but an answer to one of the start before
/// must not be given to another one.
template <class Job>
struct Asked {
  Job job = {};
  std::uint64_t number = 0;  ///< 0: none was asked

  bool is(const Job& other) const {
    return number != 0 && job.job == other.job &&
           gateway::dds::daemon_of(job) == gateway::dds::daemon_of(other);
  }
};

}  // namespace cansync::client::c_face

/// What stands behind the handle of a slave's application.
struct cansync_application {
  std::unique_ptr<SlaveClient> slave;                       ///< null: not connected
  std::function<bool()> go_on;                              ///< empty: nobody is asked
  std::string error;                                        ///< of the last call
  client::RefusalCause cause = client::RefusalCause::none;  ///< likewise
  std::deque<cansync_slave_event> events;                   ///< that nobody has taken yet
  SlaveClient::Listener listener;
  std::optional<cansync_slave_SlaveCommandReply> reply;  ///< to the command that is waited for
  // The newest that wait for an answer; their sequences are not looked at.
  client::c_face::Asked<cansync_slave_ParameterJob> parameter;
  client::c_face::Asked<cansync_slave_BlockJob> block;
  std::uint64_t jobs = 0;  ///< of both kinds, so far
  // After the client: they end before it.
  std::optional<::cansync_slave::client::Application> duties;
  std::optional<::cansync_slave::client::ReleaseWriter> releases;
};

namespace {

using client::c_face::Asked;

void keep(cansync_application& open, const cansync_slave_event& event) {
  if (open.events.size() == kMostEvents) open.events.pop_front();
  open.events.push_back(event);
}

/// A step of a job: with the number that the program knows it by. One whose beginning was not seen is not the program's.
template <class Job>
void keep_step(cansync_application& open, Asked<Job>& newest, const Job& sample, bool asks) {
  if (asks) {
    const std::uint64_t number = newest.is(sample) ? newest.number : ++open.jobs;
    newest = {sample, number};
  } else if (!newest.is(sample)) {
    return;
  }
  cansync_slave_event event = event_of(sample);
  event.job = newest.number;
  keep(open, event);
}

/// One program answers a job; a program that stands by hears it too.
template <class Job>
bool is_asked(const cansync_application& open, const Job& job) {
  return open.duties && open.duties->is_asked(job);
}

void listen_to_daemon(cansync_application& open) {
  open.listener.references = [&open](const cansync_slave_ReferencesReceived& sample) {
    keep(open, event_of(sample));
  };
  open.listener.monitored = [&open](const cansync_slave_MonitoredValues& sample) {
    if (sample.arrived != 0) keep(open, event_of(sample));
  };
  open.listener.action = [&open](const cansync_slave_ActionReceived& sample) {
    keep(open, event_of(sample));
  };
  open.listener.parameter_job = [&open](const cansync_slave_ParameterJob& sample) {
    if (is_asked(open, sample))
      keep_step(open, open.parameter, sample, sample.step == cansync_slave_JOB_ASKED);
  };
  open.listener.block_job = [&open](const cansync_slave_BlockJob& sample) {
    if (!is_asked(open, sample)) return;
    keep_step(open, open.block, sample, sample.step != cansync_slave_BLOCK_ENDED);
    open.block.job.data = {};
  };
  open.listener.command_reply = [&open](const cansync_slave_SlaveCommandReply& reply) { open.reply = reply; };
}

/// For a handle that must be connected: `call(handle, slave)`.
template <class Call>
int connected_slave(cansync_application* handle, Call&& call) noexcept {
  return guarded(handle, [&](cansync_application& open) {
    if (!open.slave)
      return fail(open, CANSYNC_INVALID,
                  "the handle is not connected; call cansync_application_connect() first");
    return std::forward<Call>(call)(open, *open.slave);
  });
}

int done_or(cansync_application& open, int result, const std::string& problem) {
  return problem.empty() ? static_cast<int>(CANSYNC_DONE) : fail(open, result, "client: " + problem);
}

bool goes_on(const cansync_application& open) {
  return !open.go_on || open.go_on();
}

/// Takes what comes until `done()`, for at most `time`, and says that the program is there. False: the daemon has gone.
template <class Done>
bool look(cansync_application& open, milliseconds time, Done&& done) {
  const auto end = std::chrono::steady_clock::now() + time;
  while (true) {
    if (open.duties) (void)open.duties->keep();
    const auto left = std::chrono::ceil<milliseconds>(end - std::chrono::steady_clock::now());
    if (!open.slave->receive(std::clamp(left, milliseconds{0}, kPresence), open.listener)) return false;
    if (done() || left <= milliseconds{0} || !goes_on(open)) return true;
  }
}

/// `call(application, job)` for the newest job of its kind, unless `problem(job)` says what is wrong with the answer.
template <class Job, class Problem, class Call>
int answer(cansync_application* handle, std::uint64_t job, Asked<Job> cansync_application::*newest,
           Problem&& problem, Call&& call) noexcept {
  return connected_slave(handle, [&](cansync_application& open, SlaveClient& /*slave*/) {
    if (!open.duties)
      return fail(open, CANSYNC_INVALID,
                  "client: nothing is taken over; call cansync_application_take_over() first");
    // The master does not want it any more, and the daemon would drop the answer.
    if (job != 0 && job < (open.*newest).number) return static_cast<int>(CANSYNC_DONE);
    if (job == 0 || (open.*newest).number != job)
      return fail(open, CANSYNC_INVALID,
                  "client: job " + std::to_string(job) + ": is not the newest; allowed " +
                      std::to_string((open.*newest).number));
    if (const std::string wrong = problem((open.*newest).job); !wrong.empty())
      return fail(open, CANSYNC_INVALID, "client: " + wrong);
    return done_or(open, CANSYNC_FAILED, call(*open.duties, (open.*newest).job));
  });
}

/// For answers that cannot be wrong.
constexpr auto kNoProblem = [](const auto& /*job*/) { return std::string(); };

/// An error number below `lowest` would say that the job is done.
auto error_number(std::uint16_t error, unsigned lowest) {
  return [error, lowest](const auto& /*job*/) {
    if (error >= lowest) return std::string();
    return fmt::format("error {}: allowed {}..65535", error, lowest);
  };
}

auto block_size(std::size_t size) {
  return [size](const cansync_slave_BlockJob& /*job*/) {
    if (size <= kBlockBytes) return std::string();
    return fmt::format("{} of data: allowed 0..{}", text::counted(size, "byte"), kBlockBytes);
  };
}

int command(cansync_application* handle, const cansync_slave_SlaveCommand& wanted) noexcept {
  return connected_slave(handle, [&](cansync_application& open, SlaveClient& slave) {
    open.reply.reset();
    const auto end = std::chrono::steady_clock::now() + kReplyTime;
    auto begun = slave.command(wanted);
    // Its endpoints may not have found each other yet. That the daemon was started anew is for the program to hear.
    while (begun.not_begun && begun.not_begun->passes && std::chrono::steady_clock::now() < end) {
      if (!look(open, milliseconds(20), [] { return false; }) || !goes_on(open)) break;
      begun = slave.command(wanted);
    }
    if (begun.not_begun && !begun.not_begun->replied)
      return fail(open, CANSYNC_NO_DAEMON, "client: " + begun.not_begun->reason + " (" + slave.place() + ")");
    if (begun.not_begun) {
      open.cause = client::detail::cause_of(*begun.not_begun);
      return fail(open, CANSYNC_REFUSED, "client: " + begun.not_begun->reason);
    }
    while (std::chrono::steady_clock::now() < end) {
      const bool there = look(open, milliseconds(100), [&] { return open.reply.has_value(); });
      if (open.reply && open.reply->request == begun.request) {
        open.cause = client::detail::to_cause(open.reply->cause);
        const int result = client::c_face::number_of(static_cast<client::ReplyCode>(open.reply->code));
        const std::string reason(gateway::dds::text(open.reply->reason));
        open.reply.reset();
        return result == CANSYNC_DONE ? result : fail(open, result, "daemon: " + reason);
      }
      open.reply.reset();
      if (!there || !goes_on(open)) break;
    }
    return fail(open, CANSYNC_NO_REPLY,
                "client: the daemon has gone or did not answer, or the program did not wait any longer");
  });
}

std::span<const std::uint8_t> bytes_of(const std::uint8_t* data, std::size_t size) {
  return data == nullptr ? std::span<const std::uint8_t>{} : std::span(data, size);
}

}  // namespace

cansync_application* cansync_application_new() noexcept {
  return new (std::nothrow) cansync_application;
}

void cansync_application_free(cansync_application* application) noexcept {
  delete application;
}

const char* cansync_application_last_error(const cansync_application* application) noexcept {
  return application == nullptr ? "the handle is NULL" : application->error.c_str();
}

int cansync_application_last_cause(const cansync_application* application) noexcept {
  return application == nullptr ? static_cast<int>(CANSYNC_CAUSE_NONE) : static_cast<int>(application->cause);
}

int cansync_application_connect(cansync_application* application, const cansync_options* options) noexcept {
  return guarded(application, [&](cansync_application& open) {
    if (open.slave)
      return fail(open, CANSYNC_INVALID, "the handle is connected already; take a new one for another bus");
    const client::Options given = client::c_face::options_of(options);
    // A connection cannot be moved: it is made where it stays. `guarded` catches what that throws.
    // NOLINTNEXTLINE(bugprone-unhandled-exception-at-new)
    open.slave.reset(new SlaveClient(client::detail::connect_to_slave(given)));
    open.go_on = given.go_on;
    listen_to_daemon(open);
    return static_cast<int>(CANSYNC_DONE);
  });
}

int cansync_application_get_state(cansync_application* application, cansync_slave_state* out) noexcept {
  return connected_slave(application, [&](cansync_application& open, SlaveClient& slave) {
    if (out == nullptr) return fail(open, CANSYNC_INVALID, "client: out is NULL");
    const auto status = slave.status(kFirstState);
    if (!slave.daemon_present())
      return fail(open, CANSYNC_NO_DAEMON, "client: no daemon serves the bus (" + slave.place() + ")");
    if (!status) return fail(open, CANSYNC_NO_DATA, "client: the daemon tells nothing of its slave yet");
    *out = client::c_face::state_of(*status);
    return static_cast<int>(CANSYNC_DONE);
  });
}

int cansync_application_receive(cansync_application* application, uint32_t wait_ms,
                                cansync_slave_event* out) noexcept {
  return connected_slave(application, [&](cansync_application& open, SlaveClient& slave) {
    if (out == nullptr) return fail(open, CANSYNC_INVALID, "client: out is NULL");
    const bool there = look(open, open.events.empty() ? milliseconds(wait_ms) : milliseconds{0},
                            [&] { return !open.events.empty(); });
    open.reply.reset();
    if (!open.events.empty()) {
      *out = open.events.front();
      open.events.pop_front();
      return static_cast<int>(CANSYNC_DONE);
    }
    if (!there) return fail(open, CANSYNC_NO_DAEMON, "client: the daemon has gone (" + slave.place() + ")");
    return fail(open, CANSYNC_NO_DATA, "client: nothing came");
  });
}

int cansync_application_take_over(cansync_application* application, const uint16_t* parameters, size_t count,
                                  int sub_slaves, int blocks, int32_t strength) noexcept {
  return connected_slave(application, [&](cansync_application& open, SlaveClient& slave) {
    if (parameters == nullptr && count != 0) return fail(open, CANSYNC_INVALID, "client: parameters is NULL");
    ::cansync_slave::client::Duties duties;
    if (count != 0) duties.parameters.assign(parameters, parameters + count);
    for (const std::uint16_t number : duties.parameters) {
      if (number > 4095)
        return fail(open, CANSYNC_INVALID,
                    "client: parameter " + std::to_string(number) + ": out of range; allowed 0..4095");
    }
    duties.sub_slaves = sub_slaves != 0;
    duties.blocks = blocks != 0;
    if (count == 0 && !duties.sub_slaves && !duties.blocks) {
      open.duties.reset();
      return static_cast<int>(CANSYNC_DONE);
    }
    if (open.duties) return done_or(open, CANSYNC_FAILED, open.duties->take_over(std::move(duties)));
    client::detail::set_up([&] {
      open.duties.emplace(slave, std::move(duties), strength);
      return true;
    });
    return static_cast<int>(CANSYNC_DONE);
  });
}

int cansync_application_answer(cansync_application* application, uint64_t job, uint32_t value,
                               int doubleword) noexcept {
  const auto too_wide = [&](const cansync_slave_ParameterJob& asked) {
    if (asked.write || doubleword != 0 || ::cansync_slave::client::fits_word(value)) return std::string();
    return fmt::format("value {}: wider than a word; allowed -32768..65535, or give it as a doubleword",
                       value);
  };
  return answer(application, job, &cansync_application::parameter, too_wide,
                [&](auto& to, const auto& asked) {
                  const std::uint32_t bits = doubleword != 0 ? value : value & 0xFFFFu;
                  return to.answer(asked, asked.write ? 0 : bits, !asked.write && doubleword != 0);
                });
}

int cansync_application_refuse(cansync_application* application, uint64_t job, uint16_t error) noexcept {
  return answer(application, job, &cansync_application::parameter, error_number(error, 1),
                [&](auto& to, const auto& asked) { return to.refuse(asked, error); });
}

int cansync_application_allow_block(cansync_application* application, uint64_t job, const uint8_t* data,
                                    size_t size, uint16_t length) noexcept {
  return answer(application, job, &cansync_application::block, block_size(size),
                [&](auto& to, const auto& asked) { return to.allow(asked, bytes_of(data, size), length); });
}

int cansync_application_take_block(cansync_application* application, uint64_t job) noexcept {
  return answer(application, job, &cansync_application::block, kNoProblem,
                [](auto& to, const auto& asked) { return to.take(asked); });
}

int cansync_application_step_block(cansync_application* application, uint64_t job, const uint8_t* data,
                                   size_t size) noexcept {
  return answer(application, job, &cansync_application::block, block_size(size),
                [&](auto& to, const auto& asked) { return to.step(asked, bytes_of(data, size)); });
}

int cansync_application_refuse_block(cansync_application* application, uint64_t job,
                                     uint16_t error) noexcept {
  return answer(application, job, &cansync_application::block, error_number(error, 0x0100),
                [&](auto& to, const auto& asked) { return to.refuse(asked, error); });
}

int cansync_application_take_up(cansync_application* application, int32_t strength) noexcept {
  return connected_slave(application, [&](cansync_application& open, SlaveClient& slave) {
    (void)slave.receive(milliseconds{0}, open.listener);
    if (open.releases) {
      open.releases->take_up();
      return static_cast<int>(CANSYNC_DONE);
    }
    client::detail::set_up([&] {
      open.releases.emplace(slave, strength);
      return true;
    });
    return static_cast<int>(CANSYNC_DONE);
  });
}

int cansync_application_release(cansync_application* application, uint32_t telegram, const int32_t raw[4],
                                uint32_t valid, uint32_t wait_intervals) noexcept {
  return connected_slave(application, [&](cansync_application& open, SlaveClient& slave) {
    if (raw == nullptr || (telegram != 1 && telegram != 2) || valid > 0x0F || wait_intervals > 1000)
      return fail(open, CANSYNC_INVALID,
                  "client: allowed: raw not NULL, telegram 1 or 2, valid 0..15, wait_intervals 0..1000");
    if (!open.releases) {
      client::detail::set_up([&] {
        open.releases.emplace(slave, 0);
        return true;
      });
    }
    // A program that takes nothing over may never ask what has come.
    if (!slave.receive(milliseconds{0}, open.listener))
      return fail(open, CANSYNC_NO_DAEMON, "client: the daemon has gone (" + slave.place() + ")");
    if (open.releases->daemon_restarted())
      return fail(
          open, CANSYNC_TAKE_UP,
          "client: the daemon was started anew; look at the slave, then call cansync_application_take_up()");
    std::array<std::uint32_t, 4> values = {};
    std::copy_n(raw, values.size(), values.begin());
    const std::string problem = open.releases->write(static_cast<std::uint8_t>(telegram), values,
                                                     static_cast<std::uint8_t>(valid), wait_intervals);
    return done_or(open, open.releases->waits() ? CANSYNC_REFUSED : CANSYNC_FAILED, problem);
  });
}

int cansync_application_set_mode(cansync_application* application, int mode) noexcept {
  // The numbers of the C face, and the commands that they are.
  static constexpr std::array kModes = {cansync_slave_SLAVE_MODE_SETUP, cansync_slave_SLAVE_MODE_RUN,
                                        cansync_slave_SLAVE_MODE_STOP, cansync_slave_SLAVE_MODE_RESET_CAN,
                                        cansync_slave_SLAVE_MODE_RESTART};
  if (mode < 0 || mode >= static_cast<int>(kModes.size())) {
    return guarded(application, [mode](cansync_application& open) {
      return fail(open, CANSYNC_INVALID,
                  "client: mode " + std::to_string(mode) + ": allowed CANSYNC_MODE_...");
    });
  }
  cansync_slave_SlaveCommand wanted = {};
  wanted.kind = cansync_slave_SLAVE_COMMAND_MODE;
  wanted.mode = kModes[static_cast<std::size_t>(mode)];
  return command(application, wanted);
}

int cansync_application_set_mapping(cansync_application* application, const uint8_t references[8],
                                    const uint8_t actual_values[8]) noexcept {
  if (references == nullptr || actual_values == nullptr) return CANSYNC_INVALID;
  cansync_slave_SlaveCommand wanted = {};
  wanted.kind = cansync_slave_SLAVE_COMMAND_MAPPING;
  std::copy_n(references, 8, std::begin(wanted.reference_mapping));
  std::copy_n(actual_values, 8, std::begin(wanted.actual_mapping));
  return command(application, wanted);
}

int cansync_application_listen(cansync_application* application, uint32_t other,
                               const uint8_t actual_values[8]) noexcept {
  if (actual_values == nullptr || other > 31) return CANSYNC_INVALID;
  cansync_slave_SlaveCommand wanted = {};
  wanted.kind = cansync_slave_SLAVE_COMMAND_LISTEN;
  wanted.other = static_cast<std::uint8_t>(other);
  std::copy_n(actual_values, 8, std::begin(wanted.actual_mapping));
  return command(application, wanted);
}
