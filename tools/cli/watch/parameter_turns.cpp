#include "cli/watch/parameter_turns.h"

#include <fmt/format.h>

#include <utility>

#include "cli/base/interrupt.h"
#include "cli/watch/watch_rows.h"

namespace cansync::cli {

ParameterTurns::ParameterTurns(client::Client& client, std::vector<WatchedSlave> slaves,
                               std::uint32_t timeout_ms)
    : client_(client), timeout_ms_(timeout_ms), slaves_(std::move(slaves)) {
  if (!slaves_.empty()) reader_ = std::thread([this] { run(); });
}

ParameterTurns::~ParameterTurns() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  changed_.notify_all();
  if (reader_.joinable()) reader_.join();
}

void ParameterTurns::begin_round() {
  const std::lock_guard lock(mutex_);
  if (slaves_.empty() || reading_) return;
  reading_ = true;
  changed_.notify_all();
}

void ParameterTurns::await_round(std::chrono::steady_clock::time_point until) {
  using Clock = std::chrono::steady_clock;
  constexpr std::chrono::milliseconds kLook(20);  // for Ctrl-C
  std::unique_lock lock(mutex_);
  while (reading_ && Clock::now() < until && !interrupt_flag().load())
    changed_.wait_until(lock, std::min(until, Clock::now() + kLook));
}

std::vector<WatchedParameter> ParameterTurns::of(unsigned slave) {
  const std::lock_guard lock(mutex_);
  for (const WatchedSlave& known : slaves_)
    if (known.slave == slave) return known.parameters;
  return {};
}

std::vector<std::string> ParameterTurns::take_problems() {
  const std::lock_guard lock(mutex_);
  return std::exchange(problems_, {});
}

void ParameterTurns::run() {
  while (true) {
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [this] { return reading_ || stop_; });
      if (stop_) return;
    }
    for (WatchedSlave& slave : slaves_) {
      for (WatchedParameter& parameter : slave.parameters) {
        if (stop_) return;
        if (parameter.asked && !read(slave, parameter)) break;
      }
    }
    const std::lock_guard lock(mutex_);
    reading_ = false;
    changed_.notify_all();
  }
}

bool ParameterTurns::read(WatchedSlave& slave, WatchedParameter& parameter) {
  client::ParameterRequest request;
  request.slave = slave.slave;
  request.number = parameter.number;
  request.timeout_ms = timeout_ms_;
  const client::ParameterReply reply = client_.submit(request).wait(stop_);
  const bool answered = reply.ok() || reply.code == client::ReplyCode::slave_error;
  const std::lock_guard lock(mutex_);
  if (!reply.ok() && (!parameter.last || parameter.last->code != reply.code) && !stop_)
    problems_.push_back(fmt::format("slave {}, {}: {}", slave.slave, heading_of(parameter), reply.reason));
  parameter.last = reply;
  if (reply.ok()) {
    parameter.value = reply;
    parameter.time = wall_clock();
  }
  return answered;
}

}  // namespace cansync::cli
