#include "daemon/desk/audit.h"

#include <fmt/format.h>
#include <openssl/evp.h>

#include <algorithm>
#include <array>
#include <utility>

#include "text/counts.h"

namespace cansyncd {
namespace {

constexpr std::chrono::seconds kWindow{1};

std::string line_of(const RequestSeries::Sum& sum) {
  const RecordedRequest& request = sum.newest;
  const Change& change = request.change;
  std::string line(change.action);
  if (change.slave >= 0) line += " " + change.slave_text();
  if (!change.what.empty()) line += " " + change.what;
  line += fmt::format(" = {} (before: {}) by {}: {}", change.new_value, request.before, request.who.label,
                      request.result);
  if (sum.within > std::chrono::seconds(0))
    line += fmt::format(" (the last of {} more within {} s{}{})", sum.count, sum.within.count(),
                        sum.of.empty() ? "" : ", of ", sum.of);
  return line;
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
  record({who, change, before, std::string(end.outcome),
          end.done ? EventCode("request_done") : EventCode("request_failed")},
         now);
}

void AuditTrail::refused(const Requester& who, const Change& change, const std::string& before,
                         const gateway::dds::Denial& denial, SteadyTime now) {
  record({who, change, before, "refused: " + text_of(denial), "request_refused"}, now);
}

void AuditTrail::record(RecordedRequest request, SteadyTime now) {
  const bool refused = request.code == "request_refused";
  std::optional<RequestSeries::Sum> sum;
  if (each_ || request.change.series.empty())
    sum = RequestSeries::Sum{std::move(request)};
  else
    sum = series_.add(std::move(request), now);
  if (sum && (!refused || may_record_refusal(now))) write(*sum, now);
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
  for (const RequestSeries::Sum& sum : series_.take(now)) write(sum, now);
  const auto series_due = series_.next();
  if (not_recorded_ == 0) return series_due;
  if (now - window_ < kWindow) return std::min(window_ + kWindow, series_due.value_or(SteadyTime::max()));
  tell_not_recorded();
  return series_due;
}

void AuditTrail::tell_not_recorded() {
  journal_.write(LogPriority::notice, "requests_not_recorded",
                 fmt::format("{} refused within a second and not recorded one by one",
                             text::counted(not_recorded_, "more request was", "more requests were")),
                 {{"BUS", bus_}, {"CANSYNC_REFUSED", std::to_string(not_recorded_)}});
  not_recorded_ = 0;
}

void AuditTrail::finish(SteadyTime now) {
  for (const RequestSeries::Sum& sum : series_.take(now, true)) write(sum, now);
  if (not_recorded_ != 0) tell_not_recorded();
}

void AuditTrail::write(const RequestSeries::Sum& sum, SteadyTime now) {
  const RecordedRequest& request = sum.newest;
  const Change& change = request.change;
  std::string line = line_of(sum);
  const auto number = [](int value) { return value < 0 ? std::string() : std::to_string(value); };
  journal_.write(LogPriority::notice, request.code, line,
                 {{"BUS", bus_},
                  {"SLAVE", number(change.slave)},
                  {"PARAMETER", number(change.parameter)},
                  {"CLIENT", request.who.name},
                  {"CANSYNC_PARTICIPANT", request.who.participant},
                  {"CANSYNC_REQUEST", std::to_string(request.who.request)},
                  {"CANSYNC_ACTION", std::string(change.action)},
                  {"CANSYNC_WHAT", change.what},
                  {"CANSYNC_OLD", request.before},
                  {"CANSYNC_NEW", change.new_value},
                  {"CANSYNC_RESULT", request.result},
                  {"CANSYNC_COUNT", std::to_string(sum.count)}});
  EventText event{request.code == "request_done" ? gateway_SEVERITY_INFO : gateway_SEVERITY_WARNING,
                  request.code, change.slave < slaves_ ? change.slave : -1, std::move(line), std::nullopt};
  event.request = RequestRecord{request.who.name, request.who.participant, change.action,
                                request.before,   change.new_value,        request.result};
  events_.publish(event, now);
}

}  // namespace cansyncd
