// A DDS client that does one job after the other as it is told, for tests that kill it or the daemon
// meanwhile:
//   job_client DOMAIN PARTITION
// Prints "ready" when it has found the daemon. Then one job a line on standard input, and its end a line on
// standard output: "done" with what was read, or the reply's code and reason.
//   read SLAVE NUMBER | write SLAVE NUMBER VALUE | upload SLAVE ADDRESS LENGTH | download SLAVE ADDRESS HEX
//   status: option status, synchronized slaves, open parameter jobs, open transfers
#include <cansync/client.h>
#include <cansync/topics.h>
#include <fmt/format.h>

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

using cansync::client::Reply;

constexpr std::uint32_t kBlock = 150;  // bytes per initialise: several blocks in a short transfer
constexpr auto kConnect = std::chrono::seconds(60);

std::vector<std::uint8_t> bytes_of(const std::string& hex) {
  std::vector<std::uint8_t> bytes;
  for (std::size_t i = 0; i + 1 < hex.size(); i += 2) {
    bytes.push_back(static_cast<std::uint8_t>(std::stoul(hex.substr(i, 2), nullptr, 16)));
  }
  return bytes;
}

std::string hex_of(const std::vector<std::uint8_t>& bytes) {
  std::string hex;
  for (const std::uint8_t byte : bytes) hex += fmt::format("{:02x}", byte);
  return hex;
}

std::string told(const Reply& reply, const std::string& result) {
  if (reply.ok()) return "done " + result;
  return fmt::format("{} {}", cansync::client::name(reply.code), reply.reason);
}

std::string do_job(cansync::client::Client& client, const std::string& line) {
  std::istringstream words(line);
  std::string verb;
  std::uint32_t slave = 0;
  std::uint32_t where = 0;
  std::string what;
  words >> verb >> slave >> where >> what;
  if (verb == "read") {
    const auto reply = client.read(slave, where);
    return told(reply, std::to_string(reply.value));
  }
  if (verb == "write") {
    return told(client.write(slave, where, static_cast<std::uint32_t>(std::stoul(what))), "");
  }
  if (verb == "upload" || verb == "download") {
    cansync::client::TransferRequest request;
    request.download = verb == "download";
    request.slave = slave;
    request.address = where;
    request.block_size = kBlock;
    if (request.download) {
      request.data = bytes_of(what);
    } else {
      request.length = static_cast<std::uint32_t>(std::stoul(what));
    }
    const auto reply = client.submit(request).wait();
    return told(reply, hex_of(reply.data));
  }
  if (verb == "status") {
    if (!client.daemon_present()) return "no_reply";
    const auto status = client.master_status();
    return fmt::format("done {} {} {} {}", status.option_status, status.slaves_synchronized,
                       status.open_parameter_jobs, status.open_transfers);
  }
  throw std::runtime_error("'" + line + "' is no job");
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 3) return std::fprintf(stderr, "usage: %s DOMAIN PARTITION\n", argv[0]), 2;
  cansync::client::Options options;
  options.domain = static_cast<std::uint32_t>(std::strtoul(argv[1], nullptr, 10));
  options.bus = argv[2];
  options.client_name = "job_client";
  options.wait = kConnect;
  auto client = cansync::client::Client::connect(options);
  std::cout << "ready" << std::endl;
  std::string line;
  while (std::getline(std::cin, line)) std::cout << do_job(client, line) << std::endl;
  return 0;
} catch (const std::exception& error) {
  return std::fprintf(stderr, "job_client: %s\n", error.what()), 1;
}
