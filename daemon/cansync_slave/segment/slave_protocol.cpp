#include "daemon/cansync_slave/segment/slave_protocol.h"

#include <fmt/format.h>

#include <memory>
#include <span>
#include <utility>

#include "daemon/cansync_slave/config/file.h"
#include "daemon/cansync_slave/config/options.h"
#include "daemon/cansync_slave/segment/slave_segment.h"

namespace cansyncd {
namespace {

LoadedConfig load_slave(const std::string& path, std::span<const std::string> overrides) {
  const auto file = std::make_shared<SlaveRoleFile>(load_slave_checked(path, overrides));
  LoadedConfig loaded;
  loaded.problems = file->problems;
  loaded.daemon = file->config;
  if (!loaded.problems.empty()) return loaded;
  loaded.check_text = fmt::format("slave {} at {} bit/s\n", file->config.slave.number.value(),
                                  file->config.bus.bits_per_second);
  loaded.make_segment = [file](JournalSink& journal, std::span<gateway::dds::Participant> participants) {
    return std::make_unique<SlaveSegment>(std::move(*file), journal, std::move(participants.front()));
  };
  return loaded;
}

}  // namespace

const ProtocolInfo cansync_slave_protocol = {kSlaveProtocol,       slave_options,          load_slave,
                                             slave_default_config, slave_options_markdown, slave_options_man};

}  // namespace cansyncd
