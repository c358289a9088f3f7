#pragma once

#include <dds/dds.h>

#include <chrono>
#include <optional>
#include <string>
#include <string_view>

/// DDS Security of one participant: the folder that `cansync-security add` makes for it (docs/security.md).
namespace gateway::dds {

/// The files of such a folder.
struct SecurityFiles {
  explicit SecurityFiles(const std::string& folder);
  std::string identity_ca;     ///< certificate of the authority that issues identities
  std::string permissions_ca;  ///< certificate of the authority that signs permissions
  std::string governance;      ///< what is protected, signed
  std::string certificate;     ///< who this is
  std::string key;             ///< private key of the certificate
  std::string permissions;     ///< what it may do, signed
};

/// What is wrong with the files, with the file's name and the remedy: one is missing, readable for everybody,
/// expired, issued or signed by another authority, or gives no right on the bus (partition). Nothing: they
/// can be used. Any thread.
std::optional<std::string> security_problem(const std::string& folder, const std::string& partition);

/// The first of the files of an identity that ends.
struct IdentityEnd {
  std::string file;  ///< a certificate, or the permissions
  std::chrono::system_clock::time_point at;
  bool is_authority = false;  ///< the certificate of an authority: a new identity does not help
};

/// When the identity of this folder ends: the first of its certificate, those of both authorities and the
/// permissions. What cannot be read has no end; nothing: none can be. Any thread; reads files.
std::optional<IdentityEnd> identity_end(const std::string& folder);

/// "CN=bob,OU=viewer,O=cansync"; empty when the certificate cannot be read.
std::string security_subject(const std::string& folder);

/// May the identity of this folder write the topic, by its own permissions? They are checked again by
/// everyone else.
bool may_publish(const std::string& folder, std::string_view topic);

/// Why a program whose identity may not write the topic is refused; `role`: the least that may.
std::string no_right(std::string_view topic, std::string_view role);

/// Switches DDS Security on in the QoS of a participant. Throws SetupError when Cyclone's plugins are not
/// installed.
void add_security(dds_qos_t* qos, const std::string& folder);

}  // namespace gateway::dds
