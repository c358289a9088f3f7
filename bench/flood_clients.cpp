// One DDS client that does nothing but one thing, for what it costs the others (bench/load --floods).
//   flood_clients ROLE DOMAIN PARTITION SECONDS
// "connected" is printed when it has found the daemon; it begins with a line on standard input, works for
// SECONDS, and prints one JSON object: what was asked, how it was answered, how long that took.
#include <cansync/client.h>
#include <cansync/topics.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <exception>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "cansync/dds/topics.h"
#include "dds/daemon_identity.h"
#include "dds/endpoint.h"
#include "dds/participant.h"
#include "dds/reply_partition.h"
#include "dds/request_key.h"

namespace {

using namespace std::chrono_literals;
using cansync::client::Client;
using cansync::client::ReplyCode;
using std::chrono::steady_clock;

constexpr std::uint32_t kParameter = 301;  // a simulated drive's word
constexpr auto kConnect = 60s;             // to find the daemon, also on a loaded computer
constexpr auto kPause = 20ms;              // between two control words
constexpr auto kEnd = 60s;                 // by then every request of the library has ended, or never will

struct Settings {
  std::uint32_t domain = 0;
  std::string partition;
  std::chrono::duration<double> seconds{};
};

struct Found {
  std::uint64_t requests = 0;
  std::map<std::string, std::uint64_t, std::less<>> ends;  ///< how many ended how
  std::uint64_t open = 0;                                  ///< that never ended
  std::vector<double> took_ms;                             ///< of each that was waited for

  template <class Reply>
  void count(const Reply& reply) {
    // What the library refused by itself never left the program.
    const bool here = reply.code == ReplyCode::refused && reply.speaker == cansync::client::Speaker::client;
    ++ends[here ? "refused here" : std::string(cansync::client::name(reply.code))];
  }
};

double milliseconds_since(steady_clock::time_point begin) {
  return std::chrono::duration<double, std::milli>(steady_clock::now() - begin).count();
}

/// Control words, one after the other with a pause: each waits for its reply.
void command(Client& client, steady_clock::time_point end, Found& found) {
  while (steady_clock::now() < end) {
    const auto begin = steady_clock::now();
    const auto reply = client.control_word(1, 0).wait();
    found.took_ms.push_back(milliseconds_since(begin));
    ++found.requests;
    found.count(reply);
    std::this_thread::sleep_for(kPause);
  }
}

/// Reads without pause, some at a time on their way, of all slaves.
void read(Client& client, steady_clock::time_point end, Found& found) {
  constexpr std::size_t kOpen = 16;
  std::deque<std::pair<steady_clock::time_point, cansync::client::ParameterJob>> open;
  while (steady_clock::now() < end || !open.empty()) {
    while (open.size() < kOpen && steady_clock::now() < end) {
      const auto slave = static_cast<std::uint32_t>(found.requests++ % 4);
      open.emplace_back(steady_clock::now(), client.submit(cansync::client::ParameterRequest{
                                                 .slave = slave, .number = kParameter}));
    }
    if (open.empty()) return;
    const auto reply = open.front().second.wait();
    found.took_ms.push_back(milliseconds_since(open.front().first));
    found.count(reply);
    open.pop_front();
  }
}

/// New values of telegram 1 every 2 ms, each for one interval; counts those that the daemon tells as refused.
void give_references(Client& client, steady_clock::time_point end, Found& found) {
  std::atomic<std::uint64_t> refused = 0;
  const auto events = client.on_event([&](const cansync::client::Event& event) {
    const std::string_view text = cansync::client::text(event.text);
    if (cansync::client::text(event.code) != "reference_refusals_over") return;
    // "...; 12 were before, the first because of ..."
    const auto begin = text.find("; ");
    if (begin != std::string_view::npos) {
      refused += std::strtoull(std::string(text.substr(begin + 2)).c_str(), nullptr, 10);
    }
  });
  cansync::client::ReferenceWriter writer(client, 10);
  std::int32_t value = 0;
  for (auto due = steady_clock::now(); due < end; due += 2ms) {
    std::this_thread::sleep_until(due);
    ++found.requests;
    if (!writer.write(1, {++value, 0, 0, 0}, 1).empty()) ++found.ends["not written"];
  }
  std::this_thread::sleep_for(3s);  // a row of refusals is told when it is over
  found.ends["refused"] = refused;
}

/// Two threads that submit reads without ever waiting. Afterwards each of them must have ended.
void flood(Client& client, steady_clock::time_point end, Found& found) {
  struct Thread {
    std::vector<cansync::client::ParameterJob> jobs;
    std::uint64_t refused_here = 0;
    std::thread thread;
  };
  std::array<Thread, 2> threads;
  for (Thread& own : threads) {
    own.thread = std::thread([&own, &client, end] {
      for (std::uint32_t i = 0; steady_clock::now() < end; ++i) {
        const auto job = client.submit(
            cansync::client::ParameterRequest{.slave = i % 4, .number = kParameter, .timeout_ms = 1000});
        const auto reply = job.wait_for(0ms);
        if (reply && reply->speaker == cansync::client::Speaker::client) {
          ++own.refused_here;
        } else {
          own.jobs.push_back(job);
        }
      }
    });
  }
  for (Thread& own : threads) own.thread.join();
  const auto give_up = steady_clock::now() + kEnd;
  for (Thread& own : threads) {
    found.requests += own.jobs.size() + own.refused_here;
    found.ends["refused here"] += own.refused_here;
    for (const auto& job : own.jobs) {
      const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(give_up - steady_clock::now());
      const auto reply = job.wait_for(std::max(left, 0ms));
      if (reply) {
        found.count(*reply);
      } else {
        ++found.open;
      }
    }
  }
}

/// A program that keeps to no limit: writes samples as fast as DDS takes them, and takes its replies.
template <class Request, class Reply>
void flood_raw(const gateway::dds::Participant& participant, const std::function<void()>& start,
               const Settings& settings, const Request& pattern, Found& found) {
  gateway::dds::DataSignal signal;
  Request request = pattern;
  const auto process = static_cast<std::uint64_t>(getpid());
  for (std::size_t i = 0; i < 8; ++i) request.client[i] = static_cast<std::uint8_t>(process >> (8 * i));
  request.client[15] = 1;
  const std::string partition =
      gateway::dds::reply_partition(participant.options().partition, gateway::dds::key_of(request).client);
  gateway::dds::Reader<Reply> replies(participant, gateway::dds::Partitions{partition}, nullptr);
  gateway::dds::Writer<Request> writer(participant, 0, &signal);
  gateway::dds::Reader<gateway_GatewayStatus> statuses(participant, &signal);
  gateway::dds::DaemonIdentity daemon = {};
  const auto give_up = steady_clock::now() + kConnect;
  while ((writer.matched() == 0 || replies.matched() == 0 || daemon == gateway::dds::DaemonIdentity{}) &&
         steady_clock::now() < give_up) {
    (void)signal.wait(10);
    signal.clear();
    (void)statuses.take(
        [&](const gateway_GatewayStatus& status) { daemon = gateway::dds::daemon_of(status); });
  }
  start();
  const auto end = steady_clock::now() + std::chrono::duration_cast<steady_clock::duration>(settings.seconds);
  gateway::dds::set_daemon(daemon, request);
  std::uint64_t answered = 0;
  const auto take = [&] {
    (void)replies.take([&](const Reply& reply) {
      if (std::equal(std::begin(reply.client), std::end(reply.client), std::begin(request.client))) {
        ++answered;
      }
    });
  };
  while (steady_clock::now() < end) {
    ++request.request;
    if (writer.write(request) == DDS_RETCODE_OK) ++found.requests;
    if (request.request % 64 == 0) take();
  }
  for (int i = 0; i < 100; ++i) {
    std::this_thread::sleep_for(20ms);
    take();
  }
  found.ends["answered"] = answered;
  found.open = found.requests - std::min(found.requests, answered);
}

void print(const Found& found) {
  auto took = found.took_ms;
  std::sort(took.begin(), took.end());
  const auto part = [&](double of) {
    return took.empty() ? 0.0 : took[static_cast<std::size_t>(of * static_cast<double>(took.size() - 1))];
  };
  std::string ends;
  for (const auto& [name, count] : found.ends) {
    ends += fmt::format(R"({}"{}":{})", ends.empty() ? "" : ",", name, count);
  }
  fmt::print(
      R"({{"requests":{},"ends":{{{}}},"open":{},"median_ms":{:.3f},"p99_ms":{:.3f},"longest_ms":{:.3f}}})"
      "\n",
      found.requests, ends, found.open, part(0.5), part(0.99), part(1.0));
}

void wait_for_start() {
  fmt::print("connected\n");
  (void)std::fflush(stdout);
  for (int byte = 0; byte != EOF && byte != '\n';) byte = std::getchar();
}

int run(std::string_view role, const Settings& settings) {
  Found found;
  if (role == "raw-parameters" || role == "raw-commands") {
    const gateway::dds::Participant participant({.domain = settings.domain,
                                                 .partition = settings.partition,
                                                 .interface = "lo",
                                                 .xml = {},
                                                 .security = {}});
    if (role == "raw-parameters") {
      cansync_ParameterRequest request = {};
      request.slave = 1;
      request.number = kParameter;
      request.element = 7;
      request.format = cansync_FORMAT_AS_SLAVE_SAYS;
      flood_raw<cansync_ParameterRequest, cansync_ParameterReply>(participant, wait_for_start, settings,
                                                                  request, found);
    } else {
      cansync_Command request = {};
      request.kind = cansync_COMMAND_CONTROL_WORD;
      request.slave = 2;
      flood_raw<cansync_Command, cansync_CommandReply>(participant, wait_for_start, settings, request, found);
    }
    print(found);
    return 0;
  }
  cansync::client::Options options;
  options.domain = settings.domain;
  options.bus = settings.partition;
  options.client_name = std::string(role);
  options.wait = kConnect;
  auto client = Client::connect(options);
  // The daemon has a writer for who has asked.
  if (role == "slow" || role == "idle") (void)client.read(0, kParameter);
  wait_for_start();
  const auto end = steady_clock::now() + std::chrono::duration_cast<steady_clock::duration>(settings.seconds);
  if (role == "command") {
    command(client, end, found);
  } else if (role == "read") {
    read(client, end, found);
  } else if (role == "flood") {
    flood(client, end, found);
  } else if (role == "references") {
    give_references(client, end, found);
  } else if (role == "slow") {
    // Its receiver thread stands in a callback: it takes nothing any more.
    const auto slow =
        client.on_actual_values([&](const auto& /*values*/) { std::this_thread::sleep_until(end); });
    std::this_thread::sleep_until(end);
  } else if (role == "idle") {
    std::this_thread::sleep_until(end);
  } else {
    return std::fprintf(stderr, "flood_clients: no role %s\n", std::string(role).c_str()), 2;
  }
  print(found);
  return 0;
}

}  // namespace

int main(int argc, char** argv) try {
  const std::span arguments(argv, static_cast<std::size_t>(argc));
  if (argc != 5) {
    return std::fprintf(stderr,
                        "usage: flood_clients "
                        "command|read|flood|references|raw-parameters|raw-commands|slow|idle DOMAIN "
                        "PARTITION SECONDS\n"),
           2;
  }
  return run(arguments[1], {static_cast<std::uint32_t>(std::strtoul(arguments[2], nullptr, 10)), arguments[3],
                            std::chrono::duration<double>(std::strtod(arguments[4], nullptr))});
} catch (const std::exception& error) {
  return std::fprintf(stderr, "flood_clients: %s\n", error.what()), 1;
}
