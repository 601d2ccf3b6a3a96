// The server on a socket: framing, connections and what hostile clients do. Names begin with the attack they answer,
// where there is one.
#include <gtest/gtest.h>
#include <pthread.h>
#include <sched.h>
#include <sys/resource.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <random>
#include <thread>

#include "runtime/sched/realtime.h"
#include "runtime/sched/thread_settings.h"
#include "tests/support/modbus_oracle.h"
#include "tests/unit/modbus/plant.h"

namespace plc::test {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

const Pdu kRead = pdu_of(3, {kWords, 1});

/// Waits until `done`, at most `limit`.
template <class Done>
bool eventually(Done done, std::chrono::milliseconds limit = 15'000ms) {
  const auto end = Clock::now() + limit;
  while (!done()) {
    if (Clock::now() > end) return false;
    std::this_thread::sleep_for(2ms);
  }
  return true;
}

std::size_t open_descriptors() {
  const std::filesystem::directory_iterator all("/proc/self/fd");
  return static_cast<std::size_t>(std::distance(begin(all), end(all)));
}

/// Lets this process have `count` descriptors; false when it may not.
bool allow_descriptors(rlim_t count) {
  rlimit limit{};
  ::getrlimit(RLIMIT_NOFILE, &limit);
  if (limit.rlim_cur >= count) return true;
  limit.rlim_cur = count;
  limit.rlim_max = std::max(limit.rlim_max, count);
  return ::setrlimit(RLIMIT_NOFILE, &limit) == 0;
}

io::ModbusConfig clients(std::uint32_t most) {
  io::ModbusConfig config;
  config.max_clients = most;
  return config;
}

io::ModbusConfig timeouts(core::TimeNs frame_ns, core::TimeNs idle_ns = 0) {
  io::ModbusConfig config;
  config.frame_timeout_ns = frame_ns;
  config.idle_timeout_ns = idle_ns;
  return config;
}

/// Sends on a connection of its own until told to stop; counts what comes back.
class Flood {
 public:
  Flood(const PlantServer& plant, const Pdu& pdu, unsigned pipelined)
      : thread_([this, &plant, pdu, pipelined] {
          Pdu burst;
          for (unsigned i = 0; i < pipelined; ++i) {
            const Pdu frame = frame_of(pdu, i);
            burst.insert(burst.end(), frame.begin(), frame.end());
          }
          while (!stop_) {
            ModbusClient client = plant.client();
            while (!stop_ && client.send(burst)) {
              unsigned answered = 0;
              while (answered < pipelined && client.receive(1000).kind == Answer::Kind::kFrame) ++answered;
              answers_ += answered;
              if (answered < pipelined) break;
            }
          }
        }) {}
  ~Flood() {
    stop_ = true;
    thread_.join();
  }
  [[nodiscard]] std::uint64_t answers() const { return answers_; }

 private:
  std::atomic<bool> stop_{false};
  std::atomic<std::uint64_t> answers_{0};
  std::thread thread_;
};

TEST(ModbusWire, A1LengthField) {
  PlantServer plant;
  for (const std::uint32_t length : {0u, 1u, 255u, 256u, 261u, 1000u, 0x7fffu, 65535u}) {
    ModbusClient client = plant.client();
    client.send(frame_of(kRead, 1, 1, 0, length));
    EXPECT_TRUE(client.receive().is_closed()) << length;
  }
  EXPECT_EQ(plant.server.statistics().dropped, 8u);
  // Shorter than the function needs: an exception, and what follows is taken as the next frame, which it is not.
  for (const std::uint32_t length : {2u, 3u, 5u}) {
    ModbusClient client = plant.client();
    client.send(frame_of(kRead, 1, 1, 0, length));
    EXPECT_EQ(client.receive().exception(), 3) << length;
  }
  // Longer: nothing until the rest comes, then an exception for the length.
  ModbusClient client = plant.client();
  client.send(frame_of(kRead, 1, 1, 0, 254));
  EXPECT_TRUE(client.receive(100).is_timeout());
  client.send(Pdu(254 - 6));
  EXPECT_EQ(client.receive().exception(), 3);
  EXPECT_TRUE(client.ask(kRead).is_normal());
}

TEST(ModbusWire, A2ProtocolId) {
  PlantServer plant;
  for (const std::uint32_t protocol : {1u, 0x100u, 0xffffu}) {
    ModbusClient client = plant.client();
    client.send(frame_of(kRead, 1, 1, protocol));
    EXPECT_TRUE(client.receive().is_closed()) << protocol;
  }
  // What was asked before the broken frame is answered.
  ModbusClient client = plant.client();
  Pdu both = frame_of(kRead, 5);
  const Pdu broken = frame_of(kRead, 6, 1, 1);
  both.insert(both.end(), broken.begin(), broken.end());
  client.send(both);
  EXPECT_EQ(client.receive().transaction, 5u);
  EXPECT_TRUE(client.receive().is_closed());
}

TEST(ModbusWire, A3SlowLoris) {
  // A frame has two seconds and is sent in a quarter of one: a machine that stands still for a while fails nothing.
  PlantServer plant(timeouts(2'000'000'000));
  ModbusClient half_header = plant.client(), half_frame = plant.client(), silent = plant.client(),
               slow = plant.client();
  const Pdu frame = frame_of(kRead, 3);
  half_header.send({frame.begin(), frame.begin() + 4});
  half_frame.send({frame.begin(), frame.begin() + 9});
  for (const std::uint8_t byte : frame) {
    slow.send({byte});
    std::this_thread::sleep_for(20ms);
    EXPECT_TRUE(plant.serves());
  }
  EXPECT_TRUE(slow.receive().is_normal()) << "slow, but within the time a frame has";
  EXPECT_TRUE(half_header.receive(10'000).is_closed());
  EXPECT_TRUE(half_frame.receive(10'000).is_closed());
  EXPECT_TRUE(silent.ask(kRead).is_normal()) << "a connection without a frame may be silent";
  EXPECT_EQ(plant.server.statistics().dropped, 2u);
  // One byte now and then does not buy more time.
  ModbusClient drip = plant.client();
  std::size_t sent = 0;
  while (sent + 1 < frame.size() && drip.receive(500).is_timeout()) drip.send({frame[sent++]});
  EXPECT_LT(sent + 1, frame.size()) << "still connected after five seconds";
}

TEST(ModbusWire, A3IdleConnectionsAreClosedOnlyWhenAsked) {
  PlantServer plant(timeouts(5'000'000'000, 1'500'000'000));
  ModbusClient busy = plant.client(), idle = plant.client();
  for (int i = 0; i < 10; ++i) {
    EXPECT_TRUE(busy.ask(kRead).is_normal());
    std::this_thread::sleep_for(200ms);
  }
  EXPECT_TRUE(idle.receive(10'000).is_closed());
  EXPECT_TRUE(busy.ask(kRead).is_normal());
}

TEST(ModbusWire, A4SegmentsAndFrames) {
  PlantServer plant;
  ModbusClient client = plant.client();
  Pdu three;
  for (std::uint32_t i = 1; i <= 3; ++i) {
    const Pdu frame = frame_of(i == 2 ? pdu_of(1, {0, 9}) : kRead, i);
    three.insert(three.end(), frame.begin(), frame.end());
  }
  for (std::size_t cut = 0; cut <= three.size(); ++cut) {
    client.send({three.begin(), three.begin() + static_cast<std::ptrdiff_t>(cut)});
    if (cut % 7 == 0) std::this_thread::sleep_for(1ms);
    client.send({three.begin() + static_cast<std::ptrdiff_t>(cut), three.end()});
    for (std::uint32_t i = 1; i <= 3; ++i) {
      const Answer answer = client.receive();
      ASSERT_TRUE(answer.is_normal()) << "cut at " << cut;
      ASSERT_EQ(answer.transaction, i);
    }
  }
  // More than a turn's requests in one go, answered all and in order, also to a client that will send no more.
  Pdu many;
  for (std::uint32_t i = 0; i < 1000; ++i) {
    const Pdu frame = frame_of(pdu_of(3, {kWords, 100}), i);
    many.insert(many.end(), frame.begin(), frame.end());
  }
  std::thread sender([&] {
    client.send(many);
    client.finish_sending();
  });
  for (std::uint32_t i = 0; i < 1000; ++i) {
    const Answer answer = client.receive();
    EXPECT_TRUE(answer.is_normal());
    EXPECT_EQ(answer.transaction, i);
    if (!answer.is_normal()) break;
  }
  sender.join();
  EXPECT_TRUE(client.receive().is_closed());
}

TEST(ModbusWire, A4HalfAFrameAndTheEnd) {
  PlantServer plant;
  const Pdu frame = frame_of(kRead);
  for (std::size_t size = 1; size < frame.size(); ++size) {
    ModbusClient client = plant.client();
    client.send({frame.begin(), frame.begin() + static_cast<std::ptrdiff_t>(size)});
    client.finish_sending();
    EXPECT_TRUE(client.receive().is_closed()) << size;
  }
  EXPECT_TRUE(eventually([&] { return plant.server.statistics().clients == 0; }));
}

TEST(ModbusWire, A5ThousandIdleConnections) {
  if (!allow_descriptors(3000)) GTEST_SKIP() << "this process may not have 3000 descriptors";
  PlantServer plant(clients(64));
  ModbusClient old_hand = plant.client();
  EXPECT_TRUE(old_hand.ask(kRead).is_normal());
  std::vector<ModbusClient> idle;
  for (int i = 0; i < 1000; ++i) idle.push_back(plant.client());
  EXPECT_TRUE(plant.serves()) << "who never asked anything gives way";
  EXPECT_TRUE(old_hand.ask(kRead).is_normal()) << "who did keeps its connection";
  EXPECT_LE(plant.server.statistics().clients, 64u);
  ASSERT_EQ(open_descriptors() > 1000, true) << "the thousand are there";
  idle.clear();
  EXPECT_TRUE(eventually([&] { return plant.server.statistics().clients <= 2; }));
}

TEST(ModbusWire, A5ConnectionsInUseLeaveRoomForOtherAddresses) {
  if (!allow_descriptors(3000)) GTEST_SKIP() << "this process may not have 3000 descriptors";
  PlantServer plant(clients(64));
  std::vector<ModbusClient> greedy;
  for (int i = 0; i < 200; ++i) {
    greedy.push_back(plant.client(2));
    (void)greedy.back().ask(kRead, 1, 1, 1000);
  }
  EXPECT_EQ(plant.server.statistics().clients, 56u);
  EXPECT_GE(plant.server.statistics().refused, 144u);
  for (std::uint8_t from = 3; from < 11; ++from) {
    greedy.push_back(plant.client(from));
    EXPECT_TRUE(greedy.back().ask(kRead).is_normal()) << int{from};
  }
  ModbusClient one_too_many = plant.client(11);
  EXPECT_TRUE(one_too_many.ask(kRead).is_closed());
}

TEST(ModbusWire, A5ConnectionsOfOneAddress) {
  io::ModbusConfig config = clients(64);
  config.max_clients_per_address = 3;
  PlantServer plant(config);
  std::vector<ModbusClient> first, second;
  for (int i = 0; i < 3; ++i) {
    first.push_back(plant.client(2));
    EXPECT_TRUE(first.back().ask(kRead).is_normal());
    second.push_back(plant.client(3));
    EXPECT_TRUE(second.back().ask(kRead).is_normal());
  }
  ModbusClient fourth = plant.client(2);
  EXPECT_TRUE(fourth.ask(kRead).is_closed());
  first.pop_back();
  EXPECT_TRUE(eventually([&] { return plant.client(2).ask(kRead).is_normal(); }));
}

TEST(ModbusWire, A6ConnectAndReset) {
  PlantServer plant;
  const std::size_t before = open_descriptors();
  const Pdu frame = frame_of(kRead);
  for (int i = 0; i < 10'000; ++i) {
    ModbusClient client = plant.client();
    ASSERT_TRUE(client.connected()) << i;
    if (i % 3 == 1) client.send(frame);
    if (i % 3 == 2) client.send({frame.begin(), frame.begin() + 5});
    client.reset();
  }
  EXPECT_TRUE(plant.serves());
  EXPECT_TRUE(eventually([&] { return plant.server.statistics().clients == 0; }));
  EXPECT_EQ(open_descriptors(), before);
}

TEST(ModbusWire, A6WithoutDescriptorsItWaitsWithoutSpinning) {
  PlantServer plant;
  ModbusClient early = plant.client();
  EXPECT_TRUE(early.ask(kRead).is_normal());
  rlimit limit{};
  ::getrlimit(RLIMIT_NOFILE, &limit);
  ModbusClient late = plant.client();
  EXPECT_TRUE(late.ask(kRead).is_normal());
  {
    const rlimit none{open_descriptors(), limit.rlim_max};
    std::vector<ModbusClient> waiting;
    // Sockets of our own first: the limit is on new descriptors of either side.
    std::vector<int> sockets;
    for (int i = 0; i < 3; ++i) sockets.push_back(::socket(AF_INET, SOCK_STREAM, 0));
    ::setrlimit(RLIMIT_NOFILE, &none);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(plant.server.port());
    for (const int fd : sockets) ::connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address);
    rusage start{}, end{};
    ::getrusage(RUSAGE_SELF, &start);
    std::this_thread::sleep_for(500ms);
    EXPECT_TRUE(early.ask(kRead).is_normal());
    ::getrusage(RUSAGE_SELF, &end);
    const auto us = [](const rusage& r) {
      return (r.ru_utime.tv_sec + r.ru_stime.tv_sec) * 1'000'000 + r.ru_utime.tv_usec + r.ru_stime.tv_usec;
    };
    EXPECT_LT(us(end) - us(start), 200'000) << "half a second of trying again and again";
    ::setrlimit(RLIMIT_NOFILE, &limit);
    for (const int fd : sockets) ::close(fd);
  }
  EXPECT_TRUE(plant.serves());
}

TEST(ModbusWire, A7StartAndStopUnderLoad) {
  PlantServer plant;
  plant.plant.config.port = plant.server.port();  // the same each time
  const std::size_t before = open_descriptors();
  {
    Flood one(plant, kRead, 10), two(plant, write_registers(kWords, {1, 2, 3}), 3);
    for (int i = 0; i < 1000; ++i) {
      plant.server.stop();
      EXPECT_EQ(plant.server.statistics().clients, 0u);
      const auto problem = plant.server.start();
      ASSERT_FALSE(problem) << i << ": " << problem->message;
      if (i % 50 == 0) {
        EXPECT_TRUE(plant.serves()) << i;
      }
    }
    EXPECT_TRUE(eventually([&] { return one.answers() > 0 && two.answers() > 0; }));
  }
  EXPECT_TRUE(eventually([&] { return open_descriptors() == before; }));
  plant.server.stop();
  plant.server.stop();
  EXPECT_FALSE(plant.client().connected());
}

TEST(ModbusWire, A7ATakenPort) {
  PlantServer plant;
  io::ModbusConfig config;
  config.port = plant.server.port();
  Plant second(config);
  modbus::Server server(*second.resource, second.map, second.config);
  const auto problem = server.start();
  ASSERT_TRUE(problem);
  EXPECT_EQ(problem->code, core::Code::P7510);
  second.config.address = "not an address";
  EXPECT_TRUE(server.start());
  second.config.address = "127.0.0.1";
  second.config.port = 0;
  EXPECT_FALSE(server.start());
}

TEST(ModbusWire, A8FloodWhileTheFastestTaskRuns) {
  PlantServer plant;
  runtime::RealtimeOptions options;
  options.lock_memory = false;
  runtime::RealtimeScheduler scheduler(*plant.plant.resource, options);
  const bool realtime = scheduler.start().realtime_priority;
  std::uint64_t answers = 0;
  {
    Flood reads(plant, pdu_of(3, {kCounter, 100}), 32), writes(plant, write_registers(kSetpoint, {1, 2, 3, 4}), 4);
    std::this_thread::sleep_for(2s);
    answers = reads.answers() + writes.answers();
  }
  scheduler.request_stop();
  scheduler.join();
  const runtime::TaskStatistics& statistics = scheduler.statistics(0);
  EXPECT_GT(answers, 5'000u);
  // Scans share no lock with the server: they are as short as ever. When they start is up to the processor, which the
  // flood shares, unless the task has real-time priority.
  EXPECT_LT(statistics.scan_time.percentile_ns(0.5), 200'000);
  if (realtime) {
    // The median: a machine that stands still for a moment says nothing about the flood.
    EXPECT_LT(statistics.latency.percentile_ns(0.5), 2'000'000);
    EXPECT_GT(statistics.scans, 500u);
  }
}

TEST(ModbusWire, AClientThatTakesNoAnswers) {
  PlantServer plant(timeouts(500'000'000));
  ModbusClient deaf = plant.client();
  const int small = 4096;
  ::setsockopt(deaf.fd(), SOL_SOCKET, SO_RCVBUF, &small, sizeof small);
  const timeval now{0, 50'000};
  ::setsockopt(deaf.fd(), SOL_SOCKET, SO_SNDTIMEO, &now, sizeof now);
  Pdu burst;
  for (std::uint32_t i = 0; i < 100; ++i) {
    const Pdu frame = frame_of(pdu_of(3, {kWords, 100}), i);
    burst.insert(burst.end(), frame.begin(), frame.end());
  }
  std::size_t sent = 0;
  while (sent < 20'000 && deaf.send(burst)) ++sent;
  EXPECT_LT(sent, 20'000u) << "it is not read from for ever";
  EXPECT_TRUE(plant.serves());
  EXPECT_TRUE(eventually([&] { return plant.server.statistics().clients == 0; })) << "and dropped in the end";
  EXPECT_GE(plant.server.statistics().dropped, 1u);
}

TEST(ModbusWire, B1SampleOfFunctionsAndLengths) {
  PlantServer plant;
  std::mt19937 random(3);
  ModbusClient client = plant.client();
  for (unsigned step = 0; step < 3000; ++step) {
    Pdu request(1 + random() % 253);
    for (std::uint8_t& byte : request) byte = static_cast<std::uint8_t>(random() % 5);
    request[0] = static_cast<std::uint8_t>(random() % 2 == 0 ? random() : random() % 24);
    const Answer answer = client.ask(request, step);
    ASSERT_EQ(answer.kind, Answer::Kind::kFrame);
    ASSERT_EQ(answer.transaction, step & 0xffff);
    ASSERT_EQ(complaint(request, answer.pdu), "") << "function " << int{request[0]};
  }
  EXPECT_TRUE(client.ask(kRead).is_normal());
}

TEST(ModbusWire, B5FramesOfKnownAttacks) {
  PlantServer plant;
  // libmodbus #612 and #614 (A90AAAAN/xcBYgABAGoAAQLXEQ==, A90AAAAN/xcBYgABAIQAAQLXEQ==): in form, but they reached
  // outside a map that began at 354, and another that ended there.
  for (const std::uint8_t written : {std::uint8_t{0x6a}, std::uint8_t{0x84}}) {
    ModbusClient client = plant.client();
    client.send({0x03, 0xdd, 0x00, 0x00, 0x00, 0x0d, 0xff, 0x17, 0x01, 0x62, 0x00, 0x01, 0x00, written, 0x00, 0x01,
                 0x02, 0xd7, 0x11});
    const Answer answer = client.receive();
    ASSERT_EQ(answer.kind, Answer::Kind::kFrame);
    EXPECT_EQ(answer.transaction, 0x3ddu);
    EXPECT_EQ(answer.unit, 0xff);
    EXPECT_EQ(answer.pdu, (Pdu{0x17, 2, 0, 0})) << "both addresses are gaps of this map";
    EXPECT_TRUE(client.ask(kRead).is_normal());
  }
  EXPECT_EQ(plant.plant.value<std::uint16_t>("Words[0]"), 0);
}

TEST(ModbusWire, B7UnsupportedFunctionsKeepTheConnection) {
  PlantServer plant;
  ModbusClient client = plant.client();
  for (const unsigned function : {8u, 20u, 21u, 7u, 17u, 0u, 255u}) {
    EXPECT_EQ(client.ask(pdu_of(function, {0, 0})).exception(), 1) << function;
    EXPECT_TRUE(client.ask(kRead).is_normal()) << function;
  }
  EXPECT_EQ(client.ask({43, 13, 0}).exception(), 1);
  EXPECT_EQ(plant.server.statistics().exceptions, 8u);
}

TEST(ModbusWire, B8UnitIds) {
  PlantServer any;
  for (const unsigned unit : {0u, 1u, 17u, 247u, 255u}) {
    const Answer answer = any.client().ask(kRead, 9, static_cast<std::uint8_t>(unit));
    EXPECT_TRUE(answer.is_normal());
    EXPECT_EQ(answer.unit, unit);
  }
  io::ModbusConfig config;
  config.unit_id = std::uint8_t{17};
  PlantServer silent(config);
  ModbusClient client = silent.client();
  EXPECT_TRUE(client.ask(pdu_of(6, {kWords, 5}), 1, 1, 200).is_timeout());
  EXPECT_EQ(client.ask(kRead, 2, 17).pdu, (Pdu{3, 2, 0, 0})) << "the connection stays, and nothing was written";
  config.unit_exception = true;
  PlantServer excepting(config);
  ModbusClient other = excepting.client();
  const Answer refused = other.ask(kRead, 3, 18);
  EXPECT_EQ(refused.exception(), 11);
  EXPECT_EQ(refused.unit, 18);
  EXPECT_TRUE(other.ask(kRead, 4, 17).is_normal());
}

TEST(ModbusWire, B10NothingTearsWhileTheTaskRuns) {
  PlantServer plant;
  runtime::RealtimeOptions options;
  options.lock_memory = false;
  options.realtime_priority = false;
  runtime::RealtimeScheduler scheduler(*plant.plant.resource, options);
  scheduler.start();
  std::atomic<bool> stop{false};
  // The same word four times into a value that the task owns and copies; and into the high half of one it counts in.
  std::thread writer([&] {
    ModbusClient client = plant.client();
    for (std::uint16_t i = 1; !stop; ++i) {
      EXPECT_NE(client.ask(write_registers(kSetpoint, {i, i, i, i})).kind, Answer::Kind::kClosed);
      EXPECT_NE(client.ask(pdu_of(6, {kHalf, i})).kind, Answer::Kind::kClosed);
    }
  });
  ModbusClient client = plant.client();
  const auto end = Clock::now() + 3s;
  std::uint32_t reads = 0, changes = 0, last_low = 0;
  std::uint16_t last = 0;
  while (Clock::now() < end) {
    const Answer narrow = client.ask(pdu_of(3, {kCounter, 6}));
    ASSERT_TRUE(narrow.is_normal());
    const auto dint = [&](std::size_t at) { return word_at(narrow.pdu, at) << 16 | word_at(narrow.pdu, at + 2); };
    ASSERT_EQ(dint(2), ~dint(6)) << "two values of one scan";
    const std::uint32_t low = word_at(narrow.pdu, 12);
    ASSERT_GE(low, last_low) << "the task's half of a value went back";
    last_low = low;
    const Answer wide = client.ask(pdu_of(3, {kWide, 16}));
    ASSERT_TRUE(wide.is_normal());
    for (std::size_t i = 0; i < 8; ++i) ASSERT_EQ(wide.pdu[2 + i], wide.pdu[10 + i]) << "copies of one scan";
    for (std::size_t value : {2u, 18u, 26u}) {
      for (std::size_t word = 1; word < 4; ++word) {
        ASSERT_EQ(word_at(wide.pdu, value), word_at(wide.pdu, value + 2 * word)) << "words of one value";
      }
    }
    const auto setpoint = static_cast<std::uint16_t>(word_at(wide.pdu, 18));
    changes += setpoint != last;
    last = setpoint;
    ++reads;
  }
  stop = true;
  writer.join();
  scheduler.request_stop();
  scheduler.join();
  EXPECT_GT(reads, 1000u);
  EXPECT_GT(changes, 50u);
}

TEST(ModbusWire, B11OnlyProcessDataOnThisPort) {
  // No function beyond the served ones does anything: OpenPLC's debugger (65..69) and its kin are not there.
  PlantServer plant;
  ModbusClient client = plant.client();
  for (unsigned function = 0; function < 256; ++function) {
    if (serves(function)) continue;
    for (const std::size_t length : {1u, 3u, 9u}) {
      Pdu request(length, 1);
      request[0] = static_cast<std::uint8_t>(function);
      ASSERT_EQ(client.ask(request).exception(), 1) << function;
    }
  }
}

TEST(ModbusWire, B12ReadOnlyAndAllowList) {
  io::ModbusConfig config;
  config.read_only = true;
  PlantServer read_only(config);
  ModbusClient client = read_only.client();
  EXPECT_EQ(client.ask(pdu_of(6, {kWords, 1})).exception(), 1);
  EXPECT_EQ(client.ask(read_write(kWords, 1, kWords, {1})).exception(), 1);
  EXPECT_EQ(client.ask(kRead).pdu, (Pdu{3, 2, 0, 0}));
  config.read_only = false;
  config.writable = {{"Coils*", {}}};
  PlantServer listed(config);
  ModbusClient writer = listed.client();
  EXPECT_EQ(writer.ask(pdu_of(6, {kWords, 1})).exception(), 2);
  EXPECT_TRUE(writer.ask(pdu_of(5, {kCoils, 0xff00})).is_normal());
  EXPECT_EQ(writer.ask(pdu_of(1, {kCoils, 1})).pdu, (Pdu{1, 1, 1}));
}

TEST(ModbusWire, ClientSeen) {
  io::ModbusConfig config;
  config.client_timeout_ns = 300'000'000;
  config.port = 0;
  Plant plant(config);
  runtime::GlobalTable& globals = plant.resource->globals();
  const runtime::Place place = *runtime::Access(*plant.resource).find_leaf("Seen");
  const std::uint32_t field = globals.field_of(place.offset);
  runtime::GlobalInputs owner(globals, std::span(&field, 1));
  modbus::Server server(*plant.resource, plant.map, plant.config, modbus::SeenFlag{&owner, place.offset, place.type});
  ASSERT_FALSE(server.start().has_value());
  const auto seen = [&] { return plant.value<std::uint8_t>("Seen"); };
  ModbusClient client(server.port());
  std::this_thread::sleep_for(50ms);
  EXPECT_EQ(seen(), 0) << "a connection alone is nobody";
  EXPECT_EQ(client.ask(pdu_of(8, {0, 0})).exception(), 1);
  EXPECT_EQ(seen(), 0) << "nor is somebody who asks for what there is not";
  for (int i = 0; i < 10; ++i) {
    EXPECT_TRUE(client.ask(kRead).is_normal());
    EXPECT_EQ(seen(), 1);
    std::this_thread::sleep_for(60ms);
  }
  EXPECT_TRUE(eventually([&] { return seen() == 0; }, 1000ms));
  EXPECT_TRUE(client.ask(kRead).is_normal());
  EXPECT_EQ(seen(), 1);
  server.stop();
  EXPECT_EQ(seen(), 0);
}

TEST(ModbusWire, TheThreadIsAnOrdinaryOne) {
  const bool realtime = runtime::set_fifo(pthread_self(), 5) == 0;
  PlantServer plant;
  if (realtime) static_cast<void>(runtime::set_ordinary(pthread_self()));
  EXPECT_TRUE(plant.serves());
  std::string name, word;
  for (const auto& task : std::filesystem::directory_iterator("/proc/self/task")) {
    std::getline(std::ifstream(task.path() / "comm"), name);
    if (name != "plc-modbus") continue;
    const auto id = static_cast<pid_t>(std::stoi(task.path().filename().string()));
    EXPECT_EQ(::sched_getscheduler(id), SCHED_OTHER);
    std::ifstream status(task.path() / "status");
    while (status >> word && word != "SigBlk:") {
    }
    status >> word;
    // All but those that cannot be blocked (KILL, STOP) and the C library's own two.
    EXPECT_EQ(std::stoull(word, nullptr, 16) | 0x1'8004'0100u, 0xffff'ffff'ffff'ffffu) << word;
    return;
  }
  FAIL() << "no thread of this name";
}

}  // namespace
}  // namespace plc::test
