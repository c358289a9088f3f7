#include "dds/security.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include <filesystem>

#include "dds/entity.h"

namespace gateway::dds {
namespace {

namespace fs = std::filesystem;

/// Debian keeps the plugins in a folder beside the library, others in the same one.
std::string plugin(std::string_view name) {
  Dl_info info = {};
  const fs::path library = ::dladdr(reinterpret_cast<const void*>(&dds_create_participant), &info) != 0
                               ? fs::path(info.dli_fname)
                               : fs::path();
  std::error_code error;
  for (const fs::path& folder : {library.parent_path() / "libddsc0debian", library.parent_path()}) {
    const fs::path file = folder / fmt::format("libdds_security_{}.so", name);
    if (fs::exists(file, error)) return file.string();
  }
  throw SetupError(fmt::format(
      "DDS Security: the plugin libdds_security_{}.so of Cyclone DDS is missing beside {}; install the "
      "package libddsc0debian anew",
      name, library.string()));
}

void set_plugin(dds_qos_t* qos, const std::string& property, const std::string& name,
                const std::string& verb) {
  const std::string prefix = "dds.sec." + property + ".library.";
  dds_qset_prop(qos, (prefix + "path").c_str(), plugin(name).c_str());
  dds_qset_prop(qos, (prefix + "init").c_str(), ("init_" + verb).c_str());
  dds_qset_prop(qos, (prefix + "finalize").c_str(), ("finalize_" + verb).c_str());
}

}  // namespace

SecurityFiles::SecurityFiles(const std::string& folder)
    : identity_ca(folder + "/identity_ca.pem"),
      permissions_ca(folder + "/permissions_ca.pem"),
      governance(folder + "/governance.p7s"),
      certificate(folder + "/certificate.pem"),
      key(folder + "/key.pem"),
      permissions(folder + "/permissions.p7s") {}

void add_security(dds_qos_t* qos, const std::string& folder) {
  set_plugin(qos, "auth", "auth", "authentication");
  set_plugin(qos, "crypto", "crypto", "crypto");
  set_plugin(qos, "access", "ac", "access_control");
  const SecurityFiles files(folder);
  const auto file = [qos](const char* property, const std::string& path) {
    dds_qset_prop(qos, property, ("file:" + path).c_str());
  };
  file("dds.sec.auth.identity_ca", files.identity_ca);
  file("dds.sec.auth.identity_certificate", files.certificate);
  file("dds.sec.auth.private_key", files.key);
  file("dds.sec.access.permissions_ca", files.permissions_ca);
  file("dds.sec.access.governance", files.governance);
  file("dds.sec.access.permissions", files.permissions);
}

std::string no_right(std::string_view topic, std::string_view role) {
  return fmt::format("no right to write topic {}; it needs the role {}: cansync-security add", topic, role);
}

}  // namespace gateway::dds
