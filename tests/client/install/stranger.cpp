#include <cansync/client.h>

#include <cstdio>
#include <cstdlib>
#include <string_view>

/// Uses what is installed: a class, an exception over the library's border, a setting. No header of the data
/// model.
int main(int argc, char** argv) {
  using namespace cansync::client;
  if (argc != 2) return 2;
  if (name(ReplyCode::slave_error) != std::string_view("slave_error")) return 3;

  Options options;
  options.domain = static_cast<std::uint32_t>(std::atoi(argv[1]));
  options.bus = "nobody";
  options.wait = std::chrono::milliseconds(1);
  try {
    Client client = Client::connect(options);
    return client.mode(Mode::run).wait().ok() ? 4 : 6;
  } catch (const NoDaemon& error) {
    std::printf("NoDaemon: %s\n", error.what());
  }
  options.domain = 1000;
  try {
    const Client client = Client::connect(options);
    return 5;
  } catch (const SetupError& error) {
    std::printf("SetupError: %s\n", error.what());
  }
  return 0;
}
