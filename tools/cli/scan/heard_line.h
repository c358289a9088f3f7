#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "can/adapter/adapter.h"
#include "can/link_facts.h"
#include "cansync/observe/census.h"
#include "cansync/settings/timing.h"
#include "cli/base/output.h"
#include "cli/learn/recording.h"

/// What listening to a line tells. Nothing here sends anything.
namespace cansync::cli {

/// How the bit rate is known.
enum class RateSource : std::uint8_t {
  unknown,
  typed,      ///< --bit-rate
  interface,  ///< the kernel has set the interface to it
  interval,   ///< telegrams stand so far apart
  tried,      ///< of the four, the one at which frames came
};

/// A line that was listened to.
struct HeardLine {
  std::string interface;               ///< that the frames stood on; of one that is listened to, in any case
  bool live = false;                   ///< it is an interface, not a recording
  can::LinkFacts link;                 ///< as it was before; of a recording nothing
  std::optional<can::AdapterPin> pin;  ///< of its adapter; nothing: nothing distinguishes it from others
  observe::Census census;
  std::optional<BitRate> bit_rate;
  RateSource rate_source = RateSource::unknown;
  std::uint64_t problems = 0;  ///< lines that were no frames
};

/// Listens to the interface for a while, or reads the recording. Throws as `read_recording`;
/// std::runtime_error for an interface that is down, with the commands that set it up.
HeardLine hear_line(Output& output, const RecordingTexts& texts);

/// Listens at each of the four bit rates, for which the interface is set, and set back afterwards. `agreed`:
/// it may be taken down although it is up; else the person is asked. Throws UsageError for a recording or a
/// virtual interface, std::runtime_error as `try_rates`. Nothing: the person said no.
std::optional<HeardLine> hear_line_at_all_rates(Output& output, const RecordingTexts& texts, bool agreed);

/// One fact about a line, for people and programs.
struct LinePoint {
  std::string name;
  std::string found;
  std::string how;
};
/// All of them, in the order they are shown.
std::vector<LinePoint> heard_points(const HeardLine& line);

/// Everything that was heard: points, slaves, foreign identifiers.
void write_heard_line(Output& output, const HeardLine& line);

/// The columns of the table of points, and what the tables below it have.
std::vector<Table::Column> line_point_columns();
std::string heard_tables_help();

/// "0x580", or with eight digits for 29 bits.
std::string identifier_text(std::uint32_t identifier, bool extended);

}  // namespace cansync::cli
