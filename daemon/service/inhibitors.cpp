#include "daemon/service/inhibitors.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <pthread.h>
#include <systemd/sd-bus.h>
#include <systemd/sd-daemon.h>

#include <cerrno>
#include <cstdint>
#include <system_error>
#include <utility>

namespace cansyncd {
namespace {

using std::chrono::milliseconds;

constexpr const char* kService = "org.freedesktop.login1";
constexpr const char* kObject = "/org/freedesktop/login1";
constexpr const char* kManager = "org.freedesktop.login1.Manager";
constexpr std::uint64_t kPatience = 5'000'000;  // us, for one answer of logind

struct BusCloser {
  void operator()(sd_bus* bus) const noexcept { sd_bus_flush_close_unref(bus); }
};
struct MessageCloser {
  void operator()(sd_bus_message* message) const noexcept { sd_bus_message_unref(message); }
};
using Message = std::unique_ptr<sd_bus_message, MessageCloser>;

class BusLogind final : public Logind {
 public:
  std::string inhibit(std::string_view what, std::string_view mode, sys::Descriptor& lock) override {
    if (const int failed = connect(); failed < 0) return reason("no D-Bus", failed);
    sd_bus_message* raw = nullptr;
    int result = sd_bus_message_new_method_call(bus_.get(), &raw, kService, kObject, kManager, "Inhibit");
    const Message call(raw);
    if (result >= 0)
      result = sd_bus_message_append(call.get(), "ssss", std::string(what).c_str(), "cansyncd",
                                     "the line is in run", std::string(mode).c_str());
    if (result < 0) return reason("Inhibit", result);
    sd_bus_error error = {};
    sd_bus_message* answer = nullptr;
    result = sd_bus_call(bus_.get(), call.get(), kPatience, &error, &answer);
    const Message reply(answer);
    const std::string refused = error.message != nullptr ? error.message : "";
    sd_bus_error_free(&error);
    if (result < 0) return refused.empty() ? reason("Inhibit", result) : refused;
    int descriptor = -1;
    result = sd_bus_message_read(reply.get(), "h", &descriptor);
    if (result < 0) return reason("Inhibit", result);
    lock.reset(fcntl(descriptor, F_DUPFD_CLOEXEC, 3));  // the message closes its own
    return lock.is_open() ? "" : reason("Inhibit", -errno);
  }

  bool shuts_down_within(milliseconds time) override {
    if (bus_ == nullptr) {
      std::this_thread::sleep_for(time);
      return false;
    }
    int result = sd_bus_wait(bus_.get(), static_cast<std::uint64_t>(time.count()) * 1000);
    while (result >= 0 && (result = sd_bus_process(bus_.get(), nullptr)) > 0) {
    }
    if (result < 0 && result != -EINTR) bus_.reset();  // the locks do not need the connection
    return std::exchange(shuts_down_, false);
  }

 private:
  static std::string reason(std::string_view what, int error) {
    return fmt::format("{}: {}", what, std::generic_category().message(-error));
  }

  /// Below 0: an error number.
  int connect() {
    if (bus_ != nullptr) return 0;
    sd_bus* bus = nullptr;
    int result = sd_bus_open_system(&bus);
    if (result < 0) return result;
    bus_.reset(bus);
    result = sd_bus_match_signal_async(bus, nullptr, kService, kObject, kManager, "PrepareForShutdown",
                                       prepare_for_shutdown, nullptr, this);
    if (result < 0) bus_.reset();
    return result;
  }

  static int prepare_for_shutdown(sd_bus_message* message, void* self, sd_bus_error* /*error*/) noexcept {
    int begins = 0;
    if (sd_bus_message_read(message, "b", &begins) >= 0 && begins != 0)
      static_cast<BusLogind*>(self)->shuts_down_ = true;
    return 0;
  }

  std::unique_ptr<sd_bus, BusCloser> bus_;
  bool shuts_down_ = false;
};

}  // namespace

std::unique_ptr<Logind> make_logind() {
  if (sd_booted() <= 0) return nullptr;
  return std::make_unique<BusLogind>();
}

InhibitorState InhibitorLocks::step(bool in_run, std::chrono::steady_clock::time_point now) {
  if (!in_run) {
    block_.reset();
    delay_.reset();
    retry_ = {};
    return state_ = {};
  }
  if (state_.held || now < retry_) return state_;
  retry_ = now + kRetry;
  state_.refused.clear();
  // Two locks: a computer that may not be kept awake is still to wait for the line when it shuts down.
  if (!block_.is_open())
    state_.refused = logind_.inhibit(
        "sleep:idle:handle-power-key:handle-suspend-key:handle-hibernate-key:handle-lid-switch", "block",
        block_);
  if (!delay_.is_open()) {
    const std::string refused = logind_.inhibit("shutdown", "delay", delay_);
    if (state_.refused.empty()) state_.refused = refused;
  }
  state_.held = block_.is_open() && delay_.is_open();
  return state_;
}

Inhibitors::Inhibitors(std::unique_ptr<Logind> logind, std::function<void()> shuts_down)
    : logind_(std::move(logind)), shuts_down_(std::move(shuts_down)) {
  if (logind_ != nullptr) thread_ = std::thread([this] { run(); });
}

Inhibitors::~Inhibitors() {
  stop_.store(true, std::memory_order_relaxed);
  if (thread_.joinable()) thread_.join();
}

InhibitorState Inhibitors::state() const {
  const std::lock_guard lock(mutex_);
  return state_;
}

void Inhibitors::run() {
  constexpr milliseconds kStep{250};
  pthread_setname_np(pthread_self(), "cansync-logind");
  InhibitorLocks locks(*logind_);
  while (!stop_.load(std::memory_order_relaxed)) {
    const bool in_run = in_run_.load(std::memory_order_relaxed);
    const InhibitorState state = locks.step(in_run, std::chrono::steady_clock::now());
    {
      const std::lock_guard lock(mutex_);
      state_ = state;
    }
    if (logind_->shuts_down_within(kStep) && in_run) shuts_down_();
  }
}

}  // namespace cansyncd
