// Random valid requests against a model: the tables as plain arrays, and values composed by the definition of each word
// order, without the cells of the map.
#include <gtest/gtest.h>

#include <array>
#include <random>

#include "tests/unit/modbus/plant.h"

namespace plc::test {
namespace {

using io::WordOrder;

/// Coils and holding registers of the plant, as far as only the outside writes them.
class Model {
 public:
  std::array<bool, 8192> coils{};
  std::array<std::uint16_t, 8192> registers{};

  static bool is_coil(std::uint32_t address) { return address < kCoils + 64; }
  static bool is_register(std::uint32_t address) {
    const auto in = [address](std::uint32_t first, std::uint32_t count) {
      return address >= first && address < first + count;
    };
    return in(kWords, 200) || in(kDoubles, 8) || in(kLongs, 8);
  }
  void set_coil(std::uint32_t address, bool value) {
    if (is_coil(address)) coils[address] = value;
  }
  void set_register(std::uint32_t address, std::uint16_t value) {
    if (is_register(address)) registers[address] = value;
  }
  /// The value that begins at `first`, from its bytes on the wire.
  [[nodiscard]] std::uint64_t compose(std::uint32_t first, std::uint32_t count, WordOrder order) const {
    std::vector<std::uint8_t> bytes;  // most significant first
    for (std::uint32_t i = 0; i < count; ++i) {
      const bool reversed = order == WordOrder::kCdab || order == WordOrder::kDcba;
      const std::uint16_t word = registers[first + (reversed ? count - 1 - i : i)];
      const auto high = static_cast<std::uint8_t>(word >> 8), low = static_cast<std::uint8_t>(word);
      const bool swapped = order == WordOrder::kBadc || order == WordOrder::kDcba;
      bytes.push_back(swapped ? low : high);
      bytes.push_back(swapped ? high : low);
    }
    std::uint64_t value = 0;
    for (const std::uint8_t byte : bytes) value = value << 8 | byte;
    return value;
  }
};

class ModbusProperty : public testing::TestWithParam<WordOrder> {};

TEST_P(ModbusProperty, RandomRequestsAgreeWithTheModel) {
  io::ModbusConfig config;
  config.word_order = GetParam();
  PlantPdu pdu(config);
  Model model;
  std::mt19937 random(7 + static_cast<unsigned>(GetParam()));
  const auto below = [&](std::uint32_t limit) { return static_cast<std::uint32_t>(random() % limit); };
  const auto word = [&] { return static_cast<std::uint16_t>(random()); };
  // Around the variables, so that most requests touch some and some gaps; never those of the task or with limits.
  const auto somewhere = [&](std::uint32_t most) {
    constexpr std::uint32_t kAround[] = {kWords - 10, kWords + 150, kDoubles - 5, kLongs - 5};
    const std::uint32_t area = below(4);
    const std::uint32_t first = kAround[area] + below(area == 0 ? 150 : 12);
    const std::uint32_t room = area == 0 ? 120 : area == 1 ? 100 : area == 2 ? 8 : 20;
    const std::uint32_t end = area == 2 ? kDoubles + 8 : first + room;
    return std::pair(first, 1 + below(std::max(1u, std::min(most, end > first ? end - first : 1u))));
  };
  const auto random_words = [&](std::uint32_t count) {
    std::vector<std::uint16_t> values(count);
    for (std::uint16_t& value : values) value = word();
    return values;
  };

  for (int step = 0; step < 20'000; ++step) {
    switch (below(8)) {
      case 0: {
        const std::uint32_t first = below(80), count = 1 + below(40);
        const Pdu answer = pdu.ask(pdu_of(1, {first, count}));
        for (std::uint32_t i = 0; i < (count + 7) / 8 * 8; ++i) {
          ASSERT_EQ((answer[2 + i / 8] >> i % 8 & 1) != 0, i < count && model.coils[first + i]) << "step " << step;
        }
        break;
      }
      case 1: {
        const auto [first, count] = somewhere(125);
        const auto values = pdu.holding(first, count);
        ASSERT_EQ(values.size(), count);
        for (std::uint32_t i = 0; i < count; ++i) ASSERT_EQ(values[i], model.registers[first + i]) << "step " << step;
        break;
      }
      case 2: {
        const std::uint32_t address = below(80);
        const bool value = below(2) != 0;
        ASSERT_EQ(pdu.exception(pdu_of(5, {address, value ? 0xff00u : 0u})), 0);
        model.set_coil(address, value);
        break;
      }
      case 3: {
        const std::uint32_t address = somewhere(1).first;
        const std::uint16_t value = word();
        ASSERT_EQ(pdu.exception(pdu_of(6, {address, value})), 0) << address;
        model.set_register(address, value);
        break;
      }
      case 4: {
        const std::uint32_t first = below(80), count = 1 + below(40);
        Pdu bytes((count + 7) / 8);
        for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random());
        ASSERT_EQ(pdu.exception(write_coils(first, count, bytes)), 0);
        for (std::uint32_t i = 0; i < count; ++i) model.set_coil(first + i, (bytes[i / 8] >> i % 8 & 1) != 0);
        break;
      }
      case 5: {
        const auto [first, count] = somewhere(123);
        const auto values = random_words(count);
        ASSERT_EQ(pdu.exception(write_registers(first, values)), 0) << first << ", " << count;
        for (std::uint32_t i = 0; i < count; ++i) model.set_register(first + i, values[i]);
        break;
      }
      case 6: {
        const std::uint32_t address = somewhere(1).first;
        const std::uint16_t and_mask = word(), or_mask = word();
        ASSERT_EQ(pdu.exception(pdu_of(22, {address, and_mask, or_mask})), 0);
        model.set_register(address,
                           static_cast<std::uint16_t>((model.registers[address] & and_mask) | (or_mask & ~and_mask)));
        break;
      }
      case 7: {
        const auto [first, count] = somewhere(121);
        const auto [read_first, read_count] = somewhere(125);
        const auto values = random_words(count);
        const Pdu answer = pdu.ask(read_write(read_first, read_count, first, values));
        for (std::uint32_t i = 0; i < count; ++i) model.set_register(first + i, values[i]);
        ASSERT_EQ(answer.size(), 2 + 2 * read_count);
        for (std::uint32_t i = 0; i < read_count; ++i) {
          ASSERT_EQ(answer[2 + 2 * i] << 8 | answer[3 + 2 * i], model.registers[read_first + i]) << "step " << step;
        }
        break;
      }
    }
  }
  // What the program sees is what was written.
  for (std::uint32_t i = 0; i < 4; ++i) {
    EXPECT_EQ(pdu.plant.value<std::uint32_t>("Doubles[" + std::to_string(i) + "]"),
              model.compose(kDoubles + 2 * i, 2, GetParam()));
  }
  for (std::uint32_t i = 0; i < 2; ++i) {
    EXPECT_EQ(pdu.plant.value<std::uint64_t>("Longs[" + std::to_string(i) + "]"),
              model.compose(kLongs + 4 * i, 4, GetParam()));
  }
  EXPECT_EQ(pdu.plant.value<std::uint16_t>("Words[0]"), model.registers[kWords]);
  EXPECT_EQ(pdu.plant.value<std::uint8_t>("Coils[63]"), model.coils[63]);
}

INSTANTIATE_TEST_SUITE_P(WordOrders, ModbusProperty,
                         testing::Values(WordOrder::kAbcd, WordOrder::kCdab, WordOrder::kBadc, WordOrder::kDcba),
                         [](const auto& with) { return std::string(io::word_order_text(with.param)); });

TEST(ModbusWordOrder, ARealAsClientsKnowIt) {
  // 123.456 = 42F6 E979
  const std::pair<WordOrder, std::vector<std::uint16_t>> orders[] = {{WordOrder::kAbcd, {0x42f6, 0xe979}},
                                                                     {WordOrder::kCdab, {0xe979, 0x42f6}},
                                                                     {WordOrder::kBadc, {0xf642, 0x79e9}},
                                                                     {WordOrder::kDcba, {0x79e9, 0xf642}}};
  for (const auto& [order, wire] : orders) {
    io::ModbusConfig config;
    config.word_order = order;
    PlantPdu pdu(config);
    ASSERT_EQ(pdu.exception(write_registers(kReal, wire)), 0);
    EXPECT_EQ(pdu.plant.value<float>("Real"), 123.456f) << io::word_order_text(order);
    EXPECT_EQ(pdu.holding(kReal, 2), wire) << io::word_order_text(order);
  }
}

}  // namespace
}  // namespace plc::test
