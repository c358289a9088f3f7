#include "row_on.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "dds/denial.h"
#include "support/dds_places.h"

namespace given {
namespace {

/// Where all daemons of this process are, one after the other: DDS itself is set up once.
const gateway::dds::ParticipantOptions& place() {
  static const TwoPlaces places("given");
  static const gateway::dds::Participant kept(places.here);
  return places.here;
}

/// "64 times a, b": each word once, with how often it comes.
std::string counted_words(const std::map<std::string, unsigned>& counts) {
  std::string all;
  for (const auto& [word, count] : counts) {
    if (!all.empty()) all += ", ";
    if (count > 1) all += std::to_string(count) + " times ";
    all += word;
  }
  return all.empty() ? "nothing" : all;
}

}  // namespace

std::string word_of(gateway_ReplyCode code, gateway_RefusalCause cause) {
  static constexpr std::array kWords = {"done",
                                        "refused",
                                        "slave error",
                                        "timeout",
                                        "outcome unknown",
                                        "word expected",
                                        "doubleword expected",
                                        "value too wide",
                                        "cancelled",
                                        "stopped",
                                        "slave lost",
                                        "replaced"};
  std::string word = kWords.at(code);
  if (code == gateway_REPLY_REFUSED) word += ": " + std::string(gateway::dds::name(cause));
  return word;
}

RowOn::RowOn(const ProtocolUnderTest& protocol, const std::string& file, const std::string& changed)
    : make_(protocol.make), text_(protocol.file + file), changed_(protocol.file + changed) {
  begin();
}

void RowOn::begin() {
  // It knows nothing of the daemon before.
  watcher_ = std::make_unique<Program>(place(), 255, 0);
  daemon_ = make_(text_, place(), journal_, ++starts_);
  daemon_->start();
}

void RowOn::restart() {
  daemon_->stop();
  daemon_.reset();
  collect();
  begin();
}

void RowOn::kill(Giver giver) {
  programs_[index(giver)].reset();
  if (giver == Giver::first) answered_ = 0;
}

void RowOn::set_running(bool /*running*/) {
  FAIL() << "it has no run and stop";
}

void RowOn::keep_in_controller(bool keep) {
  daemon_->bus().keeps = keep;
  if (!keep) daemon_->bus().let_go();
}

void RowOn::run(std::chrono::milliseconds span) {
  constexpr std::chrono::milliseconds kStep{10};
  for (; span > std::chrono::milliseconds(0); span -= kStep) {
    each_step();
    daemon_->run(std::min(span, kStep));
    collect();
  }
}

void RowOn::let_it_be_seen() {
  daemon_->settle();
  collect();
}

std::string RowOn::told() {
  return counted_words(std::exchange(answers_, {}));
}

std::uint64_t RowOn::unanswered() const {
  return programs_[0] ? programs_[0]->requests() - answered_ : 0;
}

std::string RowOn::events() {
  std::string all;
  const auto entries = journal_.all();
  for (; told_ < entries.size(); ++told_) {
    if (!entries[told_].field("CANSYNC_ACTION").empty()) continue;  // what a request changed
    const std::string code = entries[told_].field("EVENT");
    // Of what the test does to the daemon; and that refusals are over, which is told after a second of this computer's time.
    if (is_noise(code) || code == "configuration_reloaded" || code == "dds_message" ||
        code == "sending_failed" || code == "sending_restored" || code == "reference_refusals_over" ||
        all.find(code) != std::string::npos)
      continue;
    all += (all.empty() ? "" : ", ") + code;
  }
  return all.empty() ? "nothing" : all;
}

std::string RowOn::frames(const std::function<std::string(const can::Frame&)>& word) {
  std::map<std::string, unsigned> counts;
  for (const can::Frame& frame : daemon_->bus().own) {
    const std::string one = word(frame);
    if (!one.empty()) counts[one] += is_job() ? 1 : counts[one] == 0;
  }
  daemon_->bus().own.clear();
  return counted_words(counts);
}

Program& RowOn::program(Giver giver) {
  std::unique_ptr<Program>& one = programs_[index(giver)];
  const bool first = giver == Giver::first;
  // No two programs have one number, as none have one GUID.
  if (!one) one = std::make_unique<Program>(place(), ++programs_so_far_, first ? 1 : 5);
  one->address(daemon_->identity);
  return *one;
}

Program& RowOn::watcher() {
  watcher_->address(daemon_->identity);
  return *watcher_;
}

}  // namespace given
