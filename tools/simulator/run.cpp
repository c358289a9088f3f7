#include "simulator/run.h"

#include <fmt/format.h>

#include "can/adapter/link_remedy.h"
#include "can/link_kernel.h"

namespace cansync_sim {
namespace {

/// Tells when the interface is lost and when it is back.
class LinkLog {
 public:
  explicit LinkLog(const RunSettings& settings) : settings_(settings) {}

  /// True when the interface has just been lost.
  bool look(Link link) {
    if (link == link_) return false;
    const bool lost = link_ == Link::up;
    link_ = link;
    if (link == Link::up) {
      settings_.remark(settings_.interface + " is up; on the bus again");
    } else {
      settings_.remark(fmt::format("{} {}; waiting for it. {}", settings_.interface,
                                   link == Link::down ? "is down" : "does not exist",
                                   remedy(link, settings_.interface)));
    }
    return lost;
  }

 private:
  const RunSettings& settings_;
  Link link_ = Link::up;
};

void send_due(Station& station, Port& port) {
  while (const auto frame = station.next(port.now())) station.sent(port.send(*frame));
}

}  // namespace

std::string remedy(Link link, const std::string& interface) {
  switch (link) {
    case Link::missing:
      return can::link_remedy(interface, {});
    case Link::down: {
      can::LinkFacts facts = can::make_link_kernel()->read(interface);
      facts.present = true;
      return facts.listen_only ? can::sending_remedy(interface) : can::link_remedy(interface, facts);
    }
    case Link::up:
      break;
  }
  return {};
}

void run(Station& station, Port& port, const RunSettings& settings) {
  LinkLog link(settings);
  do {
    if (link.look(port.link())) station.link_lost();
    can::ReceivedFrame frame;
    // Answers go out after each frame: the slot of the first would be over when all have been read.
    while (port.receive(frame)) {
      station.receive(frame, port.now());
      send_due(station, port);
      if (settings.look) settings.look();
    }
    send_due(station, port);
  } while (port.wait(station.next_due()));
}

}  // namespace cansync_sim
