// Event scripts (lib/layer2/script.h), and what is accepted of them on a module.
#include <chrono>

#include "bytes.h"
#include "layer2/module.h"
#include "require.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using fuzz::require;
  const std::uint8_t choice = size == 0 ? 0 : data[0];
  const layer2::ScriptRules rules{(choice & 1) != 0, static_cast<layer2::ScriptNumbers>(choice / 2 % 3)};
  const std::string text = size == 0 ? std::string() : std::string(fuzz::text_of(data + 1, size - 1));
  const layer2::Script script = layer2::parse_script(text, rules);
  require(script.commands.size() <= layer2::Script::kMostLines, "a script is bounded");
  for (const layer2::ScriptProblem& problem : script.problems) {
    require(problem.line > 0 && problem.column > 0 && !problem.text.empty(),
            "a problem has a place and words");
  }
  if (!script.problems.empty()) return 0;
  layer2::ModuleSettings settings;
  settings.timers[0] = layer2::TimerSettings{};
  settings.run = script;
  layer2::Module module(settings);
  layer2::Time now{0};
  module.begin(now);
  std::size_t sent = 0;
  for (unsigned turn = 0; turn < 500 && module.script_runs(); ++turn) {
    module.advance(now);
    for (unsigned i = 0; i < 8; ++i) {
      const auto frame = module.next_frame();
      if (!frame) break;
      require(frame->dlc <= 8 && frame->id <= can::kExtendedIdentifierMask, "what is sent is a frame");
      module.handed_over();
      module.echo(*frame, now);
      ++sent;
    }
    const layer2::Time next = module.next_deadline();
    require(next > now, "time goes on");
    now = next == layer2::Time::max() ? now + std::chrono::milliseconds(1) : next;
  }
  require(sent <= 500 * 8, "a script ends");
  return 0;
}
