#include "cli/layer2/configure_verb.h"

#include <fmt/format.h>

#include <cstdint>
#include <memory>
#include <string>

#include "cli/base/files.h"
#include "cli/connect/bus_verb.h"
#include "cli/connect/gateway_reply.h"
#include "cli/text/values.h"
#include "layer2/client/frame_client.h"

namespace cansync::cli {
namespace {

ExitCode configure_verb(Session& session, const std::string& file) {
  constexpr std::size_t kMost = 131'072;
  session.expect_input(file);
  const auto bytes = read_file(file, kMost);
  const std::string text(bytes.begin(), bytes.end());
  layer2::client::FrameClient client = connect_bus<layer2::client::FrameClient>(session);
  const layer2::client::SendResult result = client.configure(text);
  JsonObject object;
  object.add("file", file).add("bytes", static_cast<std::uint64_t>(text.size()));
  return session.finish(reply_of(result), object, file,
                        fmt::format("{}: in force until the daemon is restarted", file));
}

}  // namespace

void add_configure_verb(CLI::App& can, Verb& chosen) {
  auto* configure = can.add_subcommand("configure", "change the configuration of the daemon that runs");
  auto file = std::make_shared<std::string>();
  configure->add_option("FILE", *file, "sections of a configuration file; -: standard input")->required();
  configure->footer(
      "Of a bus with bus.protocol = \"layer2\". Sections that it names take the place of those in force: send, receive "
      "with\nfilter, queue, timer, object, window, script, mapping with mapped; all of them or nothing.");
  run_when_named(*configure, chosen, file, configure_verb);
}

}  // namespace cansync::cli
