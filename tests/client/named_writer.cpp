// Writes parameters to slaves by name: lines "NAME NUMBER VALUE" of standard input, an answer a line: "done", or the reason.
// Usage: named_writer DOMAIN BUS        Exit code: 0 the input has ended, 1 failed
#include <cansync/client.h>

#include <cstdlib>
#include <exception>
#include <iostream>
#include <string>

int main(int argc, char** argv) try {
  using namespace cansync::client;
  if (argc != 3) return std::cerr << "usage: named_writer DOMAIN BUS\n", 1;
  Client client = Client::connect({.domain = static_cast<std::uint32_t>(std::atoi(argv[1])),
                                   .bus = argv[2],
                                   .client_name = "named writer",
                                   .wait = std::chrono::seconds(60)});
  std::string name;
  for (std::uint32_t number = 0, value = 0; std::cin >> name >> number >> value;) {
    constexpr std::uint32_t kTimeoutMs = 2000;
    std::string reason;
    try {
      const SlaveLookup found = client.find_slave(name);
      reason = found.slave ? describe(client.write(*found.slave, number, value, kTimeoutMs)) : found.problem;
    } catch (const NoDaemon& error) {
      reason = error.what();
    }
    std::cout << (reason.empty() ? "done" : reason) << std::endl;
  }
  return 0;
} catch (const std::exception& error) {
  std::cerr << error.what() << '\n';
  return 1;
}
