// Blocks of a slave: rows S23, S24, S25 and S26 of docs/cansync-slave.md. Bytes are the manual's.
#include "cansync/slave/block_area.h"

#include <gtest/gtest.h>

#include <chrono>
#include <numeric>
#include <string>
#include <vector>

#include "service_rig.h"

namespace cansync::test {
namespace {

using std::chrono::seconds;

std::vector<std::uint8_t> bytes_of(std::size_t size) {
  std::vector<std::uint8_t> bytes(size);
  std::iota(bytes.begin(), bytes.end(), std::uint8_t{1});
  return bytes;
}

class BlockService : public ServiceTest {
 protected:
  explicit BlockService(const SlaveServiceSettings& settings = service_settings()) : ServiceTest(settings) {}

  static can::Frame begin(bool download, unsigned length, std::uint32_t address = 0x100) {
    return command({static_cast<std::uint8_t>((download ? 0xD0 : 0x90) | (length >> 8)),
                    static_cast<std::uint8_t>(length & 0xFF), static_cast<std::uint8_t>(address & 0xFF),
                    static_cast<std::uint8_t>(address >> 8), 0, 0, 0, 0});
  }
  static can::Frame cancel() { return command({0x90, 0, 0, 0, 0, 0, 0, 0}); }
  static can::Frame get(unsigned offset, unsigned length) {
    const unsigned mode = offset + 6 >= length ? 0xB0 : 0xA0;
    return command(
        {static_cast<std::uint8_t>(mode | (offset >> 8)), static_cast<std::uint8_t>(offset & 0xFF)});
  }
  static can::Frame put(unsigned offset, const std::vector<std::uint8_t>& data) {
    const unsigned mode = offset + 6 >= data.size() ? 0xF0 : 0xE0;
    can::Frame frame = command({static_cast<std::uint8_t>(mode | (offset >> 8)),
                                static_cast<std::uint8_t>(offset & 0xFF), 0, 0, 0, 0, 0, 0});
    for (unsigned i = 0; i < 6; ++i)
      frame.data[2 + i] = offset + i < data.size() ? data[offset + i] : std::uint8_t{0xEE};
    return frame;
  }
  static can::Frame done(unsigned offset) {
    return response(
        {static_cast<std::uint8_t>(0x80 | (offset >> 8)), static_cast<std::uint8_t>(offset & 0xFF)});
  }
  static can::Frame later(unsigned offset) {
    return response(
        {static_cast<std::uint8_t>(0xC0 | (offset >> 8)), static_cast<std::uint8_t>(offset & 0xFF)});
  }
  static can::Frame failed(unsigned offset, std::uint16_t code) {
    return response({static_cast<std::uint8_t>(0xA0 | (offset >> 8)),
                     static_cast<std::uint8_t>(offset & 0xFF), static_cast<std::uint8_t>(code & 0xFF),
                     static_cast<std::uint8_t>(code >> 8)});
  }
  BlockArea& area() { return service_.area(); }
  std::uint64_t id() const { return told_.block.id; }

  /// A whole download through the area, up to the answer that it was taken.
  void download(const std::vector<std::uint8_t>& data) {
    const auto size = static_cast<unsigned>(data.size());
    ASSERT_EQ(send(begin(true, size)), later(0));
    ASSERT_TRUE(area().allow(id()));
    ASSERT_EQ(send(begin(true, size)), done(0));
    unsigned offset = 0;
    for (; offset + 6 < size; offset += 6) ASSERT_EQ(send(put(offset, data)), done(offset));
    ASSERT_EQ(send(put(offset, data)), later(offset));
    ASSERT_EQ(send(put(offset, data)), later(offset)) << "the application has time";
    EXPECT_EQ(area().counter(), size);
    EXPECT_EQ(std::vector<std::uint8_t>(area().data().begin(), area().data().end()), data);
    ASSERT_TRUE(area().take(id()));
    EXPECT_EQ(told_.take(), "download " + std::to_string(size) + " area, complete");
    ASSERT_EQ(send(put(offset, data)), done(offset));
    EXPECT_EQ(told_.take(), "done");
  }
};

TEST_F(BlockService, S23DownloadsOfEveryLengthThroughTheArea) {
  for (const std::size_t size : {1u, 5u, 6u, 7u, 12u, 299u, 300u}) download(bytes_of(size));
}

TEST_F(BlockService, S23UploadsOfEveryLengthThroughTheArea) {
  for (const unsigned size : {1u, 5u, 6u, 7u, 12u, 299u, 300u}) {
    const auto data = bytes_of(size);
    ASSERT_EQ(send(begin(false, size)), later(0));
    ASSERT_TRUE(area().allow(id(), data));
    ASSERT_EQ(send(begin(false, size)), done(0));
    for (unsigned offset = 0; offset < size; offset += 6) {
      const auto answer = send(get(offset, size));
      ASSERT_TRUE(answer);
      ASSERT_EQ(answer->dlc, 8);
      ASSERT_EQ(load_word(answer->data.data()), load_word(done(offset).data.data()));
      for (unsigned i = 0; i < 6; ++i)
        ASSERT_EQ(answer->data[2 + i], offset + i < size ? data[offset + i] : 0);
    }
    EXPECT_EQ(area().counter(), size);
    EXPECT_EQ(told_.take(), "upload " + std::to_string(size) + " area, done");
  }
}

TEST_F(BlockService, S23AnUploadHasTheLengthOfItsData) {
  ASSERT_EQ(send(begin(false, 300)), later(0));
  EXPECT_FALSE(area().allow(id())) << "the data must lie in the area first";
  EXPECT_FALSE(area().allow(id(), bytes_of(301)));
  EXPECT_TRUE(area().allow(id(), bytes_of(8)));
  EXPECT_EQ(send(begin(false, 300)), done(8));
  EXPECT_EQ(send(get(0, 8)), response({0x80, 0, 1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(send(get(6, 8)), response({0x80, 6, 7, 8, 0, 0, 0, 0}));
  EXPECT_EQ(told_.take(), "upload 300 area, done");
}

TEST_F(BlockService, S23TheApplicationMayRefuseAtEveryPoint) {
  const auto data = bytes_of(12);
  send(begin(true, 12));
  EXPECT_TRUE(area().refuse(id(), TransferError::address_not_allowed));
  EXPECT_EQ(send(begin(true, 12)), failed(0, 0x0105));
  EXPECT_EQ(told_.take(), "download 12 area, refused");

  send(begin(true, 12));
  area().allow(id());
  send(begin(true, 12));
  EXPECT_TRUE(area().refuse(id(), TransferError::cancelled_by_slave));
  EXPECT_FALSE(area().take(id()));
  EXPECT_EQ(send(put(0, data)), failed(0, 0x0103));
  EXPECT_FALSE(slave_.transfer_open());
  EXPECT_EQ(told_.take(), "download 12 area, refused");

  send(begin(true, 12));
  area().allow(id());
  send(begin(true, 12));
  send(put(0, data));
  send(put(6, data));
  EXPECT_TRUE(area().refuse(id(), static_cast<TransferError>(0x0042))) << "the module's own numbers";
  EXPECT_EQ(send(put(6, data)), failed(6, 0x0104));
  EXPECT_EQ(told_.take(), "download 12 area, complete, refused");
  EXPECT_EQ(send(cancel()), done(0));
  EXPECT_EQ(told_.take(), "");
}

TEST_F(BlockService, S25CancelAtEveryPointEndsItOnce) {
  const auto data = bytes_of(12);
  for (int point = 0; point < 4; ++point) {
    send(begin(true, 12));
    if (point > 0) {
      area().allow(id());
      send(begin(true, 12));
    }
    if (point > 1) send(put(0, data));
    if (point > 2) send(put(6, data));
    told_.take();
    EXPECT_EQ(send(cancel()), done(0)) << point;
    EXPECT_EQ(told_.take(), "cancelled") << point;
    EXPECT_FALSE(area().allow(id()));
    EXPECT_FALSE(area().take(id()));
    EXPECT_FALSE(area().refuse(id(), TransferError::not_possible));
  }
}

TEST_F(BlockService, S25AnotherBlockReplacesTheOneThatIsOpen) {
  send(begin(true, 12));
  const std::uint64_t old = id();
  EXPECT_EQ(send(begin(false, 6)), later(0));
  EXPECT_EQ(told_.take(), "download 12 area, cancelled, upload 6 area");
  EXPECT_FALSE(area().allow(old));
  EXPECT_TRUE(area().allow(id(), bytes_of(6)));
  EXPECT_EQ(send(begin(false, 6)), done(0));
}

TEST_F(BlockService, S25ALostAnswerAtEveryPointIsGivenAgain) {
  const auto data = bytes_of(8);
  send(begin(true, 8));
  area().allow(id());
  for (const can::Frame& telegram : {begin(true, 8), put(0, data)}) {
    const auto lost = send(telegram, false);
    EXPECT_EQ(send(telegram), lost);
  }
  send(put(6, data));
  area().take(id());
  EXPECT_EQ(send(put(6, data), false), done(6));
  EXPECT_EQ(told_.take(), "download 8 area, complete") << "it was not on the bus";
  EXPECT_EQ(send(put(6, data)), done(6));
  EXPECT_EQ(told_.take(), "done");
}

TEST_F(BlockService, S25ALastAnswerThatNobodyAskedForAgainEndsWithTheNextBlock) {
  const auto data = bytes_of(6);
  send(begin(true, 6));
  area().allow(id());
  send(begin(true, 6));
  send(put(0, data));
  area().take(id());
  send(put(0, data), false);
  told_.take();
  send(begin(true, 7));
  EXPECT_EQ(told_.take(), "done, download 7 area");
}

/// A download whose last answer was left out.
TEST_F(BlockService, S25WhatTheMasterDoesNotWaitForIsNotDone) {
  const auto data = bytes_of(6);
  const auto up_to_the_last_answer = [&] {
    send(begin(true, 6));
    area().allow(id());
    send(begin(true, 6));
    send(put(0, data));
    area().take(id());
    send(put(0, data), false);
    told_.take();
  };
  up_to_the_last_answer();
  EXPECT_EQ(send(cancel()), done(0));
  EXPECT_EQ(told_.take(), "cancelled");
  EXPECT_EQ(send(cancel()), done(0));
  EXPECT_EQ(told_.take(), "") << "once";

  up_to_the_last_answer();
  EXPECT_EQ(send(put(6, data)), failed(6, 0x0108)) << "another telegram than its last";
  EXPECT_EQ(told_.take(), "cancelled");

  area().at(seconds(100));
  up_to_the_last_answer();
  area().at(seconds(131));
  EXPECT_EQ(told_.take(), "timed out");
  EXPECT_EQ(send(begin(true, 6)), later(0)) << "nothing stands in the way of the next";
  send(cancel());

  up_to_the_last_answer();
  EXPECT_TRUE(slave_.control(ControlCommand::cold_restart));
  EXPECT_EQ(told_.take(), "cancelled");
}

TEST_F(BlockService, S23NothingMovesForTheMonitoringTime) {
  area().at(seconds(100));
  send(begin(true, 12));
  area().at(seconds(130));
  EXPECT_EQ(told_.take(), "download 12 area");
  area().at(seconds(130) + std::chrono::milliseconds(1));
  EXPECT_EQ(told_.take(), "timed out");
  EXPECT_EQ(send(begin(true, 12)), failed(0, 0x0103));
  EXPECT_EQ(send(begin(true, 12)), later(0)) << "begun anew";
  area().allow(id());
  send(begin(true, 12));
  area().at(seconds(150));
  send(put(0, bytes_of(12)));
  area().at(seconds(180));
  told_.take();
  area().at(seconds(181));
  EXPECT_EQ(told_.take(), "timed out");
  EXPECT_EQ(send(put(6, bytes_of(12))), failed(6, 0x0103));
  EXPECT_FALSE(slave_.transfer_open());
}

TEST_F(BlockService, S23TheSameBeginningIsNotAllowedOnceMoreWhenItsBlockIsOver) {
  for (const bool dies : {false, true}) {
    const seconds start(dies ? 300 : 100);
    area().at(start);
    send(begin(true, 12));
    area().allow(id());
    EXPECT_EQ(send(begin(true, 12)), done(0));
    EXPECT_EQ(send(begin(true, 12)), done(0)) << "its answer was lost";
    told_.take();
    if (dies) {
      service_.set_application(false);
      service_.set_application(true);
    } else {
      area().at(start + seconds(31));
    }
    EXPECT_EQ(told_.take(), dies ? "application gone" : "timed out");
    EXPECT_EQ(send(begin(true, 12)), failed(0, 0x0103));
    EXPECT_EQ(send(begin(true, 12)), later(0)) << "begun anew";
    EXPECT_EQ(told_.take(), "download 12 area");
    send(cancel());
    told_.take();
  }
}

TEST_F(BlockService, S23AnUploadThatIsRefusedAfterItsBeginningGivesNoOldData) {
  send(begin(false, 6));
  area().allow(id(), bytes_of(6));
  send(begin(false, 6));
  EXPECT_TRUE(area().refuse(id(), TransferError::address_not_allowed));
  EXPECT_EQ(send(begin(false, 6)), failed(0, 0x0105));
  EXPECT_EQ(send(get(0, 6)), failed(0, 0x0108));
  EXPECT_EQ(send(begin(false, 6)), later(0));
  EXPECT_EQ(told_.take(), "upload 6 area, refused, upload 6 area");
}

TEST_F(BlockService, S26WithoutAnApplicationAndWhenItDies) {
  service_.set_application(false);
  EXPECT_EQ(send(begin(true, 12)), failed(0, 0x0104));
  service_.set_application(true);
  send(begin(true, 12));
  service_.set_application(false);
  EXPECT_EQ(told_.take(), "download 12 area, application gone");
  EXPECT_EQ(send(begin(true, 12)), failed(0, 0x0103));
  service_.set_application(true);
  EXPECT_EQ(send(begin(true, 12)), later(0));
}

TEST_F(BlockService, S26TheSlavesOwnErrors) {
  EXPECT_EQ(send(begin(true, 6, 0xFF)), failed(0, 0x0105)) << "the operating system's";
  EXPECT_EQ(send(command({0xD0, 6, 0, 1, 0, 0, 1, 0})), failed(0, 0x0104)) << "sub-slave 1";
  EXPECT_EQ(send(command({0xD0, 6, 0, 1, 0, 0, 0xFF, 0xFF})), failed(0, 0x0104));
  EXPECT_EQ(send(put(0, bytes_of(6))), failed(0, 0x0108));
  EXPECT_EQ(told_.take(), "");
  send(begin(true, 18));
  area().allow(id());
  send(begin(true, 18));
  EXPECT_EQ(send(put(6, bytes_of(18))), failed(0, 0x0100)) << "block 0 is expected";
  EXPECT_EQ(send(command({0xF0, 0, 1, 2, 3, 4, 5, 6})), failed(0, 0x0102));
}

// --- telegram by telegram

TEST_F(BlockService, S24BlocksOver300BytesGoTelegramByTelegram) {
  for (const unsigned size : {301u, 4092u}) {
    const auto data = bytes_of(size);
    ASSERT_EQ(send(begin(true, size)), later(0));
    ASSERT_FALSE(told_.block.area);
    ASSERT_TRUE(area().allow(id()));
    ASSERT_EQ(send(begin(true, size)), done(0));
    std::vector<std::uint8_t> taken;
    for (unsigned offset = 0; offset < size; offset += 6) {
      ASSERT_EQ(send(put(offset, data)), later(offset));
      ASSERT_EQ(send(put(offset, data)), later(offset));
      ASSERT_EQ(told_.step.offset, offset);
      taken.insert(taken.end(), told_.step.data.begin(), told_.step.data.begin() + told_.step.bytes);
      ASSERT_FALSE(area().take(id())) << "there is no area";
      ASSERT_TRUE(area().step(id()));
      ASSERT_FALSE(area().step(id()));
      ASSERT_EQ(send(put(offset, data)), done(offset));
    }
    EXPECT_EQ(taken, data);
    EXPECT_EQ(area().counter(), size);
    const std::string notes = told_.take();
    EXPECT_EQ(notes.substr(notes.rfind(',') + 2), "done");
  }
}

class SingleService : public BlockService {
 protected:
  static SlaveServiceSettings settings() {
    SlaveServiceSettings result = service_settings();
    result.area.area = false;
    return result;
  }
  SingleService() : BlockService(settings()) {}
};

TEST_F(SingleService, S24ShortBlocksToo) {
  ASSERT_EQ(send(begin(false, 8)), later(0));
  EXPECT_TRUE(area().allow(id(), {}, 7));
  EXPECT_EQ(send(begin(false, 8)), done(7));
  EXPECT_EQ(send(get(0, 7)), later(0));
  EXPECT_FALSE(area().step(id(), bytes_of(5))) << "as many bytes as were asked for";
  EXPECT_TRUE(area().step(id(), bytes_of(6)));
  EXPECT_EQ(send(get(0, 7)), response({0x80, 0, 1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(send(get(6, 7)), later(6));
  EXPECT_TRUE(area().step(id(), bytes_of(1)));
  EXPECT_EQ(send(get(6, 7)), response({0x80, 6, 1, 0, 0, 0, 0, 0}));
  EXPECT_EQ(told_.take(), "upload 8 single, step 0+6, step 6+1, done");
}

TEST_F(SingleService, S24AnErrorInTheMiddleAndACancel) {
  send(begin(true, 12));
  area().allow(id());
  send(begin(true, 12));
  send(put(0, bytes_of(12)));
  EXPECT_TRUE(area().refuse(id(), TransferError::cancelled_by_slave));
  EXPECT_EQ(send(put(0, bytes_of(12))), failed(0, 0x0103));
  EXPECT_EQ(told_.take(), "download 12 single, step 0+6, refused");
  send(begin(true, 12));
  area().allow(id());
  send(begin(true, 12));
  send(put(0, bytes_of(12)));
  send(cancel());
  EXPECT_FALSE(area().step(id()));
  EXPECT_EQ(told_.take(), "download 12 single, step 0+6, cancelled");
}

}  // namespace
}  // namespace cansync::test
