#include <fmt/format.h>

#include <algorithm>

#include "client/client.h"
#include "client/link.h"
#include "client/set_up.h"

namespace cansync::client {

struct ReferenceWriter::Impl {
  Impl(std::shared_ptr<detail::Link> to, std::int32_t strength)
      : link(std::move(to)), writer(link->participant(), strength, &matched, link->name()) {}

  std::shared_ptr<detail::Link> link;  // keeps the participant
  dds::DataSignal matched;
  dds::Writer<cansync_ReferenceValues> writer;
};

ReferenceWriter::ReferenceWriter(Client& client, std::int32_t strength)
    : impl_(detail::set_up([&] { return std::make_unique<Impl>(client.link_, strength); })) {
  if (!impl_->writer.permitted())
    throw SetupError(impl_->link->not_permitted(dds::topic_info<cansync_ReferenceValues>().name));
  constexpr std::chrono::seconds kWait(2);
  const auto end = std::chrono::steady_clock::now() + kWait;
  while (impl_->writer.matched() == 0) {
    const auto left =
        std::chrono::duration_cast<std::chrono::milliseconds>(end - std::chrono::steady_clock::now());
    if (left.count() <= 0) {
      throw NoDaemon(
          fmt::format("no daemon takes reference values: looked for {} s on {}; is cansyncd running?",
                      kWait.count(), impl_->link->participant().place()));
    }
    (void)impl_->matched.wait(static_cast<int>(left.count()));
    impl_->matched.clear();
  }
}

ReferenceWriter::~ReferenceWriter() = default;
ReferenceWriter::ReferenceWriter(ReferenceWriter&&) noexcept = default;
ReferenceWriter& ReferenceWriter::operator=(ReferenceWriter&&) noexcept = default;

std::string ReferenceWriter::write(std::uint8_t telegram, const std::array<std::int32_t, 4>& value,
                                   std::uint8_t valid, std::uint32_t release_intervals,
                                   std::uint64_t from_interval) {
  if (impl_->writer.matched() == 0) {
    return fmt::format("no daemon takes reference values ({}); is cansyncd running?",
                       impl_->link->participant().place());
  }
  cansync_ReferenceValues sample = {};
  sample.telegram = telegram;
  std::copy(value.begin(), value.end(), std::begin(sample.value));
  sample.valid = valid;
  sample.from_interval = from_interval;
  sample.release_intervals = release_intervals;
  const dds_return_t code = impl_->writer.write(sample);
  if (code == DDS_RETCODE_OK) return "";
  return fmt::format("the reference values could not be written: {}; try again", dds_strretcode(code));
}

void ReferenceWriter::release(std::uint8_t telegram) {
  cansync_ReferenceValues key = {};
  key.telegram = telegram;
  (void)impl_->writer.unregister(key);
}

}  // namespace cansync::client
