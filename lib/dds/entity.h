#pragma once

#include <dds/dds.h>

#include <memory>
#include <stdexcept>
#include <string>
#include <utility>

/// RAII over the Cyclone DDS C API. Nothing here may be called on the realtime thread.
namespace gateway::dds {

/// Something could not be set up. `what()` names what failed, domain, partition, interface and a remedy.
class SetupError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Owns one Cyclone DDS entity and deletes it, with everything below it, at the end of its life. Move only.
/// Deleting waits until a listener call in progress has returned.
class Entity {
 public:
  Entity() = default;
  /// Takes ownership of a handle over 0.
  explicit Entity(dds_entity_t handle) noexcept : handle_(handle) {}
  Entity(Entity&& other) noexcept : handle_(std::exchange(other.handle_, 0)) {}
  Entity& operator=(Entity&& other) noexcept {
    if (this != &other) {
      reset();
      handle_ = std::exchange(other.handle_, 0);
    }
    return *this;
  }
  Entity(const Entity&) = delete;
  Entity& operator=(const Entity&) = delete;
  ~Entity() { reset(); }

  dds_entity_t get() const noexcept { return handle_; }
  explicit operator bool() const noexcept { return handle_ > 0; }

  /// Deletes the entity now.
  void reset() noexcept {
    if (handle_ > 0) (void)dds_delete(handle_);
    handle_ = 0;
  }

 private:
  dds_entity_t handle_ = 0;
};

struct ListenerDeleter {
  void operator()(dds_listener_t* listener) const noexcept { dds_delete_listener(listener); }
};
/// What is called when something happens to an entity.
using Listener = std::unique_ptr<dds_listener_t, ListenerDeleter>;

}  // namespace gateway::dds
