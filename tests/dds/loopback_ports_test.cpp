#include "dds/loopback_ports.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <memory>
#include <set>
#include <string>
#include <vector>

#include "cansync/dds/topics.h"
#include "dds/endpoint.h"
#include "support/dds_places.h"

namespace gateway::dds {
namespace {

/// Takes a UDP port as another program would.
class TakenPort {
 public:
  explicit TakenPort(std::uint32_t port) : socket_(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in address = {};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_ANY);
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    EXPECT_EQ(::bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0) << port;
  }
  ~TakenPort() { ::close(socket_); }
  TakenPort(const TakenPort&) = delete;
  TakenPort& operator=(const TakenPort&) = delete;

 private:
  int socket_;
};

/// What a daemon offers, and what a client has of it.
struct Offer {
  explicit Offer(const ParticipantOptions& options) : participant(options), writer(participant) {}
  Participant participant;
  Writer<gateway_Event> writer;
};
struct Look {
  explicit Look(const ParticipantOptions& options) : participant(options), reader(participant, &signal) {}
  bool finds(std::uint32_t daemons) {
    return eventually(signal, [&] { return reader.matched() >= daemons; });
  }
  DataSignal signal;
  Participant participant;
  Reader<gateway_Event> reader;
};

/// Of one more program in the same domain of the network.
ParticipantOptions one_more(const ParticipantOptions& network, const FreeDomain& inside,
                            std::uint32_t place = 0) {
  ParticipantOptions more = network;
  more.domain = inside.get();
  more.xml = configuration(network, place);
  const std::string discovery = "<Discovery>";
  more.xml.insert(more.xml.find(discovery) + discovery.size(),
                  "<ExternalDomainId>" + std::to_string(network.domain) + "</ExternalDomainId>");
  return more;
}

class LoopbackPorts : public testing::Test {
 protected:
  /// Takes the first ports of the bus.
  void take_places(std::uint32_t count) { take_places(places_.here.partition, count); }
  void take_places(const std::string& bus, std::uint32_t count) {
    for (std::uint32_t place = 0; place < count; ++place) {
      taken_.push_back(
          std::make_unique<TakenPort>(serving_port(places_.here.domain, index_of_place(bus, place))));
    }
  }

  TwoPlaces places_;
  std::vector<std::unique_ptr<TakenPort>> taken_;
};

TEST_F(LoopbackPorts, EveryBusHasEachPlaceOnce) {
  for (const std::string bus :
       {"can0", "can1", "sim", "a", "", "a bus with a long name, longer than others"}) {
    std::set<std::uint32_t> indices;
    for (std::uint32_t place = 0; place < kPlaces; ++place) indices.insert(index_of_place(bus, place));
    EXPECT_EQ(indices.size(), kPlaces) << bus;
    EXPECT_LT(*indices.rbegin(), kPlaces) << bus;
  }
  EXPECT_LT(asking_port(3, kPlaces - 1), serving_port(4, 0))
      << "the ports of the next domain are not touched";
}

TEST_F(LoopbackPorts, TheFirstPlacesOfABusStayWhereProgramsOfOtherBuildsLookForThem) {
  EXPECT_EQ(index_of_place("can0", 0), 15u);
  EXPECT_EQ(index_of_place("can0", 1), 112u);
  EXPECT_EQ(index_of_place("sim", 0), 92u);
}

TEST_F(LoopbackPorts, DaemonThatStartsLaterIsFound) {
  Look client(places_.there);
  const Offer daemon(places_.here);
  EXPECT_TRUE(client.finds(1));
}

TEST_F(LoopbackPorts, DaemonIsFoundInTheLastPlaceThatIsLookedAt) {
  take_places(kPlacesAsked - 1);
  const Offer daemon(places_.here);
  EXPECT_TRUE(Look(places_.there).finds(1));
}

TEST_F(LoopbackPorts, DaemonWithoutOneOfThePlacesThatAreLookedAtIsFoundByThoseBeforeAndAfterIt) {
  take_places(kPlacesAsked);
  Look before(places_.there);
  const Offer daemon(places_.here);
  EXPECT_TRUE(before.finds(1));
  const FreeDomain inside;
  ParticipantOptions client = places_.here;
  client.serves = false;
  EXPECT_TRUE(Look(one_more(client, inside)).finds(1));
}

TEST_F(LoopbackPorts, TwoDaemonsOfABusFindEachOtherWhereverTheyAre) {
  const FreeDomain inside;
  for (const std::uint32_t place : {1u, kPlacesAsked - 1, kPlacesAsked, kPlacesAsked + 3}) {
    const Offer first(places_.here);
    const Offer second(one_more(places_.here, inside, place));
    DataSignal signal;
    Reader<gateway_Event> of_first(first.participant, &signal);
    Reader<gateway_Event> of_second(second.participant, &signal);
    EXPECT_TRUE(eventually(signal, [&] { return of_first.matched() == 2 && of_second.matched() == 2; }))
        << place;
  }
}

TEST_F(LoopbackPorts, ClientsOfABusDoNotKnowOfEachOther) {
  const FreeDomain inside;
  ParticipantOptions other = places_.here;
  other.serves = false;
  const Offer daemon(places_.here);
  Look first(places_.there);
  Look second(one_more(other, inside));
  ASSERT_TRUE(first.finds(1));
  ASSERT_TRUE(second.finds(1));
  EXPECT_EQ(first.participant.others(), 1u);
  EXPECT_EQ(second.participant.others(), 1u);
  EXPECT_EQ(daemon.participant.others(), 2u);
}

TEST_F(LoopbackPorts, ProgramLooksAtTwoBusesOfADomain) {
  const FreeDomain inside;
  ParticipantOptions other = places_.here;
  other.partition = "otherbus";
  ParticipantOptions client = places_.here;
  client.serves = false;
  const Offer daemon(one_more(places_.here, inside));
  const FreeDomain more_inside;
  const Offer other_daemon(one_more(other, more_inside));
  Look look(client);
  client.partition = other.partition;
  Look other_look(client);
  EXPECT_TRUE(look.finds(1));
  EXPECT_TRUE(other_look.finds(1));
}

/// What a daemon of two buses offers on each.
class TwoBuses : public LoopbackPorts {
 protected:
  void SetUp() override {
    ParticipantOptions other = places_.here;
    other.partition = kOther;
    buses_ = participants({places_.here, other});
    for (const Participant& bus : buses_) writers_.emplace_back(bus);
  }
  static constexpr const char* kOther = "otherbus";
  std::vector<Participant> buses_;
  std::vector<Writer<gateway_Event>> writers_;
};

TEST_F(TwoBuses, AreOneParticipantThatClientsOfEitherFindAndHearOnThatBusAlone) {
  for (const std::string& bus : {places_.there.partition, std::string(kOther)}) {
    const FreeDomain inside;
    ParticipantOptions client = places_.here;
    client.serves = false;
    client.partition = bus;
    Look look(one_more(client, inside));
    ASSERT_TRUE(look.finds(1)) << bus;
    EXPECT_EQ(look.participant.others(), 1u);
    EXPECT_EQ(look.reader.matched(), 1u) << bus;
  }
  EXPECT_EQ(buses_[0].handle(), buses_[1].handle());
  EXPECT_EQ(buses_[1].options().partition, kOther);
}

TEST_F(TwoBuses, AndADaemonOfOneOfThemFindEachOther) {
  ParticipantOptions other = places_.here;
  other.partition = kOther;
  const FreeDomain inside;
  const Offer second(one_more(other, inside));
  DataSignal signal;
  Reader<gateway_Event> of_first(buses_[1], &signal);
  Reader<gateway_Event> of_second(second.participant, &signal);
  EXPECT_TRUE(eventually(signal, [&] { return of_first.matched() == 2 && of_second.matched() == 2; }));
  EXPECT_EQ(Reader<gateway_Event>(buses_[0]).matched(), 1u);
}

TEST_F(LoopbackPorts, TwoBusesWithoutOneOfThePlacesThatAreLookedAtAreFoundAllTheSame) {
  take_places("", kSharedPlacesAsked);
  Look before(places_.there);
  ParticipantOptions other = places_.here;
  other.partition = "otherbus";
  const std::vector<Participant> buses = participants({other, places_.here});
  const Writer<gateway_Event> writer(buses[1]);
  EXPECT_TRUE(before.finds(1));
}

TEST_F(LoopbackPorts, BusesOfDifferentNetworksAreParticipantsOfTheirOwn) {
  const FreeDomain elsewhere;
  ParticipantOptions other = places_.here;
  other.domain = elsewhere.get();
  const std::vector<Participant> buses = participants({places_.here, other});
  EXPECT_NE(buses[0].handle(), buses[1].handle());
  EXPECT_EQ(buses[1].options().all_partitions, std::vector{places_.here.partition});
}

}  // namespace
}  // namespace gateway::dds
