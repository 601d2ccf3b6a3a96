// The server on a socket: framing, connections and what hostile clients do. Names begin with the attack they answer,
// where there is one.
#include "tests/unit/modbus/wire.h"

#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

namespace plc::test {
namespace {

TEST(ModbusWire, ServesASocketThatListensAlready) {
  const int listening = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  ASSERT_EQ(::bind(listening, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  ASSERT_EQ(::listen(listening, 16), 0);
  io::ModbusConfig config;
  config.socket = listening;
  const std::size_t before = open_descriptors();
  {
    PlantServer plant(config);
    EXPECT_TRUE(plant.serves());
    const std::uint16_t port = plant.server.port();
    // It is not the server's: who was given it may serve it again.
    plant.server.stop();
    EXPECT_EQ(plant.server.start(), std::nullopt);
    EXPECT_EQ(plant.server.port(), port);
    EXPECT_TRUE(plant.serves());
  }
  EXPECT_EQ(open_descriptors(), before);
  ::close(listening);
  io::ModbusConfig closed;
  closed.socket = listening;
  EXPECT_THROW(PlantServer{closed}, std::runtime_error);
}

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
  modbus::Responder responder(*second.resource, second.map, second.config);
  modbus::Server server(responder, second.config);
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
