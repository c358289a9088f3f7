#include <cansync/function_blocks/setting_slot.h>

#include <algorithm>
#include <chrono>
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
  state_->before.reset();
  slot_.enter(entered_);
  const Validity now = client_->validity();
  client_->link_->settings().change(*state_, [&](detail::SettingState& state) {
    state.entered = true;
    state.daemon = now.daemon;
    state.given = std::chrono::steady_clock::now();
    state.reference_mapping = reference_mapping;
    state.mapping_before = std::max<std::uint64_t>(now.mapping_number, 1);
  });
  note();
}

void SettingSlot::refuse(RefusalCause cause, std::string reason) {
  if (entered_) state_->before = detail::SettingState::Before{slot_, entered_};
  entered_ = nullptr;
  slot_.refuse(cause, std::move(reason));
  client_->link_->settings().change(*state_, [](detail::SettingState& state) { state.entered = true; });
  note();
}

void SettingSlot::withdraw() {
  const auto before = std::exchange(state_->before, std::nullopt);
  entered_ = before ? before->submit : Submit();
  slot_ = before ? before->slot : CommandSlot(*client_);
  client_->link_->settings().change(*state_,
                                    [&](detail::SettingState& state) { state.entered = before.has_value(); });
  note();
}

bool SettingSlot::may_repeat() const {
  constexpr std::chrono::milliseconds kAgain{500};
  return !slot_.open() && std::chrono::steady_clock::now() - state_->given >= kAgain;
}

void SettingSlot::poll() {
  const Validity now = client_->validity();
  const bool anew = now.daemon != state_->daemon;
  const bool again = slot_.passes() && may_repeat();
  if (entered_ && (anew || again) && client_->link_->asks(now.daemon)) {
    if (anew) client_->link_->program_told_of(now.daemon);
    if (anew)
      slot_.enter(entered_);
    else
      slot_.repeat(entered_);
    client_->link_->settings().change(*state_, [&](detail::SettingState& state) {
      state.daemon = now.daemon;
      state.given = std::chrono::steady_clock::now();
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
