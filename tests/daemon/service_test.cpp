// What the daemon tells the service manager that started it.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <sys/un.h>

#include <cerrno>
#include <chrono>
#include <stop_token>
#include <thread>

#include "cansyncd_fixture.h"

namespace {

/// The socket a service manager listens on.
class NotifySocket {
 public:
  explicit NotifySocket(const fs::path& path) : socket_(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.string().copy(static_cast<char*>(address.sun_path), sizeof address.sun_path - 1);
    // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): the socket interface wants it so
    EXPECT_EQ(::bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    const timeval patience{60, 0};
    EXPECT_EQ(::setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience), 0);
  }
  ~NotifySocket() { ::close(socket_); }
  NotifySocket(const NotifySocket&) = delete;
  NotifySocket& operator=(const NotifySocket&) = delete;

  /// The next message; empty when none comes.
  std::string next() const {
    std::string text(4096, '\0');
    ssize_t size = 0;
    do {
      size = ::recv(socket_, text.data(), text.size(), 0);
    } while (size < 0 && errno == EINTR);  // also by a stop of this process
    text.resize(size > 0 ? static_cast<std::size_t>(size) : 0);
    return text;
  }

  /// The next message but STATUS, which comes when it has changed, and WATCHDOG, which comes with work that takes long.
  std::string next_state() const {
    while (true) {
      std::string text = next();
      if (!text.starts_with("STATUS=") && !text.starts_with("WATCHDOG=")) return text;
    }
  }

  /// True when a message that is exactly `text` comes.
  bool comes(const std::string& text) const {
    while (true) {
      const std::string message = next();
      if (message.empty() || message == text) return message == text;
    }
  }

 private:
  int socket_;
};

class ServiceTest : public CansyncdTest {
 protected:
  std::string notify_socket() const { return "NOTIFY_SOCKET=" + (folder_ / "notify").string(); }
};

TEST_F(ServiceTest, TellsItsState) {
  const NotifySocket manager(folder_ / "notify");
  Program program = run({write("line.toml", kTwoSlaves)}, {notify_socket()});
  EXPECT_EQ(manager.next_state(), "READY=1");
  program.signal(SIGHUP);
  EXPECT_TRUE(manager.next_state().starts_with("RELOADING=1\nMONOTONIC_USEC="));
  EXPECT_EQ(manager.next_state(), "READY=1");
  program.signal(SIGTERM);
  EXPECT_EQ(manager.next_state(), "STOPPING=1");
  EXPECT_EQ(program.exit_code(), 0);
}

TEST_F(ServiceTest, TellsTheStateOfTheLineInOneSentence) {
  const NotifySocket manager(folder_ / "notify");
  Program program = run({write("line.toml", kTwoSlaves)}, {notify_socket()});
  EXPECT_TRUE(manager.comes("STATUS=run: 2 of 2 slaves respond; bus two (sim) at 1000000 bit/s"));
}

TEST_F(ServiceTest, TellsTheStateOfABusOfFramesAndOfAJ1939Node) {
  const NotifySocket manager(folder_ / "notify");
  {
    Program program =
        run({write("frames.toml", "[bus]\nname = \"frames\"\nprotocol = \"layer2\"\n")}, {notify_socket()});
    EXPECT_TRUE(manager.comes("STATUS=run: general frames; bus frames (sim) at 500000 bit/s"));
  }
  Program program = run({write("node.toml",
                               "[bus]\nname = \"node\"\nprotocol = \"j1939\"\n"
                               "[address]\npreferred = 128\n")},
                        {notify_socket()});
  EXPECT_TRUE(manager.comes("STATUS=J1939: has address 128; bus node (sim) at 250000 bit/s"));
}

TEST_F(ServiceTest, NamesWhoDoesNotAnswer) {
  const NotifySocket manager(folder_ / "notify");
  const std::string file = write("line.toml", std::string("[startup]\nenable = \"any\"\n") + kTwoSlaves);
  Program program = run({file, "--set=sim.drives=[5]"}, {notify_socket()});
  EXPECT_TRUE(
      manager.comes("STATUS=run: 1 of 2 slaves respond; no answer from winder; bus two (sim) at "
                    "1000000 bit/s"));
}

TEST_F(ServiceTest, FeedsTheWatchdogThatIsAskedFor) {
  const NotifySocket manager(folder_ / "notify");
  Program program = run({write("line.toml", kTwoSlaves)}, {notify_socket(), "WATCHDOG_USEC=400000"});
  EXPECT_TRUE(manager.comes("WATCHDOG=1"));
  EXPECT_TRUE(manager.comes("WATCHDOG=1"));
  program.signal(SIGTERM);
  EXPECT_TRUE(manager.comes("STOPPING=1"));
}

TEST_F(ServiceTest, FeedsTheWatchdogHoweverOftenARecordingIsAskedFor) {
  const NotifySocket manager(folder_ / "notify");
  Program program = run({write("line.toml", kTwoSlaves)}, {notify_socket(), "WATCHDOG_USEC=2000000"});
  ASSERT_TRUE(manager.comes("READY=1"));
  const std::jthread asks([&](const std::stop_token& stop) {
    for (; !stop.stop_requested(); std::this_thread::sleep_for(std::chrono::milliseconds(50)))
      program.signal(SIGUSR1);
  });
  for (int i = 0; i < 4; ++i) EXPECT_TRUE(manager.comes("WATCHDOG=1"));
}

TEST_F(ServiceTest, FeedsNoWatchdogThatNobodyAskedFor) {
  const NotifySocket manager(folder_ / "notify");
  Program program = run({write("line.toml", kTwoSlaves)}, {notify_socket()});
  ASSERT_TRUE(program.says("to 'run'")) << program.text();
  program.signal(SIGTERM);
  for (std::string message; message != "STOPPING=1";) {
    message = manager.next();
    ASSERT_NE(message, "WATCHDOG=1");
    ASSERT_FALSE(message.empty());
  }
}

/// A pipe with a name into which nothing fits any more.
class FullPipe {
 public:
  explicit FullPipe(const std::string& path) {
    EXPECT_EQ(::mkfifo(path.c_str(), 0600), 0);
    pipe_ = ::open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
    const std::string page(4096, '-');
    while (::write(pipe_, page.data(), page.size()) > 0) {
    }
    EXPECT_EQ(::write(pipe_, "-", 1), -1);
  }
  ~FullPipe() { ::close(pipe_); }
  FullPipe(const FullPipe&) = delete;
  FullPipe& operator=(const FullPipe&) = delete;

 private:
  int pipe_ = -1;
};

TEST_F(ServiceTest, WhoDoesNotReadStandardErrorHoldsNothingUp) {
  const NotifySocket manager(folder_ / "notify");
  const std::string path = (folder_ / "errors").string();
  const FullPipe nobody_reads(path);
  Program program("/bin/sh",
                  {"-c", "exec \"$0\" \"$@\" 2>" + path, CANSYNCD, write("line.toml", kTwoSlaves),
                   "--domain=" + std::to_string(domain_.get())},
                  {notify_socket(), "WATCHDOG_USEC=2000000"});
  ASSERT_EQ(manager.next_state(), "READY=1");
  EXPECT_TRUE(manager.comes("STATUS=run: 2 of 2 slaves respond; bus two (sim) at 1000000 bit/s"));
  EXPECT_TRUE(manager.comes("WATCHDOG=1"));
  program.signal(SIGTERM);
  EXPECT_TRUE(manager.comes("STOPPING=1"));
  EXPECT_EQ(program.exit_code(), 0);
}

}  // namespace
