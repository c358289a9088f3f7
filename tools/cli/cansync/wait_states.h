#pragma once

#include <cansync/topics.h>
#include <cansync/types.h>

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

/// What `cansync wait` can wait for. Pure.
namespace cansync::cli {

struct WaitState {
  /// Whose state it is; `nobody`: that no daemon is there.
  enum class Of : unsigned char { daemon, nobody, master, controller, slaves };
  std::string_view name;
  Of of;
  std::string_view help;
};

/// What is known at one moment, of what the state is about.
struct WaitLook {
  client::MasterStatus master;
  std::vector<client::SlaveStatus> slaves;  ///< those known
  std::uint32_t wanted = 0;                 ///< the slaves that matter, a mask
  std::string controller = {};              ///< its state
};

/// The state with this name. Throws UsageError with all names.
const WaitState& find_wait_state(std::string_view name);

/// All names with '|' between.
std::string wait_state_words();

/// All names with what they mean, for the verb's help.
std::string wait_states_help();

/// Is the state reached? Of slaves: they are asked, every wanted one is known and in it, and there is one.
bool is_reached(const WaitState& state, const WaitLook& now);

/// In words what is the case now, of what the state is about.
std::string seen(const WaitState& state, const WaitLook& now);

}  // namespace cansync::cli
