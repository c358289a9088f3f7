// Many DDS clients at once, each a process with a participant of its own.
//   load_clients DOMAIN PARTITION READERS REQUESTERS OPEN SLAVES SECONDS
// READERS take actual values and status; REQUESTERS keep OPEN parameter reads and writes each on their way,
// on the slaves 0..SLAVES-1, shared out among them. "connected" is printed when every client has found the
// daemon; a line on standard input then starts all of them. At the end one JSON object is printed: what was
// asked, how it was answered, and what never was. Exit code 0 when every request was answered and every value
// was right.
#include <cansync/client.h>
#include <cansync/topics.h>
#include <fmt/format.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <exception>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

using namespace std::chrono_literals;
using cansync::client::RefusalCause;
using cansync::client::ReplyCode;
using std::chrono::steady_clock;

constexpr std::uint32_t kParameter = 430;  // a simulated drive's doubleword without limits
constexpr char kReady = 'r';               // a client has connected
constexpr char kFailed = 'f';              // it could not
constexpr unsigned kAtOnce = 5;            // clients that look for the daemon at the same time
constexpr auto kConnect = 60s;             // to find the daemon, also on a loaded computer
constexpr auto kAnswer = 30s;              // a request without an answer for so long counts as lost

struct Settings {
  std::uint32_t domain = 0;
  std::string partition;
  unsigned readers = 0;
  unsigned requesters = 0;
  unsigned open = 0;
  unsigned slaves = 0;
  double seconds = 0;
};

/// What one client counted; sums are what all did. Goes through a pipe as it is.
struct Counts {
  std::uint64_t clients = 0;  ///< that ran to their end
  std::uint64_t values = 0;   ///< samples of actual values
  std::uint64_t status = 0;   ///< samples of the master's and the slaves' status
  std::uint64_t blind = 0;    ///< readers that got no actual value at all
  std::uint64_t requests = 0;
  std::uint64_t done = 0;
  std::uint64_t queue_full = 0;    ///< refused because a queue was full
  std::uint64_t refused = 0;       ///< refused for another reason
  std::uint64_t failed = 0;        ///< answered, but neither done nor refused
  std::uint64_t no_reply = 0;      ///< the client had to give up: the daemon was gone
  std::uint64_t unanswered = 0;    ///< nothing within kAnswer
  std::uint64_t wrong_values = 0;  ///< read something that nobody can have written
  std::uint64_t longest_us = 0;    ///< from request to reply; of all clients the longest

  void add(const Counts& other) {
    clients += other.clients;
    values += other.values;
    status += other.status;
    blind += other.blind;
    requests += other.requests;
    done += other.done;
    queue_full += other.queue_full;
    refused += other.refused;
    failed += other.failed;
    no_reply += other.no_reply;
    unanswered += other.unanswered;
    wrong_values += other.wrong_values;
    longest_us = std::max(longest_us, other.longest_us);
  }
};

/// Reads and writes in turn on one client's own slaves. Each write puts a higher number into the parameter,
/// so a read must give one between the last that was confirmed when it was sent and the last that was sent.
class Requester {
 public:
  Requester(const Settings& settings, unsigned own, cansync::client::Client& client)
      : settings_(settings), client_(client) {
    for (unsigned slave = own; slave < settings.slaves; slave += settings.requesters) {
      slaves_.push_back({.number = slave});
    }
  }

  void run(Counts& counts) {
    const auto end = steady_clock::now() + std::chrono::duration<double>(settings_.seconds);
    while (steady_clock::now() < end) {
      while (open_.size() < settings_.open) submit(counts);
      take_oldest(counts);
    }
    while (!open_.empty()) take_oldest(counts);
  }

 private:
  struct Slave {
    unsigned number = 0;
    std::uint32_t sent = 0;       ///< highest value sent
    std::uint32_t confirmed = 0;  ///< highest value confirmed; 0: none
    bool write_next = true;
  };
  struct Open {
    cansync::client::ParameterJob job;
    std::size_t slave = 0;
    bool write = false;
    std::uint32_t value = 0;  ///< write: what is written; read: the least that may come
    steady_clock::time_point since;
  };

  void submit(Counts& counts) {
    const std::size_t index = next_++ % slaves_.size();
    Slave& slave = slaves_[index];
    cansync::client::ParameterRequest request;
    request.write = slave.write_next;
    request.slave = slave.number;
    request.number = kParameter;
    request.value = request.write ? ++slave.sent : 0;
    request.format = cansync::client::ParameterFormat::doubleword;
    slave.write_next = !slave.write_next;
    const std::uint32_t value = request.write ? request.value : slave.confirmed;
    open_.push_back({client_.submit(request), index, request.write, value, steady_clock::now()});
    ++counts.requests;
  }

  void take_oldest(Counts& counts) {
    const Open oldest = open_.front();
    open_.pop_front();
    const auto reply = oldest.job.wait_for(kAnswer);
    if (!reply) {
      ++counts.unanswered;
      return;
    }
    const auto took =
        std::chrono::duration_cast<std::chrono::microseconds>(steady_clock::now() - oldest.since);
    counts.longest_us = std::max(counts.longest_us, static_cast<std::uint64_t>(took.count()));
    if (reply->code == ReplyCode::done) {
      ++counts.done;
      check(oldest, reply->value, counts);
    } else if (reply->code == ReplyCode::refused) {
      const bool full =
          reply->cause == RefusalCause::queue_full || reply->cause == RefusalCause::client_limit;
      ++(full ? counts.queue_full : counts.refused);
    } else if (reply->code == ReplyCode::no_reply || reply->code == ReplyCode::no_daemon) {
      ++counts.no_reply;
    } else {
      ++counts.failed;
    }
  }

  void check(const Open& job, std::uint32_t value, Counts& counts) {
    Slave& slave = slaves_[job.slave];
    if (job.write) {
      slave.confirmed = std::max(slave.confirmed, job.value);
    } else if (job.value != 0 && (value < job.value || value > slave.sent)) {
      ++counts.wrong_values;
    }
  }

  const Settings& settings_;
  cansync::client::Client& client_;
  std::vector<Slave> slaves_;
  std::deque<Open> open_;
  std::size_t next_ = 0;
};

void read(const Settings& settings, cansync::client::Client& client, Counts& counts) {
  std::atomic<std::uint64_t> values = 0;
  std::atomic<std::uint64_t> status = 0;
  {
    const auto actual = client.on_actual_values([&](const auto&) { ++values; });
    const auto slaves = client.on_slave_status([&](const auto&) { ++status; });
    const auto master = client.on_master_status([&](const auto&) { ++status; });
    usleep(static_cast<useconds_t>(settings.seconds * 1e6));
  }
  counts.values = values;
  counts.status = status;
  counts.blind = values == 0 ? 1 : 0;
}

/// One client's process, from its start to its end. `own`: its number among all; readers come first.
int be_client(const Settings& settings, unsigned own, int ready, int start, int result) try {
  cansync::client::Options options;
  options.domain = settings.domain;
  options.bus = settings.partition;
  options.client_name = fmt::format("load {}", own);
  options.wait = kConnect;
  auto client = cansync::client::Client::connect(options);
  if (::write(ready, &kReady, 1) != 1) return 1;
  char byte = 0;
  // Nothing is ever written there: it ends when the first process closes it.
  if (::read(start, &byte, 1) != 0) return 1;
  Counts counts;
  if (own < settings.readers) {
    read(settings, client, counts);
  } else {
    Requester(settings, own - settings.readers, client).run(counts);
  }
  counts.clients = 1;
  return ::write(result, &counts, sizeof counts) == sizeof counts ? 0 : 1;
} catch (const std::exception& error) {
  std::fprintf(stderr, "client %u: %s\n", own, error.what());
  return static_cast<int>(::write(ready, &kFailed, 1));
}

struct Pipe {
  int end[2] = {-1, -1};
  Pipe() {
    if (pipe(end) != 0) throw std::runtime_error("no pipe can be had");
  }
  int read_end() const { return end[0]; }
  int write_end() const { return end[1]; }
  void close_write() const { close(end[1]); }
};

void print(const Settings& settings, const Counts& all, double connecting) {
  fmt::print(
      R"({{"readers":{},"requesters":{},"connected_after_s":{:.2f},"clients":{},"values":{},"status":{},"blind":{},)"
      R"("requests":{},"done":{},"queue_full":{},"refused":{},"failed":{},"no_reply":{},"unanswered":{},)"
      R"("wrong_values":{},"longest_ms":{:.1f}}})"
      "\n",
      settings.readers, settings.requesters, connecting, all.clients, all.values, all.status, all.blind,
      all.requests, all.done, all.queue_full, all.refused, all.failed, all.no_reply, all.unanswered,
      all.wrong_values, static_cast<double>(all.longest_us) / 1000);
}

int run(const Settings& settings) {
  const Pipe ready;
  const Pipe start;
  const Pipe result;
  const unsigned clients = settings.readers + settings.requesters;
  const auto begin = steady_clock::now();
  // Each process begins before it has touched DDS: nothing of one client is shared with another. A few at a
  // time: participants that all start at once and find each other are another load than the one meant here.
  char byte = 0;
  unsigned connected = 0;
  const auto one_more = [&] {
    if (::read(ready.read_end(), &byte, 1) != 1 || byte != kReady) {
      throw std::runtime_error("a client could not connect");
    }
    ++connected;
  };
  for (unsigned own = 0; own < clients; ++own) {
    if (own - connected >= kAtOnce) one_more();
    const pid_t child = fork();
    if (child < 0) throw std::runtime_error("no process can be had");
    if (child > 0) continue;
    (void)prctl(PR_SET_PDEATHSIG, SIGKILL);
    start.close_write();
    _exit(be_client(settings, own, ready.write_end(), start.read_end(), result.write_end()));
  }
  ready.close_write();
  result.close_write();
  while (connected < clients) one_more();
  const double connecting = std::chrono::duration<double>(steady_clock::now() - begin).count();
  fmt::print("connected\n");
  (void)std::fflush(stdout);
  while (::read(STDIN_FILENO, &byte, 1) == 1 && byte != '\n') {
  }
  start.close_write();
  Counts all;
  Counts one;
  while (::read(result.read_end(), &one, sizeof one) == static_cast<ssize_t>(sizeof one)) all.add(one);
  while (wait(nullptr) > 0) {
  }
  print(settings, all, connecting);
  const std::uint64_t answered = all.done + all.queue_full + all.refused + all.failed;
  return all.clients == clients && answered == all.requests && all.wrong_values == 0 ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) try {
  const std::span arguments(argv, static_cast<std::size_t>(argc));
  if (argc != 8) {
    return std::fprintf(stderr,
                        "usage: load_clients DOMAIN PARTITION READERS REQUESTERS OPEN SLAVES SECONDS (OPEN "
                        "and SLAVES at least 1, SLAVES at least REQUESTERS)\n"),
           2;
  }
  const auto number = [&](std::size_t i) {
    return static_cast<unsigned>(std::strtoul(arguments[i], nullptr, 10));
  };
  const Settings settings{number(1),
                          arguments[2],
                          number(3),
                          number(4),
                          number(5),
                          number(6),
                          std::strtod(arguments[7], nullptr)};
  if (settings.open == 0 || settings.slaves == 0 || settings.slaves < settings.requesters) {
    return std::fprintf(stderr, "load_clients: OPEN and SLAVES are at least 1, SLAVES at least REQUESTERS\n"),
           2;
  }
  return run(settings);
} catch (const std::exception& error) {
  return std::fprintf(stderr, "load_clients: %s\n", error.what()), 1;
}
