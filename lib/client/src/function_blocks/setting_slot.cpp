#include <cansync/function_blocks/setting_slot.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "client/src/link.h"
#include "client/src/settings_book.h"

namespace cansync::client::function_blocks {

SettingSlot::SettingSlot(Client& client, std::string block)
    : client_(&client), slot_(client), state_(std::make_shared<detail::SettingState>()) {
  state_->block = std::move(block);
  client.link_->settings().add(state_);
}

void SettingSlot::enter(Submit submit, std::optional<MappingBytes> reference_mapping) {
  entered_ = std::move(submit);
  slot_.enter(entered_);
  const Validity now = client_->validity();
  client_->link_->settings().change(*state_, [&](detail::SettingState& state) {
    state.entered = true;
    state.daemon = now.daemon;
    state.reference_mapping = reference_mapping;
    state.mapping_before = std::max<std::uint64_t>(now.mapping_number, 1);
  });
  note();
}

void SettingSlot::refuse(RefusalCause cause, std::string reason) {
  entered_ = nullptr;
  slot_.refuse(cause, std::move(reason));
  client_->link_->settings().change(*state_, [](detail::SettingState& state) { state.entered = true; });
  note();
}

void SettingSlot::poll() {
  const Validity now = client_->validity();
  if (entered_ && now.daemon != state_->daemon && client_->link_->asks(now.daemon)) {
    client_->link_->program_told_of(now.daemon);
    slot_.enter(entered_);
    client_->link_->settings().change(*state_, [&](detail::SettingState& state) {
      state.daemon = now.daemon;
      state.mapping_before = std::max<std::uint64_t>(now.mapping_number, 1);
    });
  }
  slot_.poll();
  note();
}

void SettingSlot::note() {
  client_->link_->settings().change(*state_, [this](detail::SettingState& state) {
    state.in_force = slot_.sent();
    state.error = slot_.error();
  });
}

std::string SettingSlot::missing(const Client& client) {
  MappingBytes mapping = {};
  const Validity known = client.link_->validity(&mapping);
  return client.link_->settings().missing(known, mapping);
}

std::optional<Validity> SettingSlot::with_own_mapping(const Client& client) {
  MappingBytes mapping = {};
  const Validity now = client.link_->validity(&mapping);
  return client.link_->settings().maps(mapping) ? std::optional(now) : std::nullopt;
}

}  // namespace cansync::client::function_blocks
