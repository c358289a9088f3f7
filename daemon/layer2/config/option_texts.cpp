#include <string>
#include <string_view>

#include "config/print.h"
#include "daemon/layer2/config/options.h"

namespace cansyncd {
namespace {

constexpr std::string_view kLayer2MarkdownHead = R"(
# Configuration with bus.protocol = "layer2"

General CAN frames, which nobody interprets ([layer2.md](layer2.md)). The smallest file is `bus.protocol = "layer2"` alone: a
simulated bus without other nodes, from which every frame is received.

After SIGHUP the options marked "running" take effect at once.
)";

constexpr std::string_view kLayer2ConfigHead =
    R"(# Configuration of cansyncd for general CAN frames with every option. What is not commented out stands at its default;
# delete what you do not change. Printed by `cansyncd --print-default-config --set bus.protocol=layer2`.
)";

constexpr std::string_view kLayer2ManHead =
    ".Sh OPTIONS WITH BUS.PROTOCOL = LAYER2\n"
    "General CAN frames.\n"
    "Those that do not say \"changes while running\" need a restart.\n";

}  // namespace

std::string layer2_options_markdown() {
  return config::options_markdown(layer2_options(), kLayer2MarkdownHead);
}

std::string layer2_options_man() {
  return config::options_man(layer2_options(), kLayer2ManHead);
}

std::string layer2_default_config() {
  return config::default_file(layer2_options(), kLayer2ConfigHead);
}

}  // namespace cansyncd
