#pragma once

#include <cansync/client.h>
#include <cansync/function_blocks.h>
#include <cansync/topics.h>
#include <gtest/gtest.h>

#include <chrono>
#include <string>
#include <thread>

#include "client/fake_daemon.h"
#include "client/function_blocks/block_cycle.h"
#include "daemon/whole/whole_rig.h"
#include "support/dds_places.h"

/// Function blocks against the gateway with simulated drives, or against a daemon without a bus.
namespace cansync::client::function_blocks {

/// Four simulated drives in active operation behind a real gateway. The line's time stands still unless a
/// test lets it go on, so that a job stays open for as long as the test wants.
class BlockTest : public ::testing::Test {
 protected:
  /// Lets the line's time go on, and calls the block in between, until `condition` holds.
  template <class Block, class Condition>
  bool run_until(Block& block, Condition&& condition) {
    return repeat_until(
        [&] {
          rig.run(2);
          cycle(block, now);
        },
        condition);
  }
  /// x_EN = TRUE until the job has ended, then FALSE.
  template <class Block>
  void do_job(Block& block) {
    block.x_EN = true;
    cycle(block, now);
    EXPECT_TRUE(run_until(block, [&] { return !block.x_BUSY; }));
    block.x_EN = false;
    cycle(block, now);
  }
  /// x_EN = TRUE for one cycle, and on until the command has gone out.
  template <class Block>
  void send(Block& block) {
    block.x_EN = true;
    cycle(block, now);
    block.x_EN = false;
    EXPECT_TRUE(run_until(block, [&] { return block.x_OK || !block.error().empty(); }));
  }
  /// A parameter of a simulated drive, read by a function block.
  UDINT parameter(SINT slave, UINT number, BOOL doubleword) {
    PAR_READ_MA read(client);
    read.si_SL_NR = slave;
    read.u_PAR_NR = number;
    read.x_PAR_FORMAT = doubleword;
    do_job(read);
    EXPECT_TRUE(read.x_OK) << read.error();
    return read.ud_PAR_VALUE;
  }

  cansyncd::WholeRig rig;
  Client client = Client::connect(options_at(rig.client_place()));
  Clock::time_point now = Clock::now();
};

/// A daemon that only takes down what it is told.
class CommandTest : public ::testing::Test {
 protected:
  /// Calls the block until the daemon has taken so many commands; the last of them.
  template <class Block>
  cansync_Command command(Block& block, std::size_t count) {
    EXPECT_TRUE(repeat_until(
        [&] {
          cycle(block, now);
          std::this_thread::yield();
        },
        [&] { return daemon.commands().size() >= count; }));
    const auto commands = daemon.commands();
    return commands.size() < count ? cansync_Command{} : commands[count - 1];
  }

  TwoPlaces places;
  FakeDaemon daemon{places.here};
  Client client = Client::connect(options_at(places.there));
  Clock::time_point now = Clock::now();
};

}  // namespace cansync::client::function_blocks
