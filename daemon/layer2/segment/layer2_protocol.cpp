#include "daemon/layer2/segment/layer2_protocol.h"

#include <fmt/format.h>

#include <memory>
#include <span>
#include <utility>

#include "daemon/layer2/config/file.h"
#include "daemon/layer2/config/options.h"
#include "daemon/layer2/segment/layer2_segment.h"
#include "text/counts.h"

namespace cansyncd {
namespace {

LoadedConfig load(const std::string& path, std::span<const std::string> overrides) {
  const auto file = std::make_shared<Layer2File>(load_layer2_checked(path, overrides));
  LoadedConfig loaded;
  loaded.problems = file->problems;
  loaded.daemon = file->config;
  if (!loaded.problems.empty()) return loaded;
  loaded.check_text =
      fmt::format("general frames at {} bit/s, {} received\n", file->config.bus.bits_per_second,
                  text::counted(file->config.receive.size(), "range"));
  loaded.make_segment = [file](JournalSink& journal, std::span<gateway::dds::Participant> participants) {
    return std::make_unique<Layer2Segment>(std::move(*file), journal, std::move(participants.front()));
  };
  return loaded;
}

}  // namespace

const ProtocolInfo layer2_protocol = {kLayer2Protocol,       layer2_options,          load,
                                      layer2_default_config, layer2_options_markdown, layer2_options_man};

}  // namespace cansyncd
