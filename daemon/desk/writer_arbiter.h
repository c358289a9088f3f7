#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "dds/writer_identity.h"

namespace cansyncd {

/// Names a writer while it is matched; 0: none. Nothing follows from its value.
using WriterHandle = std::uint64_t;
/// The key that a writer has chosen for its samples; all 0: it shares that with others who chose none.
using WriterKey = std::array<std::uint8_t, 16>;

/// A writer of a topic that one writer has at a time.
struct TopicWriter {
  WriterHandle handle = 0;
  WriterKey key = {};
  gateway::dds::WriterIdentity identity = {};
};

/// Decides which of several writers has what one writer alone can have.
///
/// A writer keeps what it has until it gives it up, is lost, or a stronger one comes. One of the same or less
/// strength waits meanwhile: nothing of it is taken, and when the owner has gone the first whose own next
/// sample comes is the owner. Neither handles nor GUIDs decide anything.
///
/// Knows neither DDS nor a clock. Not thread safe.
class WriterArbiter {
 public:
  /// So many writers that wait are known; those beyond wait just the same, without being named.
  static constexpr std::size_t kMostWaiting = 16;

  /// `what`: for texts, e.g. "the reference values of telegram 1".
  explicit WriterArbiter(std::string what) : what_(std::move(what)) {}

  /// What a sample of a writer is.
  enum class Claim : std::uint8_t {
    keeps,       ///< the owner's
    begins,      ///< there is no owner
    takes_over,  ///< it is stronger than the owner
    waits,       ///< it is not: the sample must not be taken
  };
  /// Changes nothing. `strength` is not looked at for the owner.
  Claim claim(WriterHandle writer, std::int32_t strength) const noexcept;

  /// The writer is the owner from now on.
  void give(TopicWriter writer);
  /// There is no owner any more.
  void free() noexcept { owner_ = {}; }
  /// A sample of the writer, which waits, was refused. What is to be told of it on the change; else empty.
  std::string refuse(const TopicWriter& writer);

  /// A writer gives up or has gone; that of the owner is for `free`.
  void forget(WriterHandle writer);
  /// Nobody who waits writes under the key any more.
  void forget_key(const WriterKey& key);
  /// Forgets those who wait of whom `gone` says so.
  void forget_if(const std::function<bool(WriterHandle)>& gone);

  /// The owner; handle 0: none.
  const TopicWriter& owner() const noexcept { return owner_; }
  /// Who waits longest; empty: nobody.
  std::string_view waiting() const noexcept;
  /// Samples of writers that wait, since the start.
  std::uint64_t refused() const noexcept { return refused_; }
  /// Why the last of them was refused; empty: none was.
  const std::string& refused_reason() const noexcept { return reason_; }

 private:
  const std::string what_;
  TopicWriter owner_;
  std::vector<TopicWriter> waiting_;
  bool more_wait_ = false;  ///< than are known, and that was told
  std::uint64_t refused_ = 0;
  std::string reason_;
  WriterHandle reason_of_ = 0;  ///< the owner whom it names
};

}  // namespace cansyncd
