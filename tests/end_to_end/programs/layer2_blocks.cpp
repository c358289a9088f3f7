// PLC programs on a bus of general frames: every function block of a CAN 300 PRO (FC 65 to 67) and of a Saia
// PCD (SFB 400 to 404, 410 to 413), called once a cycle against a real daemon. It writes a line for each
// thing that has happened, once, and ends well when all of them have. Usage: layer2_blocks DOMAIN BUS SECONDS
#include <cansync/function_blocks/layer2/can_status.h>
#include <cansync/layer2_function_blocks.h>

#include <array>
#include <chrono>
#include <cstdio>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "block_program.h"

namespace {

using namespace cansync::client;
using namespace cansync::client::function_blocks;

class Programme {
 public:
  explicit Programme(FrameConnection& connection)
      : connection_(connection),
        send_(connection),
        receive_(connection),
        control_(connection),
        configure_(connection),
        state_(connection),
        objects_(connection),
        object_send_(connection),
        object_receive_(connection),
        queues_(connection),
        queue_send_(connection),
        queue_receive_(connection),
        mapping_(connection) {
    connection_.on_interrupt(
        40, [this](const Interrupt& one) { interrupts_.insert(one.parameter * 100 + one.object); });
    const std::vector<CanObjCfgDef> objects = {
        {.ObjID = 1, .MsgID = 0x101, .Dir = true, .EnableInt = true},
        {.ObjID = 2, .MsgID = 0x123, .Mask = 0x7FF, .EnableInt = true},  // node 0 answers its remote frame
        {.ObjID = 3, .MsgID = 0x250, .Mask = 0x7FF}};                    // node 2 sends it all the time
    connection_.load_data_block(1, data_block(objects));
    connection_.load_data_block(2, data_block(std::vector<CanIOEntry>{
                                       {.MsgID = 0x310, .VA = 10, .Size = 2},  // node 3 sends it all the time
                                       {.MsgID = 0x410, .VA = 20, .Size = 2, .IO = true}}));
    object_send_.TxData = bytes_;
    queue_send_.TxData = bytes_;
    object_receive_.RxData = target_;
    queue_receive_.RxData = queue_target_;
  }

  /// One cycle; the steps of set-up come one after the other, the rest with each call.
  void cycle() {
    if (!set_up()) return;
    state_.call();
    happened(state_.RetVal == 0 && !state_.BusOff && !state_.ErrorState, "CAN_STAT error active");
    direct_access();
    basic_services();
    data_mapping();
    module();
  }

  bool complete() const { return happened_.size() == kAll; }
  std::string errors() const {
    return failure_ + " " + unwritten_ + " " + configure_.error() + " " + objects_.error() + " " +
           object_send_.error() + " " + object_receive_.error() + " " + queues_.error() + " " +
           queue_send_.error() + " " + mapping_.error() + " " + send_.error() + " " + control_.error();
  }

 private:
  static constexpr std::size_t kAll = 18;
  static constexpr WORD kSendQueuesEmpty = 0x0010;  ///< STAT

  bool set_up() {
    if (happened_.count("CAN_DMAP") != 0) return true;
    configure_.Baudrate = 500'000;
    configure_.RxIntOB = configure_.TxIntOB = 40;
    configure_.RxIntPrm = 1;
    configure_.TxIntPrm = 2;
    configure_.call();
    if (configure_.RetVal != can_status::done) return false;
    objects_.DBNr = 1;
    objects_.NbObj = 3;
    objects_.call();
    queues_.RxQueueDepth = queues_.TxQueueDepth = 50;
    queues_.MsgID = 0x180;
    queues_.Mask = 0x780;
    queues_.TxIntOB = 40;
    queues_.TxIntPrm = 3;
    queues_.TxEnableInt = true;
    queues_.call();
    mapping_.DBNr = 2;
    mapping_.NbEntries = 2;
    mapping_.TxTime = 10;
    mapping_.MsgID = 0x310;
    mapping_.Mask = 0x7F0;
    mapping_.call();
    happened(objects_.RetVal == 0, "CAN_CFGO");
    happened(queues_.RetVal == 0, "CAN_CFGQ");
    happened(mapping_.RetVal == 0, "CAN_DMAP");
    return false;
  }

  void direct_access() {
    object_send_.ObjID = 1;
    object_send_.MsgID = 0x102;
    object_send_.DLC = 3;
    object_send_.Act = true;
    object_send_.call();
    if (object_send_.Error) failure_ = "CAN_TX: " + object_send_.error();
    happened(object_send_.Done, "CAN_TX done");
    // Object 2 asks for the frame of node 0, then object 3 takes what comes by itself.
    const bool answered = happened_.count("CAN_RX remote request") != 0;
    object_receive_.ObjID = answered ? 3 : 2;
    object_receive_.RTR = !answered;
    object_receive_.ReleaseRx = answered || !asked_;
    asked_ = true;
    object_receive_.call();
    happened(object_receive_.NDR && object_receive_.MsgID == 0x123 && target_[2] == 0xFF,
             "CAN_RX remote request");
    if (object_receive_.NDR && object_receive_.MsgID == 0x250 && ++frames_ == 3)
      happened(true, "CAN_RX three frames");
    happened(interrupts_.count(102) != 0 && interrupts_.count(201) != 0, "routines of both directions");
  }

  void basic_services() {
    queue_send_.MsgID = 0x105;
    queue_send_.DLC = 1;
    if (happened_.count("CAN_TXQ entered") == 0) {
      queue_send_.call();
      happened(queue_send_.Status == can_status::done, "CAN_TXQ entered");
    }
    happened(interrupts_.count(331) != 0, "CAN_TXQ sent");
    queue_receive_.call();
    happened(queue_receive_.NDR && queue_receive_.MsgID == 0x190, "CAN_RXQ");
  }

  void data_mapping() {
    if (happened_.count("outputs written") == 0) {
      unwritten_ = connection_.write_outputs(20, std::array<std::uint8_t, 2>{0xAB, 0xCD});
      happened(unwritten_.empty(), "outputs written");
    }
    happened(connection_.inputs()[11] == 0x77, "inputs of CAN_DMAP");
    happened(mapping_.open() == 0 && mapping_.error().empty(), "CAN_DMAP taken over");
  }

  void module() {
    send_.IDLO = 0x106;
    send_.RTRLEN = 2;
    send_.DW0 = 0x0102;
    send_.Snd = happened_.count("CANSEND taken") == 0;
    const bool wanted = send_.Snd;
    send_.call();
    happened(wanted && send_.RETVAL == 0 && !send_.Snd, "CANSEND taken");
    happened(!wanted && (send_.STAT & kSendQueuesEmpty) != 0 && send_.failures() == 0, "CANSEND sent");
    receive_.call();
    happened(receive_.Rcvd && receive_.IDLO == 0x190 && receive_.RTRLEN == 1, "CANRCV");
    if (happened_.count("CANCTRL timer") == 0 && control_.open() == 0) {
      if (controlled_) return happened(control_.RETVAL == 0 && control_.error().empty(), "CANCTRL timer");
      control_.Func = 1;
      control_.Param = 3;
      control_.call();
      controlled_ = true;
    }
  }

  void happened(bool now, const char* what) {
    if (now && happened_.insert(what).second) std::printf("%s\n", what), std::fflush(stdout);
  }

  FrameConnection& connection_;
  CANSEND send_;
  CANRCV receive_;
  CANCTRL control_;
  CAN_CFG configure_;
  CAN_STAT state_;
  CAN_CFGO objects_;
  CAN_TX object_send_;
  CAN_RX object_receive_;
  CAN_CFGQ queues_;
  CAN_TXQ queue_send_;
  CAN_RXQ queue_receive_;
  CAN_DMAP mapping_;
  std::array<BYTE, 3> bytes_ = {0x11, 0x22, 0x33};
  std::array<BYTE, 8> target_ = {};
  std::array<BYTE, 8> queue_target_ = {};
  std::set<int> interrupts_;
  std::set<std::string> happened_;
  int frames_ = 0;
  bool asked_ = false;
  std::string failure_;
  std::string unwritten_;
  bool controlled_ = false;
};

int run(const Options& options, Clock::time_point end) {
  FrameConnection connection = FrameConnection::connect(options);
  Programme programme(connection);
  return run_cycles(programme, end);
}

}  // namespace

int main(int argc, char** argv) {
  return run_program(argc, argv, "layer2 blocks", run);
}
