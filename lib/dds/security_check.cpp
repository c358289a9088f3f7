#include <fmt/format.h>
#include <fnmatch.h>
#include <openssl/bio.h>
#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/pkcs7.h>
#include <openssl/x509.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <memory>
#include <vector>

#include "dds/reply_partition.h"
#include "dds/security.h"

/// What Cyclone's plugins would say of wrong files with a number alone.
namespace gateway::dds {
namespace {

template <auto Free>
struct Deleter {
  template <class T>
  void operator()(T* object) const noexcept {
    Free(object);
  }
};
using Bio = std::unique_ptr<BIO, Deleter<BIO_free_all>>;
using Certificate = std::unique_ptr<X509, Deleter<X509_free>>;
using Key = std::unique_ptr<EVP_PKEY, Deleter<EVP_PKEY_free>>;
using Pkcs7 = std::unique_ptr<PKCS7, Deleter<PKCS7_free>>;
using Store = std::unique_ptr<X509_STORE, Deleter<X509_STORE_free>>;

using Problem = std::optional<std::string>;

std::string text_of(BIO* bio) {
  char* data = nullptr;
  const long size = BIO_get_mem_data(bio, &data);
  return {data, static_cast<std::size_t>(std::max(size, 0L))};
}

std::string subject_of(const X509* certificate) {
  const Bio out(BIO_new(BIO_s_mem()));
  X509_NAME_print_ex(out.get(), X509_get_subject_name(certificate), 0, XN_FLAG_RFC2253);
  return text_of(out.get());
}

std::string date_text(const ASN1_TIME* time) {
  const Bio out(BIO_new(BIO_s_mem()));
  ASN1_TIME_print(out.get(), time);
  return text_of(out.get());
}

Problem readable(const std::string& path) {
  if (::access(path.c_str(), R_OK) == 0) return std::nullopt;
  const bool missing = ::access(path.c_str(), F_OK) != 0;
  return fmt::format(
      "{}: {}; the folder must be one that `cansync-security add` made, and belong to the user of this "
      "program",
      path, missing ? "is missing" : "cannot be read by this user");
}

Certificate read_certificate(const std::string& path) {
  const Bio in(BIO_new_file(path.c_str(), "r"));
  return Certificate(in ? PEM_read_bio_X509(in.get(), nullptr, nullptr, nullptr) : nullptr);
}

constexpr const char* kRenew =
    "renew it where the authorities are (cansync-security renew DIR NAME), and copy the folder DIR/NAME here";
constexpr const char* kNewAuthorities =
    "an authority cannot be renewed: make new ones (cansync-security init), and new identities for the daemon and all "
    "clients";

/// `remedy`: of one that has expired.
Problem check_certificate(const std::string& path, const X509* certificate, const char* remedy) {
  if (certificate == nullptr) return fmt::format("{}: holds no certificate (PEM)", path);
  if (X509_cmp_current_time(X509_get0_notAfter(certificate)) < 0) {
    return fmt::format("{}: expired on {}; {}", path, date_text(X509_get0_notAfter(certificate)), remedy);
  }
  if (X509_cmp_current_time(X509_get0_notBefore(certificate)) > 0) {
    return fmt::format("{}: valid from {} on; is the clock of this computer right?", path,
                       date_text(X509_get0_notBefore(certificate)));
  }
  return std::nullopt;
}

Problem check_key(const std::string& path, const X509* certificate) {
  struct stat status = {};
  constexpr mode_t kOthers = S_IRWXO | S_IWGRP;
  if (::stat(path.c_str(), &status) == 0 && (status.st_mode & kOthers) != 0) {
    return fmt::format("{}: is a private key and open to others (mode {:04o}); chmod 600 {}", path,
                       static_cast<unsigned>(status.st_mode & 07777u), path);
  }
  const Bio in(BIO_new_file(path.c_str(), "r"));
  const Key key(in ? PEM_read_bio_PrivateKey(in.get(), nullptr, nullptr, nullptr) : nullptr);
  if (!key) return fmt::format("{}: holds no private key (PEM, without password)", path);
  if (X509_check_private_key(certificate, key.get()) != 1) {
    return fmt::format(
        "{}: is not the key of certificate.pem; both must come from the same `cansync-security add`", path);
  }
  return std::nullopt;
}

/// The text of a signed file; nothing when the authority has not signed it.
std::optional<std::string> signed_text(const std::string& path, X509* authority) {
  const Bio in(BIO_new_file(path.c_str(), "r"));
  BIO* content = nullptr;
  const Pkcs7 message(in ? SMIME_read_PKCS7(in.get(), &content) : nullptr);
  const Bio owned(content);
  const Store store(X509_STORE_new());
  if (!message || X509_STORE_add_cert(store.get(), authority) != 1) return std::nullopt;
  const Bio out(BIO_new(BIO_s_mem()));
  if (PKCS7_verify(message.get(), nullptr, store.get(), content, out.get(), PKCS7_TEXT) != 1)
    return std::nullopt;
  return text_of(out.get());
}

/// What stands between <tag> and </tag>, each time.
std::vector<std::string> elements(std::string_view xml, const std::string& tag) {
  const std::string begin = "<" + tag + ">";
  const std::string end = "</" + tag + ">";
  std::vector<std::string> out;
  for (std::size_t at = xml.find(begin); at != std::string_view::npos; at = xml.find(begin, at)) {
    at += begin.size();
    const std::size_t to = std::min(xml.find(end, at), xml.size());
    out.emplace_back(xml.substr(at, to - at));
    at = to;
  }
  return out;
}

using Instant = std::chrono::system_clock::time_point;

std::optional<Instant> end_of(const X509* certificate) {
  tm end = {};
  if (certificate == nullptr || ASN1_TIME_to_tm(X509_get0_notAfter(certificate), &end) != 1)
    return std::nullopt;
  return std::chrono::system_clock::from_time_t(timegm(&end));
}

/// The earliest end that a permissions document names: "2036-01-31T12:00:00Z".
std::optional<Instant> end_of(const std::string& permissions) {
  std::optional<Instant> first;
  for (const std::string& text : elements(permissions, "not_after")) {
    tm end = {};
    if (::strptime(text.c_str(), "%Y-%m-%dT%H:%M:%SZ", &end) == nullptr) continue;
    const Instant at = std::chrono::system_clock::from_time_t(timegm(&end));
    if (!first || at < *first) first = at;
  }
  return first;
}

bool any_fits(const std::vector<std::string>& patterns, const std::string& text) {
  return std::any_of(patterns.begin(), patterns.end(), [&](const std::string& pattern) {
    return ::fnmatch(pattern.c_str(), text.c_str(), 0) == 0;
  });
}

Problem check_permissions(const std::string& path, const std::string& xml, const std::string& subject,
                          const std::string& partition) {
  const auto subjects = elements(xml, "subject_name");
  if (std::find(subjects.begin(), subjects.end(), subject) == subjects.end()) {
    return fmt::format(
        "{}: is for {}, but certificate.pem is that of {}; both must come from the same `cansync-security "
        "add`",
        path, subjects.empty() ? "nobody" : subjects.front(), subject);
  }
  const auto buses = elements(xml, "partition");
  if (!any_fits(buses, partition)) {
    return fmt::format(
        "{}: gives no right on bus {} (DDS partition), only on {}; give another bus, or make an identity for "
        "it: cansync-security add --bus {}",
        path, partition, buses.empty() ? "none" : fmt::format("{}", fmt::join(buses, ", ")), partition);
  }
  if (!any_fits(buses, reply_partition(partition, {}))) {
    return fmt::format(
        "{}: gives no right on the replies of bus {} (DDS partition {}), as identities made for data model 6 or "
        "older; make a new one: cansync-security add --bus {}",
        path, partition, every_reply_partition(partition), partition);
  }
  return std::nullopt;
}

Problem check_files(const SecurityFiles& files, const std::string& partition) {
  for (const auto& path : {files.identity_ca, files.permissions_ca, files.governance, files.certificate,
                           files.key, files.permissions}) {
    if (auto problem = readable(path)) return problem;
  }
  const Certificate identity_ca = read_certificate(files.identity_ca);
  const Certificate permissions_ca = read_certificate(files.permissions_ca);
  const Certificate certificate = read_certificate(files.certificate);
  if (auto problem = check_certificate(files.identity_ca, identity_ca.get(), kNewAuthorities)) return problem;
  if (auto problem = check_certificate(files.permissions_ca, permissions_ca.get(), kNewAuthorities))
    return problem;
  if (auto problem = check_certificate(files.certificate, certificate.get(), kRenew)) return problem;
  if (X509_verify(certificate.get(), X509_get0_pubkey(identity_ca.get())) != 1) {
    return fmt::format(
        "{}: was not issued by identity_ca.pem; use the folder as `cansync-security add` made it",
        files.certificate);
  }
  if (auto problem = check_key(files.key, certificate.get())) return problem;
  const auto permissions = signed_text(files.permissions, permissions_ca.get());
  for (const auto& path : {files.governance, files.permissions}) {
    if (!signed_text(path, permissions_ca.get())) {
      return fmt::format(
          "{}: is not signed by permissions_ca.pem, or was changed since; use the folder as "
          "`cansync-security add` made it",
          path);
    }
  }
  if (const auto end = end_of(*permissions); end && *end <= std::chrono::system_clock::now())
    return fmt::format("{}: its validity has ended; {}", files.permissions, kRenew);
  return check_permissions(files.permissions, *permissions, subject_of(certificate.get()), partition);
}

}  // namespace

std::optional<std::string> security_problem(const std::string& folder, const std::string& partition) {
  auto problem = check_files(SecurityFiles(folder), partition);
  ERR_clear_error();
  return problem;
}

std::optional<IdentityEnd> identity_end(const std::string& folder) {
  const SecurityFiles files(folder);
  std::optional<IdentityEnd> first;
  const auto take = [&first](const std::string& file, std::optional<Instant> at, bool is_authority) {
    if (at && (!first || *at < first->at)) first = IdentityEnd{file, *at, is_authority};
  };
  const Certificate permissions_ca = read_certificate(files.permissions_ca);
  // Of those that end together the identity is named: it can be renewed.
  take(files.certificate, end_of(read_certificate(files.certificate).get()), false);
  const auto permissions =
      permissions_ca ? signed_text(files.permissions, permissions_ca.get()) : std::nullopt;
  if (permissions) take(files.permissions, end_of(*permissions), false);
  take(files.identity_ca, end_of(read_certificate(files.identity_ca).get()), true);
  take(files.permissions_ca, end_of(permissions_ca.get()), true);
  ERR_clear_error();
  return first;
}

std::string security_subject(const std::string& folder) {
  const Certificate certificate = read_certificate(SecurityFiles(folder).certificate);
  ERR_clear_error();
  return certificate ? subject_of(certificate.get()) : "";
}

bool may_publish(const std::string& folder, std::string_view topic) {
  const SecurityFiles files(folder);
  const Certificate authority = read_certificate(files.permissions_ca);
  const auto xml = authority ? signed_text(files.permissions, authority.get()) : std::nullopt;
  ERR_clear_error();
  if (!xml) return false;
  for (const std::string& part : elements(*xml, "publish")) {
    if (any_fits(elements(part, "topic"), std::string(topic))) return true;
  }
  return false;
}

}  // namespace gateway::dds
