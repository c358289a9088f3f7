#include "j1939/config/options.h"

namespace cansyncd {

const config::DocumentHeads j1939_document_heads = {
    .markdown = R"(
# Configuration with bus.protocol = "j1939"

A node of SAE J1939 ([j1939.md](j1939.md)). The smallest file is `bus.protocol = "j1939"` alone: a simulated bus without other nodes, on
which the daemon only listens.

After SIGHUP the options marked "running" take effect at once.
)",
    .file =
        R"(# Configuration of cansyncd for J1939 with every option. What is not commented out stands at its default;
# delete what you do not change. Printed by `cansyncd --print-default-config --set bus.protocol=j1939`.
)",
    .man =
        ".Sh OPTIONS WITH BUS.PROTOCOL = J1939\n"
        "A node of SAE J1939.\n"
        "Those that do not say \"changes while running\" need a restart.\n"};

}  // namespace cansyncd
