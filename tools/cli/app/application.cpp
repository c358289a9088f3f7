#include "cli/app/application.h"

#include "cli/app/command_line.h"
#include "cli/base/endings.h"
#include "cli/base/interrupt.h"
#include "cli/base/left_out.h"
#include "cli/base/session.h"
#include "text/completion.h"

namespace cansync::cli {

ExitCode run(int argc, const char* const* argv, std::FILE* data, std::FILE* remarks) {
  Output output(data, remarks, false);
  Globals globals;
  try {
    if (const auto words = text::words_to_complete(argc, argv); !words.empty()) {
      output.bytes(complete_command(words));
      return ExitCode::done;
    }
    const Command command = parse_command({argv + (argc > 0 ? 1 : 0), argv + argc});
    globals = command.globals;
    Output typed(data, remarks, command.globals.json);
    typed.set_colours(command.globals.colours);
    typed.set_wide(command.globals.wide);
    Connection connection;
    Session session(command.globals, typed, connection);
    return end_of_verb(command.verb(session));
  } catch (const client::OtherProtocol& error) {
    output.remark(other_protocol_text(globals, error));
    return code_of(error);
  } catch (const client::NoDaemon& error) {
    // What Ctrl-C ended tells nothing of the daemon.
    const bool interrupted = interrupt_flag().load();
    output.remark(interrupted ? Interrupted().what() : error.what());
    return interrupted ? ExitCode::cancelled : code_of(error);
  } catch (const std::exception& error) {
    output.remark(error.what());
    return code_of(error);
  }
}

}  // namespace cansync::cli
