// Requests out of what is heard on a line, in virtual time: pauses, other units, noise.
#include "io-drivers/modbus-rtu/request_stream.h"

#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

namespace plc::modbus_rtu {
namespace {

using Bytes = std::vector<std::uint8_t>;
constexpr core::TimeNs kMs = 1'000'000, kSilence = 2 * kMs;
constexpr std::uint8_t kUnit = 5;

Bytes frame(Bytes bytes) {
  bytes.resize(bytes.size() + kChecksum);
  seal(bytes);
  return bytes;
}
Bytes operator+(Bytes one, const Bytes& other) {
  one.insert(one.end(), other.begin(), other.end());
  return one;
}
const Bytes kRead = frame({kUnit, 3, 0, 1, 0, 2});
const Bytes kWrite = frame({kUnit, 16, 0, 1, 0, 2, 4, 1, 2, 3, 4});
const Bytes kForAll = frame({0, 6, 0, 1, 0, 7});
const Bytes kOther = frame({9, 3, 0, 0, 0, 2});
const Bytes kOtherAnswer = frame({9, 3, 4, 1, 2, 3, 4});
const Bytes kOtherWrite = frame({9, 6, 0, 1, 0, 7});  // its answer is the same
const Bytes kUnknown = frame({kUnit, 0x41, 1, 2, 3});
const Bytes kTooLong = frame({kUnit, 3, 0, 1, 0, 2, 0});
/// A frame of ours inside of another unit's answer.
const Bytes kDisguised = frame(Bytes{9, 3, 8} + kRead);

/// Pieces with pauses before them; what comes out, in order.
struct Case {
  const char* name;
  std::vector<std::pair<core::TimeNs, Bytes>> pieces;
  std::vector<Bytes> requests;
  std::uint64_t damaged = 0;
};

class Streams : public ::testing::TestWithParam<Case> {};

TEST_P(Streams, GiveTheRequestsForTheUnit) {
  RequestStream stream(kUnit, kSilence);
  std::vector<Bytes> requests;
  core::TimeNs now = 1000 * kMs;
  const auto take_until = [&](core::TimeNs end) {
    for (;;) {
      for (auto one = stream.take(now); !one.empty(); one = stream.take(now))
        requests.emplace_back(one.begin(), one.end());
      const auto due = stream.due();
      if (!due || *due > end) break;
      ASSERT_GT(*due, now) << "due, and nothing to do";
      now = *due;
    }
    now = end;
  };
  // Twice: what came before must not matter.
  for (int round = 0; round < 2; ++round) {
    requests.clear();
    for (const auto& [pause, bytes] : GetParam().pieces) {
      take_until(now + pause);
      stream.add(bytes, now);
    }
    take_until(now + 100 * kMs);
    EXPECT_EQ(requests, GetParam().requests);
    EXPECT_EQ(stream.damaged(), GetParam().damaged * static_cast<unsigned>(round + 1));
    EXPECT_EQ(stream.due(), std::nullopt);
  }
}

std::vector<std::pair<core::TimeNs, Bytes>> byte_by_byte(const Bytes& bytes, core::TimeNs pause) {
  std::vector<std::pair<core::TimeNs, Bytes>> pieces;
  for (const std::uint8_t byte : bytes) pieces.push_back({pause, {byte}});
  return pieces;
}

const Case kCases[] = {
    {"one", {{0, kRead}}, {kRead}},
    {"byte_by_byte", byte_by_byte(kWrite, kMs), {kWrite}},
    {"as_an_adapter_hands_it_on",
     {{0, {kRead.begin(), kRead.begin() + 3}}, {16 * kMs, {kRead.begin() + 3, kRead.end()}}},
     {kRead}},
    {"half", {{0, {kRead.begin(), kRead.begin() + 5}}}, {}, 1},
    {"half_then_whole", {{0, {kRead.begin(), kRead.begin() + 5}}, {30 * kMs, kRead}}, {kRead}, 1},
    {"wrong_checksum", {{0, kRead + Bytes{}}, {50 * kMs, {kUnit, 3, 0, 1, 0, 2, 0, 0}}}, {kRead}, 1},
    {"two_after_each_other", {{0, kRead}, {10 * kMs, kWrite}}, {kRead, kWrite}},
    {"asked_again_meanwhile", {{0, kRead + kWrite}}, {kWrite}},
    {"for_all", {{0, kForAll}}, {kForAll}},
    {"for_all_and_then_for_us", {{0, kForAll + kRead}}, {kForAll, kRead}},
    {"others_without_a_pause", {{0, kOther + kOtherAnswer + kOtherWrite + kOtherWrite + kRead}}, {kRead}},
    {"another_that_is_not_there", {{0, kOther}, {100 * kMs, kOther}, {100 * kMs, kRead}}, {kRead}},
    {"anothers_exception", {{0, kOther + frame({9, 0x83, 2}) + kRead}}, {kRead}},
    {"another_in_pieces", byte_by_byte(kOther + kOtherAnswer + kRead, kMs), {kRead}},
    {"a_frame_in_anothers_answer", {{0, kOther}, {5 * kMs, kDisguised}}, {}},
    {"a_frame_in_anothers_answer_in_pieces",
     {{0, frame({9, 3, 0, 0, 0, 4})},
      {5 * kMs, {9, 3, 8}},
      {kMs, kRead},
      {kMs, {kDisguised.end() - 2, kDisguised.end()}}},
     {}},
    {"a_frame_in_what_was_not_asked_for", {{0, kDisguised}}, {}},
    {"unknown_function", {{0, kUnknown}}, {kUnknown}},
    {"unknown_function_of_another", {{0, frame({9, 0x41, 1, 2, 3})}, {5 * kMs, kRead}}, {kRead}},
    {"wrong_length", {{0, kTooLong}}, {kTooLong}},
    {"stray_bytes_before", {{0, Bytes{0, 0xff} + kRead}}, {kRead}},
    {"stray_byte_in_its_own_time", {{0, {0}}, {50 * kMs, kRead}}, {kRead}},
    {"stray_byte_after", {{0, kRead + Bytes{0xff}}}, {kRead}},
    {"noise_before", {{0, Bytes{1, 2, 3} + kRead}}, {}, 1},
    {"noise_then_silence", {{0, {1, 2, 3, 77, 12, 9}}, {30 * kMs, kRead}}, {kRead}, 1},
    {"noise_for_long",
     {{0, Bytes(500, 0xaa)}, {kMs, Bytes(500, 0xaa)}, {kMs, Bytes(500, 0xaa)}, {kMs, kRead}, {5 * kMs, kRead}},
     {kRead},
     1},
    {"zeros", {{0, Bytes(300, 0)}, {30 * kMs, kRead}}, {kRead}, 1},
};
INSTANTIATE_TEST_SUITE_P(All, Streams, ::testing::ValuesIn(kCases),
                         [](const auto& test) { return std::string(test.param.name); });

TEST(RequestStream, ARequestHasEndedAfterASilence) {
  RequestStream stream(kUnit, kSilence);
  stream.add(kRead, kMs);
  EXPECT_TRUE(stream.take(kMs).empty());
  EXPECT_EQ(stream.due(), kMs + kSilence);
  EXPECT_TRUE(stream.take(kMs + kSilence - 1).empty());
  EXPECT_EQ(stream.take(kMs + kSilence).size(), kRead.size());
  EXPECT_TRUE(stream.take(kMs + kSilence).empty());
  EXPECT_EQ(stream.frames(), 1u);
}

TEST(RequestStream, WhateverIsHeardNothingIsMadeUp) {
  // Random bytes with good frames of others between them. A request may come out by chance where its checksum fits,
  // after a pause: once in some hundred million pieces.
  std::mt19937 random(52);
  RequestStream stream(kUnit, kSilence);
  core::TimeNs now = 0;
  for (int i = 0; i < 100'000; ++i) {
    Bytes bytes(random() % 60);
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random() % 3 == 0 ? random() : random() % 24);
    if (random() % 4 == 0) bytes = kOther + kOtherAnswer;
    now += static_cast<core::TimeNs>(random() % 40) * kMs / 4;
    stream.add(bytes, now);
    EXPECT_TRUE(stream.take(now).empty()) << i;
    now += static_cast<core::TimeNs>(random() % 3) * kMs;
    EXPECT_TRUE(stream.take(now).empty()) << i;
  }
  now += 100 * kMs;
  EXPECT_TRUE(stream.take(now).empty());
  stream.add(kRead, now);
  EXPECT_EQ(stream.take(now + kSilence).size(), kRead.size()) << "and then it is in step again";
}

}  // namespace
}  // namespace plc::modbus_rtu
