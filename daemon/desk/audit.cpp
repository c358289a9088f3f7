#include "daemon/desk/audit.h"

#include <fmt/format.h>
#include <openssl/evp.h>

#include <array>

#include "text/counts.h"

namespace cansyncd {
namespace {

constexpr std::chrono::seconds kWindow{1};

std::string line_of(const Requester& who, const Change& change, const std::string& before,
                    const std::string& result) {
  std::string line(change.action);
  if (change.slave >= 0) line += " " + change.slave_text();
  if (!change.what.empty()) line += " " + change.what;
  return fmt::format("{} = {} (before: {}) by {}: {}", line, change.new_value, before, who.label, result);
}

}  // namespace

std::string Change::slave_text() const {
  if (slave < 0) return "";
  return slave_name.empty() ? fmt::format("slave {}", slave)
                            : fmt::format("slave {} '{}'", slave, slave_name);
}

std::string hash_text(const std::uint8_t* data, std::size_t size) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest = {};
  unsigned length = 0;
  if (EVP_Digest(data, size, digest.data(), &length, EVP_sha256(), nullptr) != 1) return {};
  std::string text = "SHA-256 ";
  for (unsigned i = 0; i < length; ++i) text += fmt::format("{:02x}", digest[i]);
  return text;
}

void AuditTrail::ended(const Requester& who, const Change& change, const std::string& before, const End& end,
                       SteadyTime now) {
  write({who, change, before, std::string(end.outcome),
         end.done ? EventCode("request_done") : EventCode("request_failed")},
        now);
}

void AuditTrail::refused(const Requester& who, const Change& change, const std::string& before,
                         const gateway::dds::Denial& denial, SteadyTime now) {
  if (may_record_refusal(now))
    write({who, change, before, "refused: " + text_of(denial), "request_refused"}, now);
}

bool AuditTrail::may_record_refusal(SteadyTime now) {
  (void)tick(now);
  if (now - window_ >= kWindow) {
    window_ = now;
    recorded_ = 0;
  }
  if (recorded_ == kRefused) {
    ++not_recorded_;
    return false;
  }
  ++recorded_;
  return true;
}

std::optional<SteadyTime> AuditTrail::tick(SteadyTime now) {
  if (not_recorded_ == 0) return std::nullopt;
  if (now - window_ < kWindow) return window_ + kWindow;
  journal_.write(LogPriority::notice, "requests_not_recorded",
                 fmt::format("{} refused within a second and not recorded one by one",
                             text::counted(not_recorded_, "more request was", "more requests were")),
                 {{"BUS", bus_}, {"CANSYNC_REFUSED", std::to_string(not_recorded_)}});
  not_recorded_ = 0;
  return std::nullopt;
}

void AuditTrail::write(const Entry& entry, SteadyTime now) {
  const Change& change = entry.change;
  std::string line = line_of(entry.who, change, entry.before, entry.result);
  const auto number = [](int value) { return value < 0 ? std::string() : std::to_string(value); };
  journal_.write(LogPriority::notice, entry.code, line,
                 {{"BUS", bus_},
                  {"SLAVE", number(change.slave)},
                  {"PARAMETER", number(change.parameter)},
                  {"CLIENT", entry.who.name},
                  {"CANSYNC_PARTICIPANT", entry.who.participant},
                  {"CANSYNC_REQUEST", std::to_string(entry.who.request)},
                  {"CANSYNC_ACTION", std::string(change.action)},
                  {"CANSYNC_WHAT", change.what},
                  {"CANSYNC_OLD", entry.before},
                  {"CANSYNC_NEW", change.new_value},
                  {"CANSYNC_RESULT", entry.result}});
  EventText event{entry.code == "request_done" ? gateway_SEVERITY_INFO : gateway_SEVERITY_WARNING, entry.code,
                  change.slave < slaves_ ? change.slave : -1, std::move(line), std::nullopt};
  event.request = RequestRecord{entry.who.name, entry.who.participant, change.action,
                                entry.before,   change.new_value,      entry.result};
  events_.publish(event, now);
}

}  // namespace cansyncd
