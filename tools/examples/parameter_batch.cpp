// Reads and writes many parameters of one slave at once: every job is handed over before the first answer is
// awaited, and the daemon works through them.
// Usage: parameter_batch DOMAIN BUS SLAVE NUMBER|NUMBER=VALUE...
// Exit code: 0 all done, 1 one failed or there is no daemon, 2 wrong usage
#include <cansync/client.h>

#include <cstdio>
#include <cstdlib>
#include <exception>
#include <optional>
#include <string>
#include <vector>

namespace {

using namespace cansync::client;

/// "1000" reads, "1000=7" writes; nothing for anything else.
std::optional<ParameterRequest> request_of(const char* text, std::uint32_t slave) {
  char* end = nullptr;
  ParameterRequest request;
  request.slave = slave;
  request.number = static_cast<std::uint32_t>(std::strtoul(text, &end, 0));
  if (end == text) return std::nullopt;
  if (*end == '\0') return request;
  if (*end != '=') return std::nullopt;
  const char* value = end + 1;
  request.write = true;
  request.value = static_cast<std::uint32_t>(std::strtoul(value, &end, 0));
  if (end == value || *end != '\0') return std::nullopt;
  return request;
}

int run(Client& client, const std::vector<ParameterRequest>& requests) {
  std::vector<ParameterJob> jobs;
  jobs.reserve(requests.size());
  for (const ParameterRequest& request : requests) jobs.push_back(client.submit(request));
  int failed = 0;
  for (std::size_t i = 0; i < jobs.size(); ++i) {
    const ParameterReply reply = jobs[i].wait();
    if (reply.ok()) {
      std::printf("%u %s %u\n", requests[i].number, requests[i].write ? "<-" : "=", reply.value);
    } else {
      std::printf("%u failed: %s\n", requests[i].number, describe(reply).c_str());
      failed = 1;
    }
  }
  return failed;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 5)
    return std::fprintf(stderr, "usage: %s DOMAIN BUS SLAVE NUMBER|NUMBER=VALUE...\n", argv[0]), 2;
  try {
    Options options;
    options.domain = static_cast<std::uint32_t>(std::atoi(argv[1]));
    options.bus = argv[2];
    options.client_name = "parameter batch";
    std::vector<ParameterRequest> requests;
    for (int i = 4; i < argc; ++i) {
      const auto request = request_of(argv[i], static_cast<std::uint32_t>(std::atoi(argv[3])));
      if (!request) return std::fprintf(stderr, "%s: neither NUMBER nor NUMBER=VALUE\n", argv[i]), 2;
      requests.push_back(*request);
    }
    Client client = Client::connect(options);
    return run(client, requests);
  } catch (const std::exception& error) {
    return std::fprintf(stderr, "%s\n", error.what()), 1;
  }
}
