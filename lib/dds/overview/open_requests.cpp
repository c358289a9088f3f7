#include "dds/overview/open_requests.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "dds/bounded_text.h"
#include "dds/process_facts.h"

namespace gateway::dds {

const std::optional<OpenRequestsNow>& OpenRequestsReader::look() {
  reader_.take([this](const gateway_OpenRequests& sample) {
    const auto& programs = sample.programs;
    const auto& requests = sample.requests;
    newest_ = OpenRequestsNow{daemon_of(sample),
                              sample.connected,
                              {programs._buffer, programs._buffer + programs._length},
                              sample.open,
                              {requests._buffer, requests._buffer + requests._length}};
  });
  return newest_;
}

std::string owner_of(const OpenRequestsNow& now, const gateway_OpenRequest& request) {
  const auto same = [&request](const gateway_ConnectedProgram& program) {
    return std::equal(std::begin(program.participant), std::end(program.participant),
                      std::begin(request.participant));
  };
  const auto found = std::find_if(now.programs.begin(), now.programs.end(), same);
  std::string process;
  if (found != now.programs.end())
    process = text_of(
        ProcessFacts{std::string(text(found->program)), found->process, std::string(text(found->host))});
  if (process.empty()) return fmt::format("'{}'", text(request.name));
  return fmt::format("'{}' ({})", text(request.name), process);
}

std::string waited_for(const OpenRequestsNow& now, const gateway_OpenRequest& request) {
  if (!request.waits || request.behind == 0) return "";
  const auto is_it = [&request](const gateway_OpenRequest& one) { return one.job == request.behind; };
  const auto found = std::find_if(now.requests.begin(), now.requests.end(), is_it);
  if (found == now.requests.end()) return fmt::format("job {}", request.behind);
  std::string what = fmt::format("job {}, {} of {}", found->job, text(found->text), owner_of(now, *found));
  if (found->total != 0)
    what += fmt::format(", which is at {} %", std::uint64_t{100} * found->done / found->total);
  return what;
}

}  // namespace gateway::dds
