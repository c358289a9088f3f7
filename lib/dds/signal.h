#pragma once

namespace gateway::dds {

/// An eventfd that readers raise when data arrives: wait with poll() on `fd()`, `clear()`, then take from
/// every reader (in this order, or a sample may be overlooked). Any number of readers may share one; it must
/// outlive them. `raise` and `clear` may be called from any thread and never block.
class DataSignal {
 public:
  /// Throws SetupError when the process has no file descriptor left.
  DataSignal();
  ~DataSignal();
  DataSignal(const DataSignal&) = delete;
  DataSignal& operator=(const DataSignal&) = delete;

  int fd() const noexcept { return fd_; }
  void raise() noexcept;
  void clear() noexcept;

  /// Waits until it is raised, at most `milliseconds`; true when it was raised. Does not clear.
  bool wait(int milliseconds) noexcept;

 private:
  int fd_ = -1;
};

}  // namespace gateway::dds
