#pragma once

#include <string>
#include <vector>

#include "cli/base/endings.h"
#include "cli/base/session.h"
#include "profile/passport.h"
#include "profile/profile.h"

/// Where passports come from: drives and files. Main thread only.
namespace cansync::cli {

using profile::Passport;

/// A passport read from a drive.
struct TakenPassport {
  Passport passport;                ///< complete only when `ended` is done
  client::Reply ended;              ///< what stopped the reading, or done
  std::vector<std::string> unread;  ///< parameters that the slave answered with an error; they have no value
};

/// Reads every parameter of the profile that may be read from a slave, with few jobs open at once; of
/// volatile ones only with `with_volatile`.
TakenPassport take_passport(Session& session, unsigned slave, const profile::Profile& profile,
                            bool with_volatile = false);

/// The passport in a file. What of it is left out is shown (`tell_left_out`). Throws Ended (refused) for one that
/// was changed after it was written, unless `force`; std::runtime_error for what is none.
Passport passport_of_file(Output& output, const std::string& path, bool force);

/// The passport of a slave now, by its profile or that of `--profile`. What could not be read is said in
/// remarks. Throws Ended when the reading was stopped.
Passport passport_of_slave(Session& session, unsigned slave, const std::string& profile);

/// The slaves of a list, and the passport of each in its file.
struct SlaveFiles {
  std::vector<unsigned> slaves;
  std::vector<std::string> paths;
  std::vector<Passport> passports;
};

/// Reads the file of every slave; `pattern` as in Session::files. Throws like that and like passport_of_file.
SlaveFiles slave_files(Session& session, const std::string& list, const std::string& pattern, bool force);

/// The help of an argument FILE that names such files.
inline constexpr const char* kBackupFileHelp =
    "file of `backup`; for several slaves a name with {slave} or {name} in it";

/// Is this argument a file, and not a slave? A number is a slave; what has a '/' or '.', or names a file that
/// is there, is a file; everything else a slave's name.
bool is_file_argument(const std::string& text);

}  // namespace cansync::cli
