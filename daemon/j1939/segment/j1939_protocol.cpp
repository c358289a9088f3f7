#include "daemon/j1939/segment/j1939_protocol.h"

#include <fmt/format.h>

#include <memory>
#include <span>
#include <utility>

#include "daemon/j1939/config/file.h"
#include "daemon/j1939/config/options.h"
#include "daemon/j1939/segment/j1939_segment.h"
#include "text/counts.h"

namespace cansyncd {
namespace {

LoadedConfig load_j1939(const std::string& path, std::span<const std::string> overrides) {
  const auto file = std::make_shared<J1939File>(load_j1939_checked(path, overrides));
  LoadedConfig loaded;
  loaded.problems = file->problems;
  loaded.daemon = file->config;
  if (!loaded.problems.empty()) return loaded;
  loaded.check_text =
      fmt::format("J1939 at {} bit/s, {}, {} received\n", file->config.bus.bits_per_second,
                  address_text(file->config), text::counted(file->config.receive.size(), "range"));
  loaded.make_segment = [file](JournalSink& journal, std::span<gateway::dds::Participant> participants) {
    return std::make_unique<J1939Segment>(std::move(*file), journal, std::move(participants.front()));
  };
  return loaded;
}

}  // namespace

const ProtocolInfo j1939_protocol = {kJ1939Protocol,       j1939_options,          load_j1939,
                                     j1939_default_config, j1939_options_markdown, j1939_options_man};

}  // namespace cansyncd
