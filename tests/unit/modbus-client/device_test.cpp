// What a device is asked and when, what its inputs are worth, loss, return and back-off: in virtual time.
#include <gtest/gtest.h>

#include "tests/unit/modbus-client/rig.h"

namespace plc::test {
namespace {

constexpr core::TimeNs kMs = 1'000'000, kSecond = 1'000 * kMs;

std::string dev(const std::string& channels, const std::string& keys = "") {
  return "[drivers.dev]\nkind = \"modbus\"\nbus = \"10.0.0.5\"\nunit = 7\n" + keys + channels;
}
std::string in(const std::string& name, const std::string& table, int address, const std::string& more = "") {
  return "\"" + name + "\" = { driver = \"dev\", table = \"" + table + "\", address = " + std::to_string(address) +
         more + " }\n";
}
const std::string kStatus =
    "Ok = { driver = \"dev\", status = \"ok\" }\nAge = { driver = \"dev\", status = \"age\" }\n"
    "Error = { driver = \"dev\", status = \"error\" }\n";
const std::string kHolding = "holding-registers";

TEST(Device, InputsAreReadInTheFewestRequestsAtTheirPeriods) {
  Rig rig(dev("[inputs]\n" + in("In0", kHolding, 100) + in("In1", kHolding, 101) + in("Real", kHolding, 104) +
                  in("In2", kHolding, 200, ", poll = \"1s\"") + in("Flag", "discrete-inputs", 3),
              "gap = 2\n"));
  rig.link.registers = {{100, 5}, {101, 0xfffb}, {104, 0x42f6}, {105, 0xe979}, {200, 77}};
  rig.link.coils[3] = 1;
  rig.run(kSecond - kMs);
  EXPECT_EQ(rig.value("In0") + rig.value("In1"), "5-5");
  EXPECT_EQ(rig.value("Real"), "123.456");
  EXPECT_EQ(rig.value("In2") + rig.value("Flag"), "771");
  std::map<Bytes, int> counts;
  for (const Bytes& request : rig.link.requests) ++counts[request];
  EXPECT_EQ(counts.size(), 3u);
  EXPECT_EQ((counts[{3, 0, 100, 0, 6}]), 10);
  EXPECT_EQ((counts[{2, 0, 3, 0, 1}]), 10);
  EXPECT_EQ((counts[{3, 0, 200, 0, 1}]), 1);
  EXPECT_EQ(rig.said(), "");
}

TEST(Device, StatusTellsHowItGoes) {
  Rig rig(dev("[inputs]\n" + in("In0", kHolding, 0) + kStatus, "poll = \"50ms\"\ntimeout = \"100ms\"\nretries = 0\n"));
  EXPECT_EQ(rig.value("Ok") + rig.value("Error"), "01000") << "not asked yet";
  rig.run(10 * kMs);
  EXPECT_EQ(rig.value("Ok") + rig.value("Error") + rig.value("Age"), "100");
  rig.link.always = Error::kNoAnswer;
  rig.run(kSecond);
  EXPECT_EQ(rig.value("Ok") + rig.value("Error"), "01002");
  EXPECT_GE(std::stoll(rig.value("Age")), 900 * kMs);
  EXPECT_LE(std::stoll(rig.value("Age")), 1'010 * kMs);
  rig.link.always = Error::kDeviceFailure;
  rig.run(4 * kSecond);
  EXPECT_EQ(rig.value("Ok") + rig.value("Error"), "04");
}

TEST(Device, LostInputsHaveTheValuesThatWereDeclared) {
  for (const auto& [more, keys, before, after] :
       std::initializer_list<std::tuple<std::string, std::string, std::string, std::string>>{
           {"", "", "0", "11"},
           {"", "on_loss = \"zero\"\n", "0", "0"},
           {", substitute = -1", "", "-1", "-1"},
           {", substitute = 12", "on_loss = \"zero\"\n", "12", "12"}}) {
    Rig rig(dev("[inputs]\n" + in("In0", kHolding, 0, more), keys));
    EXPECT_EQ(rig.value("In0"), before) << more << keys;
    rig.link.registers[0] = 11;
    rig.run(10 * kMs);
    EXPECT_EQ(rig.value("In0"), "11");
    EXPECT_EQ(rig.device->inputs(rig.link.clock.now_ns())[0].quality, io::Quality::kGood);
    rig.link.always = Error::kClosed;
    rig.run(kSecond);
    EXPECT_EQ(rig.value("In0"), after) << more << keys;
    EXPECT_EQ(rig.device->inputs(rig.link.clock.now_ns())[0].quality, io::Quality::kLost);
    rig.link.always = Error::kNone;
    rig.run(4 * kSecond);
    EXPECT_EQ(rig.value("In0"), "11");
  }
}

TEST(Device, OneBadAnswerIsNoLoss) {
  Rig rig(dev("[inputs]\n" + in("In0", kHolding, 0) + kStatus));
  rig.run(10 * kMs);
  for (const Error error : {Error::kNoAnswer, Error::kWrongAnswer, Error::kClosed}) {
    rig.link.next = {error, error};
    rig.run(2 * kSecond);
    EXPECT_TRUE(rig.link.next.empty());
    EXPECT_EQ(rig.value("Ok"), "1");
  }
  EXPECT_EQ(rig.device->status().losses, 0u);
  EXPECT_EQ(rig.said(), "");
}

TEST(Device, ALostDeviceIsAskedAtLongerAndLongerTimes) {
  Rig rig(dev("[inputs]\n" + in("In0", kHolding, 0), "retry = \"1s\"\nretry_max = \"8s\"\n"));
  rig.link.always = Error::kNotConnected;
  rig.run(60 * kSecond);
  // After 0, 1, 3, 7, 15 s, then every 8 s.
  EXPECT_EQ(rig.link.requests.size(), 5u + 5u);
  EXPECT_EQ(rig.said(), "dev: 10.0.0.5:502, unit 7: it cannot be connected to\n");
  EXPECT_FALSE(rig.device->status().connected);
  rig.link.always = Error::kNone;
  rig.run(8 * kSecond);
  EXPECT_EQ(rig.said(), "dev: 10.0.0.5:502, unit 7 is back after 63.0 s\n");
  EXPECT_EQ(rig.device->status().recoveries, 1u);
}

TEST(Device, AnExceptionConcernsItsBlockAlone) {
  Rig rig(dev("[inputs]\n" + in("In0", kHolding, 0) + in("In1", kHolding, 500) + kStatus));
  rig.link.registers = {{0, 1}, {500, 2}};
  rig.run(10 * kMs);
  rig.link.holes[500] = 1;
  rig.run(kSecond);
  EXPECT_EQ(rig.value("Ok") + rig.value("Error"), "02");
  EXPECT_EQ(rig.said(),
            "dev: 10.0.0.5:502, unit 7: holding register 500 cannot be read: exception 2: it has no such address\n");
  EXPECT_TRUE(rig.device->status().connected);
  rig.link.registers[0] = 33;
  rig.run(200 * kMs);
  EXPECT_EQ(rig.value("In0"), "33");
  rig.link.holes.clear();
  rig.run(3 * kSecond);
  EXPECT_EQ(rig.value("Ok"), "1");
  EXPECT_EQ(rig.said(), "dev: 10.0.0.5:502, unit 7: holding register 500 can be read again\n");
}

TEST(Device, ARequestThatAloneHasNoAnswerIsToldAndWaits) {
  Rig rig(dev("[inputs]\n" + in("In0", kHolding, 0) + in("In1", kHolding, 500, ", substitute = -1") + kStatus));
  rig.link.registers = {{0, 1}, {500, 2}};
  rig.run(10 * kMs);
  EXPECT_EQ(rig.value("In1"), "2");
  rig.link.silent = 500;
  rig.run(10 * kSecond);
  EXPECT_EQ(rig.value("Ok") + rig.value("Error") + rig.value("In1"), "01002-1");
  EXPECT_EQ(rig.said(), "dev: 10.0.0.5:502, unit 7: holding register 500 cannot be read: it does not answer in time\n");
  EXPECT_TRUE(rig.device->status().connected) << "others are answered";
  EXPECT_EQ(rig.device->status().losses, 0u);
  rig.link.registers[0] = 33;
  rig.link.requests.clear();
  rig.run(20 * kSecond);
  EXPECT_EQ(rig.value("In0"), "33");
  EXPECT_GT(rig.link.requests.size(), 100u) << "the bus does not wait for it all the time";
  rig.link.silent.reset();
  rig.run(60 * kSecond);
  EXPECT_EQ(rig.value("Ok") + rig.value("In1"), "12");
  EXPECT_EQ(rig.said(), "dev: 10.0.0.5:502, unit 7: holding register 500 can be read again\n");
}

TEST(Device, ALostDeviceIsAskedForSomethingElseNextTime) {
  Rig rig(dev("[inputs]\n" + in("In0", kHolding, 0) + in("In1", kHolding, 500) + kStatus, "retry_max = \"1s\"\n"));
  rig.link.registers = {{500, 2}};
  rig.link.always = Error::kNoAnswer;
  rig.run(20 * kSecond);
  EXPECT_FALSE(rig.device->status().connected);
  rig.link.always = Error::kNone;
  rig.link.silent = 0;
  rig.run(20 * kSecond);
  EXPECT_TRUE(rig.device->status().connected);
  EXPECT_EQ(rig.value("In1"), "2");
}

TEST(Device, OneThatIsLostByARareRequestIsFoundByOthersAtOnce) {
  Rig rig(dev("[inputs]\n" + in("In0", kHolding, 0) + in("In1", kHolding, 500, ", poll = \"1h\"") + kStatus));
  rig.link.registers = {{0, 1}, {500, 2}};
  rig.run(kSecond);
  rig.link.silent = 0;
  rig.run(3 * kSecond);
  EXPECT_EQ(rig.device->status().losses, 1u);
  EXPECT_EQ(rig.device->status().recoveries, 1u);
  EXPECT_NE(rig.said().find("holding register 0 cannot be read: it does not answer in time\n"), std::string::npos);
}

TEST(Device, HolesInTheDeviceSplitARequestForGood) {
  Rig rig(dev("[inputs]\n" + in("In0", kHolding, 0) + in("In1", kHolding, 1) + in("In2", kHolding, 5) + kStatus));
  rig.link.registers = {{0, 1}, {1, 2}, {5, 3}};
  rig.link.holes[3] = 1;
  rig.run(50 * kMs);
  EXPECT_EQ(rig.value("Ok") + rig.value("In0") + rig.value("In1") + rig.value("In2"), "1123");
  EXPECT_EQ(rig.said(),
            "dev: 10.0.0.5:502, unit 7: holding registers 0 to 5 have addresses that it does not have between them: "
            "they are read in 2 requests\n");
  rig.link.requests.clear();
  rig.run(100 * kMs);
  EXPECT_EQ(rig.link.requests, (std::vector<Bytes>{{3, 0, 0, 0, 2}, {3, 0, 5, 0, 1}}));
}

TEST(Device, OutputsAreWrittenWhenTheyChangeAndNowAndThen) {
  Rig rig(dev("[inputs]\n" + in("In0", "input-registers", 0) + in("Flag", "discrete-inputs", 0) + "[outputs]\n" +
                  in("Out0", kHolding, 10, ", initial = 5, safe = 6") + in("Out1", kHolding, 11) +
                  in("Lamp", "coils", 20),
              "rewrite = \"1s\"\npoll = \"1h\"\n"));
  rig.run(20 * kMs);
  EXPECT_EQ(rig.link.registers[10], 5) << "initial, until the first scan has ended";
  rig.scan();
  rig.run(20 * kMs);
  EXPECT_EQ(rig.link.registers[10], 0);
  rig.link.requests.clear();
  rig.run(500 * kMs);
  EXPECT_EQ(rig.link.requests, std::vector<Bytes>{}) << "nothing changed";
  rig.run(kSecond);
  EXPECT_EQ(rig.link.requests, (std::vector<Bytes>{{5, 0, 20, 0, 0}, {16, 0, 10, 0, 2, 4, 0, 0, 0, 0}}));
  rig.device->hold_all();
  rig.run(20 * kMs);
  EXPECT_EQ(rig.link.registers[10], 6) << "safe";
}

TEST(Device, ChangesGoOutAndComeBackAfterALoss) {
  Rig rig(dev("[inputs]\n" + in("In0", "input-registers", 0) + in("Flag", "discrete-inputs", 0) + "[outputs]\n" +
                  in("Out0", kHolding, 10) + in("Lamp", "coils", 20),
              "rewrite = \"0s\"\n"));
  rig.link.registers[0] = 42;
  rig.link.coils[0] = 1;
  rig.run(150 * kMs);
  rig.scan();
  rig.run(20 * kMs);
  EXPECT_EQ(rig.link.registers[10], 42);
  EXPECT_EQ(rig.link.coils[20], 1);
  // The device restarts, and has lost what was written.
  rig.link.always = Error::kClosed;
  rig.run(kSecond);
  rig.link.registers[10] = rig.link.coils[20] = 0;
  rig.link.always = Error::kNone;
  rig.run(2 * kSecond);
  EXPECT_EQ(rig.link.registers[10], 42);
  EXPECT_EQ(rig.link.coils[20], 1);
}

TEST(Device, TextsGoBothWays) {
  Rig rig(dev("[inputs]\n" + in("Text", kHolding, 10, ", registers = 4, substitute = \"none\"") + "[outputs]\n" +
              in("Label", kHolding, 20, ", word_order = \"BADC\", safe = \"off\"")));
  EXPECT_EQ(rig.value("Text"), "'none'");
  rig.link.registers = {{10, 'a' << 8 | 'b'}, {11, 'c' << 8}, {12, 'x' << 8 | 'x'}, {24, 0xffff}};
  rig.run(150 * kMs);
  EXPECT_EQ(rig.value("Text"), "'abc'");
  rig.scan();
  rig.run(20 * kMs);
  EXPECT_EQ(rig.link.registers[20], 'b' << 8 | 'a');
  EXPECT_EQ(rig.link.registers[21], 'c');
  EXPECT_EQ(rig.link.registers[24], 0);
  rig.device->hold_all();
  rig.run(20 * kMs);
  EXPECT_EQ(rig.link.registers[20], 'f' << 8 | 'o');
}

TEST(Device, AStoppedTaskLeavesItsOutputsSafe) {
  Rig rig(dev("[inputs]\n" + in("In0", "input-registers", 0) + "[outputs]\n" + in("Out0", kHolding, 10, ", safe = 9")));
  rig.link.registers[0] = 3;
  rig.run(150 * kMs);
  rig.scan();
  rig.run(20 * kMs);
  EXPECT_EQ(rig.link.registers[10], 3);
  rig.device->task_stopped(0);
  rig.run(20 * kMs);
  EXPECT_EQ(rig.link.registers[10], 9);
  rig.link.registers[10] = 3;
  EXPECT_TRUE(rig.device->write_safe(rig.link));
  EXPECT_EQ(rig.link.registers[10], 9);
  rig.link.always = Error::kNoAnswer;
  EXPECT_FALSE(rig.device->write_safe(rig.link));
}

TEST(Device, SafeValuesDoNotWaitForARequestThatHasNoAnswer) {
  Rig rig(dev("[outputs]\n" + in("Out0", kHolding, 10, ", safe = 9") + in("Out1", kHolding, 500, ", safe = 8")));
  rig.link.silent = 10;
  EXPECT_FALSE(rig.device->write_safe(rig.link));
  EXPECT_EQ(rig.link.registers[500], 8);
  EXPECT_EQ(rig.link.requests.size(), 4u) << "that one is asked three times";
}

TEST(Device, ManyChangesFillNoLog) {
  Rig rig(dev("[inputs]\n" + in("In0", kHolding, 0), "retry = \"10ms\"\nretry_max = \"10ms\"\nretries = 0\n"));
  std::size_t lines = 0;
  for (int i = 0; i < 20'000; ++i) {
    rig.link.always = i % 2 == 0 ? Error::kWrongAnswer : Error::kNone;
    rig.run(100 * kMs);
    lines += rig.device->take_said(rig.link.clock.now_ns()).size();
  }
  EXPECT_GT(rig.device->status().losses, 5'000u);
  EXPECT_LE(lines, 11u * 2'000 / 60 + 11) << "in 2000 s";
}

TEST(Device, ABusyBusKeepsReadsAndWritesGoing) {
  // Each exchange takes a millisecond, and so does the period.
  Rig rig(dev("[inputs]\n" + in("In0", kHolding, 0) + in("In1", kHolding, 300) + "[outputs]\n" +
                  in("Out0", kHolding, 10) + in("Out1", kHolding, 30),
              "poll = \"1ms\"\nwrite = \"1ms\"\nrewrite = \"1ms\"\n"));
  rig.run(400 * kMs);
  std::map<int, int> counts;  // by function and address
  for (const Bytes& request : rig.link.requests) ++counts[request[0] << 16 | request[1] << 8 | request[2]];
  ASSERT_EQ(counts.size(), 4u);
  for (const auto& [what, count] : counts) EXPECT_GT(count, 60) << what;
}

}  // namespace
}  // namespace plc::test
