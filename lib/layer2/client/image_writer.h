#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "dds/daemon_identity.h"
#include "dds/endpoint.h"
#include "layer2/client/frame_client.h"

namespace layer2::client {

/// Writes the process image that is sent, as its owner: there is one at a time, until it gives the image up, is
/// lost, or a stronger one comes. When it has gone, the daemon does what mapping.writer_lost says. One thread.
///
/// Each sample repeats what was written before, so that one which overtakes another loses nothing.
class ImageWriter {
 public:
  /// For the daemon that `client` sees now, whose next start takes nothing, until `take_up`. `strength`: 0
  /// and more, or gateway::dds::kTakeOver. `client` must outlive the writer. Throws gateway::dds::SetupError.
  ImageWriter(FrameClient& client, std::int32_t strength);
  /// Gives the image up.
  ~ImageWriter();
  ImageWriter(const ImageWriter&) = delete;
  ImageWriter& operator=(const ImageWriter&) = delete;

  /// Writes bytes from `address` (0..1023) on, at most 1024 together; between two telegrams all of them are
  /// in the image or none. Bytes that this writer has not written are 0, those between two that it has, too. Returns what failed; empty: they were handed to DDS. While another writer owns the
  /// image that is no weaker, nothing is written. What the daemon refuses is its event `image_refused`.
  std::string write(std::uint16_t address, std::span<const std::uint8_t> bytes);
  /// The image is nobody's from now on, until a writer gives bytes.
  void give_up();

  /// A daemon reads what is written: `write` does not wait.
  bool matched() const noexcept { return writer_.matched() != 0; }
  /// The daemon was started anew: nothing that is written is taken.
  bool daemon_restarted() const noexcept;
  /// From now on what is written is for the daemon that is there now.
  void take_up() noexcept;

 private:
  std::string put(layer2_ImageOutputs& sample);

  FrameClient& client_;
  const std::int32_t strength_;
  gateway::dds::Writer<layer2_ImageOutputs> writer_;
  gateway::dds::DaemonIdentity daemon_ = {};
  std::array<std::uint8_t, sizeof(layer2_ProcessImage::outputs)> image_ = {};
  std::size_t begin_ =
      0;  ///< of the bytes of `image_` that were written since this writer began, or gave it up
  std::size_t end_ = 0;  ///< behind the last of them; as `begin_`: none
};

/// Says whether the module is to run, when its run and stop follow this program (module.run_follows has its
/// name): until this object is destroyed, or the program dies, which both are stop. One thread.
class RunLead {
 public:
  /// As ImageWriter; the name is `client_name`.
  RunLead(FrameClient& client, std::string_view client_name, std::int32_t strength);
  /// Stop.
  ~RunLead();
  RunLead(const RunLead&) = delete;
  RunLead& operator=(const RunLead&) = delete;

  /// The module is to run, or to stop. For the daemon that the client sees now: after another start it is to
  /// be said again. Returns what failed; empty: it was handed to DDS. While another program of that name
  /// leads that is no weaker, nothing is said.
  std::string say(bool run);

 private:
  FrameClient& client_;
  const std::string name_;
  const std::int32_t strength_;
  gateway::dds::Writer<layer2_RunLead> writer_;
};

}  // namespace layer2::client
