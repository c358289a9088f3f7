#pragma once

#include <string>
#include <vector>

#include "cansync/passport.h"
#include "cansync/session.h"
#include "profile/profile.h"

/// Where passports come from: drives and files. Main thread only.
namespace cansync::cli {

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

/// A passport of a verb's argument ended before there was one; what to say is in `what()`.
class NoPassport : public std::runtime_error {
 public:
  NoPassport(ExitCode code, const std::string& text) : std::runtime_error(text), code_(code) {}
  ExitCode code() const noexcept { return code_; }

 private:
  ExitCode code_;
};

/// The passport in a file. Throws NoPassport (refused) for one that was changed after it was written, unless
/// `force`; std::runtime_error for what is none.
Passport passport_of_file(const std::string& path, bool force);

/// The passport of a slave now, by its profile or that of `--profile`. What could not be read is said in
/// remarks. Throws NoPassport when the reading was stopped.
Passport passport_of_slave(Session& session, unsigned slave, const std::string& profile);

/// Is this argument a file, and not a slave? A number is a slave; what has a '/' or '.', or names a file that
/// is there, is a file; everything else a slave's name.
bool is_file_argument(const std::string& text);

}  // namespace cansync::cli
