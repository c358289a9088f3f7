// A PLC program behind a slave: all nine function blocks of a slave and INIT, called once a cycle against a
// real daemon. It writes a line for each thing that has happened, once, and ends well when all of them have.
// The order of the programme is that of the manual (M 3.1.2): INIT, PD_CFG_SL, PD_CFG_READ_SL, MODE_SL.
// Usage: slave_blocks DOMAIN BUS SECONDS
#include <cansync/function_blocks.h>
#include <cansync/slave_connection.h>

#include <chrono>
#include <cstdio>
#include <set>
#include <string>

#include "block_program.h"

namespace {

using namespace cansync::client;
using namespace cansync::client::function_blocks;

class Programme {
 public:
  explicit Programme(SlaveConnection& connection)
      : mode_(connection),
        mapping_(connection),
        other_(connection),
        values_(connection),
        one_(connection),
        broadcast_(connection),
        control_(connection),
        parameters_(connection, {400}),
        blocks_(connection) {
    mapping_.a_WRC1 = {0, 0, 1, 1};
    mapping_.a_HL_WRC1 = {false, true, false, true};
    mapping_.a_WRC2 = {4, 4, 5, 5};
    mapping_.a_HL_WRC2 = {false, true, false, true};
    mapping_.a_RDC1 = {0, 0, -1, -1};
    mapping_.a_HL_RDC1 = {false, true, false, false};
    mapping_.a_RDC2 = {4, -1, -1, -1};
    other_.si_SL_NR = one_.si_SL_NR = 7;
    other_.a_RDC1 = {0, 0, -1, -1};
    other_.a_HL_RDC1 = {false, true, false, false};
    for (std::size_t i = 0; i < 10; ++i) blocks_.a_UPLOAD[i] = static_cast<DINT>(0x01010101 * (i + 1));
    parameters_.x_EN = blocks_.x_EN = true;
  }

  void cycle() {
    mapping_.call();
    happened(mapping_.in_effect(), "PD_CFG_SL in effect");
    other_.call();
    happened(other_.in_effect(), "PD_CFG_READ_SL in effect");
    set_mode();
    values_.a_RD_VALUES_SEND[0] = 0x00112233;
    values_.si_RDC1_SEND = mode_.x_CANsync_ACTIV ? 5 : 0;
    values_.call();
    happened(values_.si_WRC1_RECEIVED == 1 && values_.a_WR_VALUES_RECEIVED[0] == 1000, "PD_COMM_SL WRC1");
    happened(values_.si_WRC2_RECEIVED == 2 && values_.a_WR_VALUES_RECEIVED[4] == 4000, "PD_COMM_SL WRC2");
    one_.call();
    if (one_.si_RD_SL_NR1_RECEIVED != 0) std::printf("PD_COMM_READ_SL heard what nobody sends\n");
    control_.call();
    happened(control_.si_RECEIVED == 2 && control_.w_CONTROLWORD == 0x000F, "CONTROLWORD_SL 0x000F");
    broadcast_.call();
    happened(broadcast_.si_BC_RECEIVED == 2 && broadcast_.us_BC_CMD_NR == 200 && broadcast_.i_BC_WORD == 77,
             "BC_SL 200 77");
    answer();
    blocks_.call();
    happened(blocks_.x_OK && blocks_.x_UPDOWN && blocks_.u_TRANSFERRED == 10 &&
                 blocks_.a_DOWNLOAD[1] == 0x07060504,
             "UPDOWNLOAD_SL download");
    happened(blocks_.x_OK && !blocks_.x_UPDOWN && blocks_.u_TRANSFERRED == 10, "UPDOWNLOAD_SL upload");
  }

  bool complete() const { return happened_.size() == kAll; }
  std::string errors() const {
    return mode_.error() + " " + mapping_.error() + " " + other_.error() + " " + values_.error() + " " +
           parameters_.error() + " " + blocks_.error();
  }

 private:
  static constexpr std::size_t kAll = 14;

  /// The daemon waits for its start; then the slave is restarted by program and started again.
  void set_mode() {
    mode_.call();
    happened(mode_.x_WAIT, "MODE_SL waits");
    mode_.x_SYNC_MODE = true;
    mode_.x_CANsync_RUN = true;
    if (mode_.x_CANsync_ACTIV) happened(true, restarted_ ? "MODE_SL active again" : "MODE_SL active");
    mode_.x_RESET_SOFTWARE = mode_.x_CANsync_ACTIV && happened_.count("PD_COMM_SL WRC2") != 0 && !restarted_;
    if (!mode_.x_RESET_SOFTWARE) return;
    mode_.call();
    restarted_ = true;
    // Both are to rise once more.
    mode_.x_SYNC_MODE = mode_.x_CANsync_RUN = mode_.x_RESET_SOFTWARE = false;
    mode_.call();
  }

  void answer() {
    parameters_.x_OK_IN = parameters_.x_ACTIV;
    parameters_.ud_PAR_VALUE_READ = 0x55;
    happened(parameters_.x_WRITE && parameters_.ud_PAR_VALUE_WRITE == 99, "PAR_SL write 99");
    happened(parameters_.x_READ && parameters_.u_PAR_NR == 400, "PAR_SL read");
    happened(parameters_.x_OK, "PAR_SL answered");
    parameters_.call();
  }

  void happened(bool now, const char* what) {
    if (now && happened_.insert(what).second) std::printf("%s\n", what), std::fflush(stdout);
  }

  MODE_SL mode_;
  PD_CFG_SL mapping_;
  PD_CFG_READ_SL other_;
  PD_COMM_SL values_;
  PD_COMM_READ_SL one_;
  BC_SL broadcast_;
  CONTROLWORD_SL control_;
  PAR_SL parameters_;
  UPDOWNLOAD_SL blocks_;
  bool restarted_ = false;
  std::set<std::string> happened_;
};

int run(const Options& options, Clock::time_point end) {
  INIT init(options);
  init.x_SL = true;
  init.us_BAUDRATE = 4;
  while (!init.x_OK && !init.x_ERR && Clock::now() < end) init.call();
  if (!init.x_OK) return std::fprintf(stderr, "INIT: %s\n", init.error().c_str()), 1;
  Programme programme(init.slave());
  return run_cycles(programme, end);
}

}  // namespace

int main(int argc, char** argv) {
  return run_program(argc, argv, "slave blocks", run);
}
