#include <string>
#include <string_view>

#include "config/print.h"
#include "daemon/j1939/config/options.h"

namespace cansyncd {
namespace {

constexpr std::string_view kJ1939MarkdownHead = R"(
# Configuration with bus.protocol = "j1939"

A node of SAE J1939 ([j1939.md](j1939.md)). The smallest file is `bus.protocol = "j1939"` alone: a simulated bus without other nodes, on
which the daemon only listens.

After SIGHUP the options marked "running" take effect at once.
)";

constexpr std::string_view kJ1939ConfigHead =
    R"(# Configuration of cansyncd for J1939 with every option. What is not commented out stands at its default;
# delete what you do not change. Printed by `cansyncd --print-default-config --set bus.protocol=j1939`.
)";

constexpr std::string_view kJ1939ManHead =
    ".Sh OPTIONS WITH BUS.PROTOCOL = J1939\n"
    "A node of SAE J1939.\n"
    "Those that do not say \"changes while running\" need a restart.\n";

}  // namespace

std::string j1939_options_markdown() {
  return config::options_markdown(j1939_options(), kJ1939MarkdownHead);
}

std::string j1939_options_man() {
  return config::options_man(j1939_options(), kJ1939ManHead);
}

std::string j1939_default_config() {
  return config::default_file(j1939_options(), kJ1939ConfigHead);
}

}  // namespace cansyncd
