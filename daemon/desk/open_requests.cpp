#include "daemon/desk/open_requests.h"

#include <algorithm>
#include <iterator>
#include <memory>
#include <utility>

#include "dds/bounded_text.h"

namespace cansyncd {
namespace {

using gateway::dds::copy_text;

struct ReaderEndpointDeleter {
  void operator()(dds_builtintopic_endpoint_t* endpoint) const noexcept {
    dds_builtintopic_free_endpoint(endpoint);
  }
};
using ReaderEndpoint = std::unique_ptr<dds_builtintopic_endpoint_t, ReaderEndpointDeleter>;

gateway_OpenRequest open_row(const OpenRequest& request) {
  gateway_OpenRequest row = {};
  row.job = request.id;
  std::copy(request.key.client.begin(), request.key.client.end(), std::begin(row.client));
  row.request = request.key.request;
  std::copy(request.place.begin(), request.place.end(), std::begin(row.participant));
  copy_text(request.name, row.name);
  copy_text(request.text, row.text);
  row.time = request.time;
  row.waits = request.turn.waits;
  row.behind = request.turn.behind;
  row.done = request.done;
  row.total = static_cast<std::uint32_t>(request.total);
  return row;
}

}  // namespace

void OpenRequestsTopic::tell(const std::vector<OpenRequest>& requests, std::size_t open,
                             const ClientTable& clients, const LivingPlaces& living, SteadyTime now) {
  if (read_by_all_ != nullptr) readers_told_ = read_by_all_->matched();
  std::vector<gateway_OpenRequest> open_rows;
  open_rows.reserve(requests.size());
  std::transform(requests.begin(), requests.end(), std::back_inserter(open_rows), open_row);
  const auto all = programs(clients, living);
  std::erase_if(facts_, [&all](const auto& known) { return !all.contains(known.first); });
  std::vector<gateway_ConnectedProgram> program_rows;
  for (const auto& [place, program] : all) {
    if (program_rows.size() == kPrograms) break;
    program_rows.push_back(row(place, program));
  }
  gateway_OpenRequests sample = {};
  gateway::dds::set_daemon(daemon_, sample);
  sample.connected = static_cast<std::uint32_t>(all.size());
  sample.programs._length = sample.programs._maximum = static_cast<std::uint32_t>(program_rows.size());
  sample.programs._buffer = program_rows.data();  // lent for the call, as below
  sample.open = static_cast<std::uint32_t>(open);
  sample.requests._length = sample.requests._maximum = static_cast<std::uint32_t>(open_rows.size());
  sample.requests._buffer = open_rows.data();
  (void)writer_.write(sample);
  changed_ = false;
  told_ = now;
}

std::map<Place, OpenRequestsTopic::Program> OpenRequestsTopic::programs(const ClientTable& clients,
                                                                        const LivingPlaces& living) {
  std::map<Place, Program> all;
  for (const Place& place : living.all()) all[place];
  add_readers(all);
  clients.each([&all](const ClientEntry& client) {
    Program& program = all[client.place];
    program.open += client.open;
    if (program.name.empty()) program.name = client.name;
  });
  all.erase(Place{});
  return all;
}

void OpenRequestsTopic::add_readers(std::map<Place, Program>& programs) const {
  if (read_by_all_ == nullptr) return;
  dds_guid_t own = {};
  (void)dds_get_guid(participant_.handle(), &own);
  Place here;
  std::copy(std::begin(own.v), std::end(own.v), here.begin());
  std::vector<dds_instance_handle_t> readers(2 * kPrograms);
  const dds_return_t found =
      dds_get_matched_subscriptions(read_by_all_->handle(), readers.data(), readers.size());
  readers.resize(std::min(readers.size(), static_cast<std::size_t>(std::max(found, 0))));
  for (const dds_instance_handle_t reader : readers) {
    const ReaderEndpoint endpoint(dds_get_matched_subscription_data(read_by_all_->handle(), reader));
    if (!endpoint) continue;
    Place place;
    std::copy(std::begin(endpoint->participant_key.v), std::end(endpoint->participant_key.v), place.begin());
    // This program looks for other daemons.
    if (place != here) programs[place];
  }
}

gateway_ConnectedProgram OpenRequestsTopic::row(const Place& place, const Program& program) {
  auto known = facts_.find(place);
  if (known == facts_.end()) known = facts_.emplace(place, process_facts(participant_, place)).first;
  gateway_ConnectedProgram row = {};
  std::copy(place.begin(), place.end(), std::begin(row.participant));
  copy_text(program.name, row.name);
  copy_text(known->second.program, row.program);
  row.process = known->second.process;
  copy_text(known->second.host, row.host);
  row.open = program.open;
  return row;
}

}  // namespace cansyncd
