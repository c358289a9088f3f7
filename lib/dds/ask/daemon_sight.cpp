#include "dds/ask/daemon_sight.h"

#include <fmt/format.h>
#include <sys/random.h>

#include <algorithm>
#include <cstddef>
#include <span>
#include <utility>

#include "dds/bounded_text.h"
#include "dds/daemon_identity.h"
#include "dds/writer_identity.h"
#include "text/counts.h"

namespace gateway::dds {

using std::chrono::steady_clock;

OtherProtocol::OtherProtocol(std::string_view bus_name, std::string_view served, std::string_view needed)
    : NoDaemon(fmt::format("bus {} is served as {}; this program needs {}", bus_name, served, needed)),
      bus(bus_name),
      served_as(served),
      needs(needed) {}

BusAddress bus_address(std::string_view text) {
  const auto cut = text.find('/');
  if (cut == std::string_view::npos) return {{}, std::string(text)};
  return {std::string(text.substr(0, cut)), std::string(text.substr(cut + 1))};
}

std::string on_other_computer(const BusAddress& wanted, std::string_view place, std::string_view found) {
  return fmt::format(
      "bus {0} of computer {1} is not served ({2}); another computer serves this name: {3}; nothing was sent. Run `cansync "
      "doctor` on {1} for the reason, and give each bus on the network a separate bus.name",
      wanted.bus, wanted.computer, place, found);
}

ParticipantOptions ClientOptions::participant() const {
  return {.domain = domain,
          .partition = bus_address(bus).bus,
          .interface = interface,
          .xml = xml,
          .security = security,
          .final_types = final_types};
}

std::array<std::uint8_t, 16> random_client_identity() {
  std::array<std::uint8_t, 16> identity;
  if (getrandom(identity.data(), identity.size(), 0) != static_cast<ssize_t>(identity.size()))
    throw SetupError("the system gave no random numbers for the client's identity");
  return identity;
}

DaemonSight::DaemonSight(const Participant& participant, DataSignal& signal, std::string_view bus)
    : participant_(participant), address_(bus_address(bus)), statuses_(participant, &signal) {}

void DaemonSight::look() {
  statuses_.take_batch([this](const gateway_GatewayStatus& sample, const dds_sample_info_t& info) {
    if (!info.valid_data) return;
    newest_ = sample;
    hosts_[info.publication_handle] = text(sample.host);
    choice_.heard(info.publication_handle, daemon_of(sample));
  });
  std::array<dds_instance_handle_t, 64> matched = {};
  const dds_return_t count = dds_get_matched_publications(statuses_.handle(), matched.data(), matched.size());
  const auto there = std::min(static_cast<std::size_t>(std::max(count, 0)), matched.size());
  const auto living = std::span(matched).first(there);
  choice_.look(steady_clock::now(), living);
  std::erase_if(hosts_, [&](const auto& host) {
    return std::find(living.begin(), living.end(), host.first) == living.end();
  });
  if (choice_.view() != DaemonChoice::View::one) reached_ = 0;
}

void DaemonSight::look_until_reached(const ClientOptions& options, DataSignal& signal) {
  constexpr std::chrono::seconds kMost{1};
  const auto end = steady_clock::now() + kMost;
  look();
  while (choice_.view() == DaemonChoice::View::one && !reached()) {
    if (options.stopped() || steady_clock::now() >= end) return;
    (void)signal.wait(kLookMs);
    signal.clear();
    look();
  }
}

bool DaemonSight::on_other_computer() const {
  if (choice_.view() != DaemonChoice::View::one) return false;
  const auto host = hosts_.find(choice_.living().front());
  return !address_.is_on(host == hosts_.end() ? std::string() : host->second);
}

dds_instance_handle_t DaemonSight::participant_of_daemon() const {
  if (choice_.view() != DaemonChoice::View::one || on_other_computer()) return 0;
  return participant_of_writer(statuses_.handle(), choice_.living().front());
}

bool DaemonSight::is_read(const WriterBase& writer) const {
  const auto daemon = participant_of_daemon();
  return daemon != 0 && is_read_by(writer, daemon);
}

bool DaemonSight::is_written(const ReaderBase& reader) const {
  const auto daemon = participant_of_daemon();
  return daemon != 0 && is_written_by(reader, daemon);
}

bool DaemonSight::reached() {
  if (choice_.view() != DaemonChoice::View::one || on_other_computer()) return false;
  const DaemonChoice::Place place = choice_.living().front();
  if (reached_ == place) return true;
  const auto daemon = participant_of_daemon();
  const bool all =
      daemon != 0 &&
      std::all_of(ways_.requests.begin(), ways_.requests.end(),
                  [&](const WriterBase* way) { return !way->permitted() || is_read_by(*way, daemon); }) &&
      std::all_of(ways_.replies.begin(), ways_.replies.end(),
                  [&](const ReaderBase* way) { return is_written_by(*way, daemon); });
  reached_ = all ? place : 0;
  return all;
}

std::string DaemonSight::names_of_living() const {
  std::string names;
  for (const auto writer : choice_.living()) {
    if (!names.empty()) names += "; ";
    const auto who = identify_writer(participant_, statuses_.handle(), writer);
    names += who ? who->who : "an unknown program";
  }
  return names;
}

bool DaemonSight::serves_another(std::string_view protocol) const {
  return !protocol.empty() && newest_ && choice_.view() == DaemonChoice::View::one && !on_other_computer() &&
         text(newest_->protocol) != protocol;
}

std::string DaemonSight::absent(const ClientOptions& options, std::string_view protocol,
                                bool other_topics) const {
  if (on_other_computer())
    return gateway::dds::on_other_computer(address_, participant_.place(), names_of_living());
  if (other_topics && !newest_) {
    return fmt::format(
        "the daemon of bus {} has data model 6 or older, this program {}: the two do not understand each other "
        "({}); update cansyncd, or use a program of its version",
        address_.bus, gateway_DATA_MODEL, participant_.place());
  }
  if (protocol.empty()) {
    return fmt::format(
        "no daemon found: looked for {} on {}; is cansyncd running for bus {}, with the same domain and "
        "interface in its [dds] section?",
        text::duration_text(options.wait), participant_.place(), address_.in_words());
  }
  return fmt::format(
      "no daemon found that speaks {}: looked for {} on {}; is cansyncd running for bus {} with bus.protocol = "
      "\"{}\", and with the same domain and interface in its [dds] section?",
      protocol, text::duration_text(options.wait), participant_.place(), address_.in_words(), protocol);
}

std::optional<DaemonSight::Obstacle> DaemonSight::obstacle() {
  using View = DaemonChoice::View;
  const auto refused = [this](std::string reason) {
    choice_.program_told();
    return Obstacle{false, std::move(reason)};
  };
  switch (choice_.view()) {
    case View::several:
      return refused(fmt::format(
          "several daemons serve bus {} ({}): {}; nothing was sent: stop all but one, or give each a "
          "bus.name of its own",
          address_.bus, participant_.place(), names_of_living()));
    case View::unsure:
      return refused(fmt::format(
          "the daemon was started anew, or a second one serves bus {}: {}; nothing was sent; try again "
          "later",
          address_.bus, names_of_living()));
    case View::none:
      choice_.program_told();
      return Obstacle{true, "the daemon has gone"};
    case View::one:
      break;
  }
  if (on_other_computer())
    return refused(gateway::dds::on_other_computer(address_, participant_.place(), names_of_living()));
  if (!reached()) {
    return Obstacle{false,
                    "the daemon has just come, and not all of its topics are known here yet; nothing was "
                    "sent; try again",
                    true};
  }
  if (!choice_.to_be_told()) return std::nullopt;
  return refused(
      "the daemon was started anew; nothing was sent: ask again; requests from now on are for the new one");
}

}  // namespace gateway::dds
