#include <cansync/client.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

/// Requests of tests/client/refusals.json through the C++ face, one after the other: prints code, cause and
/// whether to ask again, a line for each. Usage: provoke DOMAIN BUS CALL NUMBER... [-- CALL NUMBER...]...
namespace {

using namespace cansync::client;  // NOLINT(google-build-using-namespace): the program is about it

std::uint32_t number(const std::vector<std::string>& words, std::size_t index) {
  return static_cast<std::uint32_t>(std::strtoul(words.at(index).c_str(), nullptr, 0));
}

Reply write(Client& client, const std::vector<std::string>& words) {
  ParameterRequest request{.write = true, .slave = number(words, 1), .number = number(words, 2)};
  request.value = number(words, 3);
  if (words.at(4) == "word") request.format = ParameterFormat::word;
  request.element = number(words, 5);
  return client.submit(request).wait();
}

Reply upload(Client& client, const std::vector<std::string>& words) {
  TransferRequest request{.slave = number(words, 1), .address = number(words, 2), .length = number(words, 3)};
  if (words.size() > 4) request.block_size = number(words, 4);
  return client.submit(request).wait();
}

Reply ask(Client& client, const std::vector<std::string>& words) {
  const std::string& call = words.front();
  if (call == "read") return client.read(number(words, 1), number(words, 2));
  if (call == "write") return write(client, words);
  if (call == "upload") return upload(client, words);
  if (call == "control_word") return client.control_word(number(words, 1), number(words, 2)).wait();
  if (call == "release") return client.release(number(words, 1), false).wait();
  if (call == "mode") return client.mode(words.at(1) == "run" ? Mode::run : Mode::stop).wait();
  if (call == "broadcast") {
    return client
        .broadcast({.priority = number(words, 1),
                    .slave_mask = number(words, 2),
                    .action = number(words, 3),
                    .data_byte = number(words, 4),
                    .data_word = number(words, 5)})
        .wait();
  }
  MappingBytes bytes = {};
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::uint8_t>(number(words, i + 1));
  return client.map_references(bytes).wait();
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const std::vector<std::string> all(argv + 3, argv + argc);
    Client client = Client::connect(
        {.domain = static_cast<std::uint32_t>(std::strtoul(argv[1], nullptr, 10)), .bus = argv[2]});
    for (auto begin = all.begin(); begin < all.end();) {
      const auto end = std::find(begin, all.end(), "--");
      const Reply reply = ask(client, {begin, end});
      std::printf("%s %s %s\n", name(reply.code).data(), name(reply.cause).data(),
                  name(reply.retry()).data());
      begin = end == all.end() ? end : end + 1;
    }
    return 0;
  } catch (const std::exception& error) {
    std::printf("%s\n", error.what());
    return 1;
  }
}
