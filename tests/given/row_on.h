#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "daemon.h"
#include "dds/denial.h"
#include "program.h"
#include "row.h"
#include "support/dds_places.h"
#include "support/kept_journal.h"

namespace given {

/// Where all daemons of this process are, one after the other: DDS itself is set up once.
inline const gateway::dds::ParticipantOptions& place() {
  static const TwoPlaces places("given");
  static const gateway::dds::Participant kept(places.here);
  return places.here;
}

/// Words for an answer: "done", "refused: read_only".
inline std::string word_of(gateway_ReplyCode code, gateway_RefusalCause cause) {
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

/// "64 times a, b": each word once, with how often it comes; `none` when there is none.
inline std::string counted_words(const std::map<std::string, unsigned>& counts, const char* none) {
  std::string all;
  for (const auto& [word, count] : counts) {
    if (!all.empty()) all += ", ";
    if (count > 1) all += std::to_string(count) + " times ";
    all += word;
  }
  return all.empty() ? none : all;
}

/// A row on the daemon of a protocol, with two programs.
template <class Parts, class DaemonOf = Daemon<Parts>>
class RowOn : public Row {
 public:
  using File = typename Parts::File;

  void kill(Giver giver) override { programs_[index(giver)].reset(); }

  void set_read_only(bool read_only) override {
    auto config = file().config;
    config.access.read_only = read_only;
    daemon_->gateway.reload(config);
  }
  void reload() override { daemon_->gateway.reload(load(changed_).config); }
  void restart() override {
    daemon_->stop();
    daemon_.reset();
    begin();
  }
  void set_running(bool /*running*/) override { FAIL() << "it has no run and stop"; }
  void take_bus_off() override { daemon_->bus.take_off(); }
  void bring_bus_back() override { daemon_->bus.bring_back(); }
  void set_listens_only() override { daemon_->bus.listens_only = true; }
  void set_full(bool full) override { daemon_->bus.full = full; }
  void keep_in_controller(bool keep) override {
    daemon_->bus.keeps = keep;
    if (!keep) daemon_->bus.let_go();
  }
  void run(std::chrono::milliseconds span) override {
    constexpr std::chrono::milliseconds kStep{10};
    for (; span > std::chrono::milliseconds(0); span -= kStep) {
      each_step();
      daemon_->run(std::min(span, kStep));
      collect();
    }
  }
  void let_it_be_seen() override {
    settle(daemon_->gateway, daemon_->exchange);
    collect();
  }
  /// What has been answered since the last call, for what is given by requests.
  std::string told() override { return counted_words(std::exchange(answers_, {}), "nothing"); }

  std::string events() override {
    std::string all;
    const auto entries = journal_.all();
    for (; told_ < entries.size(); ++told_) {
      if (!entries[told_].field("CANSYNC_ACTION").empty()) continue;  // what a request changed
      const std::string code = entries[told_].field("EVENT");
      // Of what the test does to the daemon.
      if (is_noise(code) || code == "configuration_reloaded" || code == "dds_message" ||
          code == "sending_failed" || code == "sending_restored" || all.find(code) != std::string::npos)
        continue;
      all += (all.empty() ? "" : ", ") + code;
    }
    return all.empty() ? "nothing" : all;
  }

 protected:
  static constexpr std::size_t index(Giver giver) { return giver == Giver::first ? 0 : 1; }

  /// `text`: of the file; `changed`: another one that says something else of what is given.
  explicit RowOn(std::string text, std::string changed = {})
      : text_(std::move(text)), changed_(changed.empty() ? text_ : std::move(changed)) {
    begin();
  }

  Program& program(Giver giver) {
    std::unique_ptr<Program>& one = programs_[index(giver)];
    const bool first = giver == Giver::first;
    if (!one) one = std::make_unique<Program>(place(), first ? 1 : 2, first ? 1 : 5);
    one->address(daemon_->identity);
    return *one;
  }
  Program& watcher() {
    watcher_.address(daemon_->identity);
    return watcher_;
  }
  DaemonOf& daemon() { return *daemon_; }

  /// An event that comes of what the row does to see something.
  virtual bool is_noise(const std::string& /*code*/) const { return false; }
  /// Every 10 ms: what the programs do again and again, and what other nodes do.
  virtual void each_step() {}
  /// Takes the answers that have come for the first giver: `collect_answers` of their topic.
  virtual void collect() {}
  template <class Reply>
  void collect_answers() {
    if (!programs_[0]) return;
    programs_[0]->template take_answers<Reply>(
        [&](const Reply& reply) { ++answers_[word_of(reply.code, reply.cause)]; });
  }
  bool lives(Giver giver) const { return programs_[index(giver)] != nullptr; }
  /// What of the daemon stood on the bus: `word(frame)` says whose it is; empty: of something else. A state's words
  /// stand there once each, a job's with their number.
  template <class Word>
  std::string frames(Word&& word) {
    std::map<std::string, unsigned> counts;
    for (const can::Frame& frame : daemon_->bus.own) {
      const std::string one = word(frame);
      if (!one.empty()) counts[one] += is_job() ? 1 : counts[one] == 0;
    }
    daemon_->bus.own.clear();
    return counted_words(counts, "nothing");
  }

 private:
  static File load(const std::string& text) {
    File file = Parts::load({"given.toml", text}, {});
    for (const auto& problem : file.problems) ADD_FAILURE() << problem.text;
    return file;
  }
  const File& file() {
    if (!file_) file_ = std::make_unique<File>(load(text_));
    return *file_;
  }
  void begin() {
    File file = load(text_);
    file.config.dds.domain = place().domain;
    file.config.dds.partition = place().partition;
    daemon_ = std::make_unique<DaemonOf>(std::move(file), place(), journal_, ++starts_);
    daemon_->start();
  }

  const std::string text_;
  const std::string changed_;
  std::unique_ptr<File> file_;
  cansyncd::KeptJournal journal_;
  std::size_t told_ = 0;  ///< entries of the journal
  std::unique_ptr<DaemonOf> daemon_;
  std::uint8_t starts_ = 0;
  std::array<std::unique_ptr<Program>, 2> programs_;
  std::map<std::string, unsigned> answers_;  ///< to the first giver
  Program watcher_{place(), 9, 0};
};

}  // namespace given
