// plc-run with what a service manager gives it: sockets that listen already, and the folder of a plant.
#include <arpa/inet.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <string>
#include <thread>
#include <vector>

#include "tests/support/modbus_client.h"
#include "tests/tools/fixture.h"

namespace plc::test {
namespace {

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

const char* const kPlant =
    "PROGRAM Main VAR n : DINT; END_VAR n := n + 1; END_PROGRAM\n"
    "CONFIGURATION C RESOURCE R ON PLC TASK T(INTERVAL := T#10ms, PRIORITY := 0); PROGRAM main WITH T : Main; "
    "END_RESOURCE END_CONFIGURATION\n";

/// A TCP socket on a free port of 127.0.0.1.
class Socket {
 public:
  explicit Socket(bool listens = true) : fd_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(::bind(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    socklen_t size = sizeof address;
    EXPECT_EQ(::getsockname(fd_, reinterpret_cast<sockaddr*>(&address), &size), 0);
    port_ = ntohs(address.sin_port);
    if (listens) {
      EXPECT_EQ(::listen(fd_, 16), 0);
    }
  }
  ~Socket() { ::close(fd_); }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;
  [[nodiscard]] int fd() const { return fd_; }
  [[nodiscard]] std::uint16_t port() const { return port_; }
  [[nodiscard]] std::string text() const { return "127.0.0.1:" + std::to_string(port_); }

 private:
  int fd_;
  std::uint16_t port_ = 0;
};

/// plc-run as a service manager starts it with these descriptors: from 3 on, LISTEN_FDS and LISTEN_PID.
class Activated {
 public:
  Activated(const std::vector<int>& passed, std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), PLC_RUN_TOOL);
    std::vector<char*> argv;
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    pid_ = ::fork();
    if (pid_ != 0) return;
    const int out = ::open(output_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_APPEND, 0600);
    ::dup2(out, STDOUT_FILENO);
    ::dup2(out, STDERR_FILENO);
    // First out of the way of the numbers that they get.
    std::vector<int> high;
    for (const int fd : passed) high.push_back(::fcntl(fd, F_DUPFD_CLOEXEC, 100));
    for (std::size_t i = 0; i < high.size(); ++i) ::dup2(high[i], 3 + static_cast<int>(i));
    ::setenv("LISTEN_FDS", std::to_string(passed.size()).c_str(), 1);
    ::setenv("LISTEN_PID", std::to_string(::getpid()).c_str(), 1);
    ::alarm(60);
    ::execv(argv[0], argv.data());
    ::_exit(99);
  }
  ~Activated() {
    if (pid_ > 0) ::kill(pid_, SIGKILL), ::waitpid(pid_, nullptr, 0);
  }
  Activated(const Activated&) = delete;
  Activated& operator=(const Activated&) = delete;

  /// Its exit code, after SIGTERM.
  int stop() {
    ::kill(pid_, SIGTERM);
    int status = 0;
    ::waitpid(pid_, &status, 0);
    pid_ = 0;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  }
  [[nodiscard]] std::string said() const { return read_text(output_); }
  [[nodiscard]] bool says(const std::string& text) const {
    for (int i = 0; i < 1500 && !contains(said(), text); ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    return contains(said(), text);
  }

 private:
  ScratchFolder scratch_;
  std::string output_ = scratch_.file("output");
  pid_t pid_ = 0;
};

class PassedSocket : public testing::Test {
 protected:
  PassedSocket() { write_text(plant, kPlant); }
  ScratchFolder scratch;
  std::string plant = scratch.file("plant.st");
};

TEST_F(PassedSocket, IsServed) {
  const Socket socket;
  Activated run({socket.fd()}, {plant, "--engineering", "off"});
  EXPECT_TRUE(run.says("modbus: listening on " + socket.text())) << run.said();
  ModbusClient client(socket.port());
  EXPECT_TRUE(client.ask(pdu_of(4, {8192, 1})).is_normal());
  EXPECT_EQ(run.stop(), 0) << run.said();
}

TEST_F(PassedSocket, CountsBeforeTheAddressOfTheConfiguration) {
  const Socket socket;
  const std::string toml = scratch.file("plc.toml");
  write_text(toml, "[modbus]\nlisten = \"127.0.0.1:1\"\n");
  Activated run({socket.fd()}, {plant, "--config", toml, "--engineering", "off"});
  EXPECT_TRUE(run.says("the socket " + socket.text() + " that the service manager opened counts, not 127.0.0.1:1"))
      << run.said();
  EXPECT_TRUE(ModbusClient(socket.port()).ask(pdu_of(4, {8192, 1})).is_normal());
  EXPECT_EQ(run.stop(), 0) << run.said();
}

TEST_F(PassedSocket, IsNotServedWhenModbusIsOff) {
  const Socket socket;
  Activated run({socket.fd()}, {plant, "--modbus", "off", "--engineering", "off"});
  EXPECT_TRUE(run.says("modbus: off, and nobody serves the socket " + socket.text())) << run.said();
  EXPECT_EQ(run.stop(), 0);
}

TEST_F(PassedSocket, IsTheOnlyOneAndListens) {
  const Socket first, second, silent(/*listens=*/false);
  Activated run({silent.fd(), first.fd(), second.fd()}, {plant, "--engineering", "off"});
  EXPECT_TRUE(run.says("descriptor 3 that systemd passed is no TCP socket that listens")) << run.said();
  EXPECT_TRUE(run.says("the socket " + second.text() + " that systemd passed is not served: one is, " + first.text()));
  EXPECT_TRUE(run.says("modbus: listening on " + first.text())) << run.said();
  EXPECT_EQ(run.stop(), 0);
}

class PlantFolder : public testing::Test {
 protected:
  [[nodiscard]] ToolResult run(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> words = {PLC_RUN_TOOL,    "--plant", scratch.file(""), "--cycles", "3",
                                      "--engineering", "off"};
    words.insert(words.end(), more.begin(), more.end());
    return run_tool(words);
  }
  void put(const std::string& name, const std::string& text) const { write_text(scratch.file(name), text); }
  ScratchFolder scratch;
};

TEST_F(PlantFolder, IsItsOneProject) {
  put("plant.st", kPlant);
  put("plant_test.st", "TEST \"t\" END_TEST");
  put(".plant.st.swp.st", "");
  put("stimulus.csv", "");
  const ToolResult result = run({"--modbus", "off"});
  EXPECT_EQ(result.code, 0) << result.all();
  EXPECT_TRUE(contains(result.out, "plant.st with 1 task")) << result.out;
}

TEST_F(PlantFolder, IsConfiguredByItsPlcToml) {
  put("plant.st", kPlant);
  put("plc.toml", "[modbus]\nlisten = \"off\"\n");
  EXPECT_TRUE(contains(run().out, "modbus: off")) << run().all();
  put("plc.toml", "[modbus]\nlisten = 7\n");
  const ToolResult wrong = run();
  EXPECT_EQ(wrong.code, 1);
  EXPECT_TRUE(contains(wrong.err, "plc.toml:2:")) << wrong.err;
}

TEST_F(PlantFolder, WithoutAProjectIsNotRun) {
  put("plc.toml", "");
  put("plant_test.st", "TEST \"t\" END_TEST");
  const ToolResult result = run();
  EXPECT_EQ(result.code, 2);
  EXPECT_TRUE(contains(result.err, "holds no project")) << result.err;
}

TEST_F(PlantFolder, WithSeveralProjectsIsNotRun) {
  put("plant.st", kPlant);
  put("older.xml", small_project());
  const ToolResult result = run();
  EXPECT_EQ(result.code, 2);
  EXPECT_TRUE(contains(result.err, "holds 2 projects: older.xml, plant.st")) << result.err;
}

TEST_F(PlantFolder, ThatIsNotThereIsSaid) {
  const ToolResult result = run_tool({PLC_RUN_TOOL, "--plant", scratch.file("nowhere")});
  EXPECT_EQ(result.code, 2);
  EXPECT_TRUE(contains(result.err, "cannot be read: No such file or directory")) << result.err;
}

TEST_F(PlantFolder, GoesWithNoOtherFileOrConfiguration) {
  put("plant.st", kPlant);
  EXPECT_EQ(run({scratch.file("plant.st")}).code, 2);
  EXPECT_EQ(run({"--config", scratch.file("plc.toml")}).code, 2);
}

}  // namespace
}  // namespace plc::test
