// Checksums, and how long frames are.
#include "io-drivers/modbus-rtu/frame.h"

#include <gtest/gtest.h>

#include <vector>

namespace plc::modbus_rtu {
namespace {

using Bytes = std::vector<std::uint8_t>;

TEST(RtuFrame, ChecksumsAreThoseOfTheStandard) {
  // "Modbus over serial line" V1.02, appendix B: 02 07 has the CRC 41 12.
  EXPECT_EQ(crc16(Bytes{2, 7}), 0x1241);
  Bytes frame = {2, 7, 0, 0};
  seal(frame);
  EXPECT_EQ(frame, (Bytes{2, 7, 0x41, 0x12}));
  EXPECT_TRUE(is_sealed(frame));
  for (std::size_t bit = 0; bit < frame.size() * 8; ++bit) {
    Bytes wrong = frame;
    wrong[bit / 8] ^= static_cast<std::uint8_t>(1u << bit % 8);
    EXPECT_FALSE(is_sealed(wrong)) << bit;
  }
  EXPECT_FALSE(is_sealed(Bytes{})) << "no frame is so short";
  EXPECT_FALSE(is_sealed(Bytes{0xff, 0xff}));
}

struct Row {
  const char* what;
  Bytes bytes;  ///< as many as are needed to tell
  std::size_t size;
};

TEST(RtuFrame, RequestsAreAsLongAsTheirFunctionSays) {
  const Row rows[] = {
      {"read", {1, 3}, 8},
      {"write one", {1, 6}, 8},
      {"write coils", {1, 15, 0, 0, 0, 9, 2}, 11},
      {"write registers", {1, 16, 0, 0, 0, 2, 4}, 13},
      {"more than a frame has", {1, 16, 0, 0, 0, 2, 255}, kNeverKnown},
      {"mask", {1, 22}, 10},
      {"read and write", {1, 23, 0, 0, 0, 1, 0, 0, 0, 1, 2}, 15},
      {"identity", {1, 43}, 7},
      {"unknown", {1, 0x41}, kNeverKnown},
  };
  for (const Row& row : rows) {
    EXPECT_EQ(request_size(row.bytes), row.size) << row.what;
    for (std::size_t size = 0; size < std::min<std::size_t>(2, row.bytes.size()); ++size) {
      EXPECT_EQ(request_size(std::span(row.bytes).first(size)), kNotKnownYet) << row.what;
    }
  }
  EXPECT_EQ(request_size(Bytes{1, 16, 0, 0, 0, 2}), kNotKnownYet);
}

TEST(RtuFrame, AnswersAreAsLongAsTheySay) {
  const Row rows[] = {
      {"read", {1, 3, 4}, 9},
      {"read of 125", {1, 3, 250}, 255},
      {"more than a frame has", {1, 3, 254}, kNeverKnown},
      {"written", {1, 16}, 8},
      {"exception", {1, 0x83}, 5},
      {"identity", {1, 43, 14, 1, 1, 0, 0, 2, 0, 3, 'A', 'B', 'C', 1, 1, 'D'}, 18},
      {"identity, the next object", {1, 43, 14, 1, 1, 0, 0, 2, 0, 3, 'A', 'B', 'C'}, kNotKnownYet},
      {"identity of more than a frame has", {1, 43, 14, 1, 1, 0, 0, 255, 0, 255}, kNeverKnown},
      {"unknown", {1, 0x41}, kNeverKnown},
  };
  for (const Row& row : rows) EXPECT_EQ(answer_size(row.bytes), row.size) << row.what;
  Bytes endless = {1, 43, 14, 1, 1, 0, 0, 255};
  endless.resize(300, 250);
  EXPECT_EQ(answer_size(endless), kNeverKnown);
}

}  // namespace
}  // namespace plc::modbus_rtu
