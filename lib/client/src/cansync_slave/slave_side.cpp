#include "client/src/cansync_slave/slave_side.h"

#include <cansync/slave_connection.h>

#include <algorithm>
#include <chrono>
#include <iterator>
#include <utility>

#include "client/src/cansync_slave/slave_link.h"
#include "client/src/causes.h"
#include "client/src/connect_options.h"
#include "client/src/set_up.h"
#include "dds/bounded_text.h"

namespace cansync::client {
namespace detail {
namespace {

/// Steps kept for a block that is not called, as many as the daemon keeps.
constexpr std::size_t kSteps = 100;
/// Takes what a sample brought. A telegram is a new one when its interval is another one than that known, or
/// when it came with this sample at another time: without SYNC there are no intervals. Of the first sample
/// `arrived` says which are.
template <class Sample>
unsigned fresh_telegrams(SlaveSide::Telegrams& known, const Sample& sample, unsigned arrived) {
  unsigned fresh = known.known ? 0 : arrived;
  for (unsigned telegram = 0; telegram < 2; ++telegram) {
    if (((sample.ever >> telegram) & 1u) == 0) continue;
    const bool came = ((sample.arrived >> telegram) & 1u) != 0 && known.time != sample.receive_time;
    const bool other = came || known.interval[telegram] != sample.interval[telegram];
    if (known.known && other) fresh |= 1u << telegram;
    known.interval[telegram] = sample.interval[telegram];
    if (((fresh >> telegram) & 1u) == 0) continue;
    ++known.count[telegram];
    for (unsigned i = 4 * telegram; i < 4 * telegram + 4; ++i)
      known.values[i] = static_cast<std::int32_t>(sample.raw[i]);
  }
  known.known = true;
  known.time = sample.receive_time;
  return fresh;
}

}  // namespace

cansync_slave::client::SlaveClient connect_to_slave(const Options& options) {
  return connect_to<cansync_slave::client::SlaveClient>(options, true);
}

SlaveSide::SlaveSide(const Options& options) : client_(connect_to_slave(options)) {
  listener_.references = [this](const cansync_slave_ReferencesReceived& sample) {
    (void)fresh_telegrams(references_, sample, sample.arrived);
  };
  listener_.monitored = [this](const cansync_slave_MonitoredValues& sample) { note(sample); };
  listener_.action = [this](const cansync_slave_ActionReceived& sample) { note(sample); };
  listener_.parameter_job = [this](const cansync_slave_ParameterJob& sample) { note(sample); };
  listener_.block_job = [this](const cansync_slave_BlockJob& sample) { note(sample); };
  listener_.command_reply = [this](const cansync_slave_SlaveCommandReply& reply) { note(reply); };
  const auto first = client_.status(first_status_wait(options));
  if (!first) throw NoDaemon("the daemon tells nothing of its slave (" + client_.place() + ")");
  status_ = *first;
  daemon_ = gateway::dds::daemon_of(client_.gateway_status());
}

void SlaveSide::look() {
  constexpr std::chrono::milliseconds kNow{0};
  (void)client_.receive(kNow, listener_);
  if (const auto status = client_.status(kNow)) status_ = *status;
  watch_daemon();
  if (application_) problem_ = application_->keep();
}

/// Intervals begin anew with a daemon, and what was open of the one before is over.
void SlaveSide::watch_daemon() {
  const auto daemon = gateway::dds::daemon_of(client_.gateway_status());
  if (daemon == daemon_) return;
  daemon_ = daemon;
  references_.known = false;
  for (Telegrams& one : monitored_) {
    one.known = false;
    one.mapping = {};
  }
}

/// The first sample of a slave may be what the daemon kept from long ago: nothing of it is new.
void SlaveSide::note(const cansync_slave_MonitoredValues& sample) {
  if (sample.slave >= monitored_.size()) return;
  Telegrams& known = monitored_[sample.slave];
  std::copy(std::begin(sample.mapping), std::end(sample.mapping), known.mapping.begin());
  const unsigned fresh = fresh_telegrams(known, sample, 0);
  for (unsigned telegram = 0; telegram < heard_.size(); ++telegram) {
    if (((fresh >> telegram) & 1u) == 0) continue;
    ++heard_[telegram].count;
    heard_[telegram].slave = sample.slave;
  }
}

void SlaveSide::note(const cansync_slave_ActionReceived& sample) {
  if (sample.kind == cansync_slave_ACTION_SYNC_MODE) return;
  Action& action = sample.kind == cansync_slave_ACTION_CONTROL_WORD ? control_word_ : broadcast_;
  ++action.count;
  action.command = sample.command;
  action.data_byte = sample.data_byte;
  action.data_word = sample.data_word;
}

void SlaveSide::note(const cansync_slave_ParameterJob& sample) {
  if (duties_.parameters.empty() || !is_asked(sample)) return;
  if (parameter_steps_.size() == kSteps) parameter_steps_.pop_front();
  parameter_steps_.push_back(sample);
}

void SlaveSide::note(const cansync_slave_BlockJob& sample) {
  if (!duties_.blocks || !is_asked(sample)) return;
  if (block_steps_.size() == kSteps) block_steps_.pop_front();
  BlockStep step{sample, {sample.data._buffer, sample.data._buffer + sample.data._length}};
  step.job.data = {};
  block_steps_.push_back(std::move(step));
}

void SlaveSide::note(const cansync_slave_SlaveCommandReply& reply) {
  // What nobody waits for any more is old.
  if (command_replies_.size() == kSteps) command_replies_.erase(command_replies_.begin());
  command_replies_[reply.request] = {static_cast<ReplyCode>(reply.code), to_cause(reply.cause),
                                     std::string(gateway::dds::text(reply.reason))};
}

std::optional<SlaveSide::CommandReply> SlaveSide::take_command_reply(std::uint64_t request) {
  const auto found = command_replies_.extract(request);
  if (found.empty()) return std::nullopt;
  return found.mapped();
}

void SlaveSide::attach_parameters() {
  if (std::exchange(has_parameters_, true)) throw SetupError("this connection has a PAR_SL already");
}

void SlaveSide::attach_blocks() {
  if (std::exchange(has_blocks_, true)) throw SetupError("this connection has an UPDOWNLOAD_SL already");
}

void SlaveSide::detach_parameters() noexcept {
  has_parameters_ = false;
  try {
    serve_parameters({});
  } catch (...) {
    // The daemon finds out by itself that nobody answers (slave.answer_time_ms).
  }
}

void SlaveSide::detach_blocks() noexcept {
  has_blocks_ = false;
  try {
    serve_blocks(false);
  } catch (...) {
    // As above.
  }
}

void SlaveSide::serve_parameters(const std::vector<std::uint16_t>& numbers) {
  if (numbers == duties_.parameters) return;
  duties_.parameters = numbers;
  parameter_steps_.clear();
  take_over();
}

void SlaveSide::serve_blocks(bool wanted) {
  if (wanted == duties_.blocks) return;
  duties_.blocks = wanted;
  block_steps_.clear();
  take_over();
}

void SlaveSide::take_over() {
  problem_.clear();
  if (duties_.parameters.empty() && !duties_.blocks) {
    application_.reset();
  } else if (application_) {
    problem_ = application_->take_over(duties_);
  } else {
    set_up([this] {
      application_.emplace(client_, duties_, 0);
      return true;
    });
  }
}

cansync_slave::client::Application* SlaveSide::application() noexcept {
  return application_ ? &*application_ : nullptr;
}

}  // namespace detail

SlaveConnection::SlaveConnection(std::unique_ptr<detail::SlaveSide> side) noexcept : side_(std::move(side)) {}
SlaveConnection::SlaveConnection(SlaveConnection&& other) noexcept = default;
SlaveConnection& SlaveConnection::operator=(SlaveConnection&& other) noexcept = default;
SlaveConnection::~SlaveConnection() = default;

SlaveConnection SlaveConnection::connect(const Options& options) {
  return SlaveConnection(std::make_unique<detail::SlaveSide>(options));
}

bool SlaveConnection::daemon_present() const {
  return side_->daemon_present();
}

}  // namespace cansync::client
