#include "layer2/config/options.h"

namespace cansyncd {

const config::DocumentHeads layer2_document_heads = {
    .markdown = R"(
# Configuration with bus.protocol = "layer2"

General CAN frames, which nobody interprets ([layer2.md](layer2.md)). The smallest file is `bus.protocol = "layer2"` alone: a
simulated bus without other nodes, from which every frame is received.

After SIGHUP the options marked "running" take effect at once.
)",
    .file =
        R"(# Configuration of cansyncd for general CAN frames with every option. What is not commented out stands at its default;
# delete what you do not change. Printed by `cansyncd --print-default-config --set bus.protocol=layer2`.
)",
    .man =
        ".Sh OPTIONS WITH BUS.PROTOCOL = LAYER2\n"
        "General CAN frames.\n"
        "Those that do not say \"changes while running\" need a restart.\n"};

}  // namespace cansyncd
