// Objects: which pointers lead somewhere, what an access through them reads and writes, and what it leaves alone.
#include "runtime/pointers/objects.h"

#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "bytecode/verifier.h"
#include "core/types.h"
#include "runtime/interpreter/handle.h"
#include "tests/unit/runtime/run_support.h"

namespace plc::test {
namespace {

using runtime::Handle;
using runtime::Objects;
using runtime::Pointer;
using runtime::Reached;

/// Globals of many types in the table of one task, and the objects that they are.
class ObjectsOfGlobals : public ::testing::Test {
 protected:
  void SetUp() override {
    PouBuilder main = b.pou("Main", PouKind::kProgram);
    main.variable("own", b.type(TypeId::kInt));
    const std::uint32_t pou = main.finish();
    b.task("T", 10'000'000, {pou});
    core::Diagnostics diagnostics;
    auto made = bytecode::verify(b.build(), diagnostics);
    std::ostringstream text;
    diagnostics.render(text);
    ASSERT_TRUE(made.has_value()) << text.str();
    verified.emplace(std::move(*made));
    const std::vector<std::uint8_t> reached(image().pous.size(), 1);
    body = image().tasks.front().body;
    table.emplace(image(), body, runtime::lay_out(image(), body, reached), false);
    auto all = Objects::make(image(), body, table->layout(), Handle::task_tag(0));
    ASSERT_TRUE(all.has_value());
    objects.emplace(std::move(*all));
  }

  [[nodiscard]] const Image& image() const { return verified->image(); }
  [[nodiscard]] std::uint32_t place(std::size_t global) const {
    return image().types[image().global_type].fields[global].offset;
  }
  /// The pointer to global number `global`, and `offset` bytes from there.
  [[nodiscard]] Pointer to(std::size_t global, std::int64_t offset = 0) const {
    const Pointer begin = objects->address_of(place(global), image().types[image().global_type].fields[global].type);
    EXPECT_NE(begin.bits, 0u);
    return {begin.bits + static_cast<std::uint64_t>(offset)};
  }
  template <class T>
  [[nodiscard]] T value(std::size_t global, std::uint32_t element = 0) const {
    T out;
    std::memcpy(&out, table->data() + place(global) + element * sizeof(T), sizeof out);
    return out;
  }
  template <class T>
  Reached store(Pointer pointer, TypeId type, T given) {
    return objects->store(table->data(), pointer, b.type(type), reinterpret_cast<const std::byte*>(&given), 0);
  }
  template <class T>
  Reached load(Pointer pointer, TypeId type, T& out) {
    return objects->load(table->data(), pointer, b.type(type), reinterpret_cast<std::byte*>(&out), 0);
  }
  void set_text(std::size_t global, const std::string& text) {
    std::byte* const at = table->data() + place(global);
    const core::StringHeader header{8, static_cast<std::uint16_t>(text.size())};
    std::memcpy(at, &header, sizeof header);
    std::memcpy(at + sizeof header, text.data(), text.size());
  }
  [[nodiscard]] std::string text_of(std::size_t global) const {
    const std::byte* const at = table->data() + place(global);
    core::StringHeader header{};
    std::memcpy(&header, at, sizeof header);
    return {reinterpret_cast<const char*>(at + sizeof header), header.length};
  }

  ImageBuilder b;
  // Numbers of globals.
  static constexpr std::size_t kWord = 0, kFlag = 1, kBytes = 2, kInts = 3, kText = 4, kLevel = 5, kFixed = 6,
                               kTimer = 7, kPair = 8;
  static constexpr std::uint32_t kByteCount = 200;
  std::uint32_t byte_array = b.array(b.type(TypeId::kByte), kByteCount);
  std::uint32_t int_array = b.array(b.type(TypeId::kInt), kByteCount / 2);
  Word words[10] = {
      b.global("word", b.type(TypeId::kWord)), b.global("flag", b.boolean()), b.global("bytes", byte_array),
      b.global("ints", int_array), b.global("text", b.string(8)), b.global("level", b.limited(TypeId::kInt, 0, 100)),
      b.global("fixed", b.type(TypeId::kInt), {}, {.constant = true}), b.global("timer", b.block_type("TON")),
      b.global("pair", b.structure("Pair", {{"a", b.type(TypeId::kByte)}, {"b", b.type(TypeId::kDint)}})),
      // The image has all types that tests ask for.
      b.global("number", b.type(TypeId::kUdint))};
  std::optional<bytecode::VerifiedImage> verified;
  std::uint32_t body = 0;
  std::optional<runtime::TaskTable> table;
  std::optional<Objects> objects;
};

TEST_F(ObjectsOfGlobals, NullAndWhatIsNoObjectLeadNowhere) {
  std::int16_t out = 7;
  for (const Pointer pointer :
       {Pointer{}, Pointer::make(Handle::kGlobalTag, 1000, 0), Pointer::make(Handle::task_tag(1), 0, 0),
        Pointer::make(Handle::task_tag(0), 5, 0), Pointer{0xffffffffffffffffu}}) {
    EXPECT_EQ(load(pointer, TypeId::kInt, out), Reached::kNowhere) << pointer.bits;
    EXPECT_EQ(store(pointer, TypeId::kInt, std::int16_t{1}), Reached::kNowhere) << pointer.bits;
    EXPECT_FALSE(objects->place_of(pointer, b.type(TypeId::kInt)));
  }
  EXPECT_EQ(out, 7);
}

TEST_F(ObjectsOfGlobals, AValueOfTheSameTypeIsReadAndWrittenWhereItIs) {
  EXPECT_EQ(store(to(kWord), TypeId::kWord, std::uint16_t{0xabcd}), Reached::kFine);
  EXPECT_EQ(value<std::uint16_t>(kWord), 0xabcd);
  std::uint16_t out = 0;
  EXPECT_EQ(load(to(kWord), TypeId::kWord, out), Reached::kFine);
  EXPECT_EQ(out, 0xabcd);
  EXPECT_EQ(objects->place_of(to(kWord), b.type(TypeId::kWord)), place(kWord));
  EXPECT_FALSE(objects->place_of(to(kWord), b.type(TypeId::kInt)));
  // An element in the middle of an array.
  EXPECT_EQ(store(to(kInts, 6), TypeId::kInt, std::int16_t{-3}), Reached::kFine);
  EXPECT_EQ(value<std::int16_t>(kInts, 3), -3);
}

TEST_F(ObjectsOfGlobals, AnAccessEndsWithItsObject) {
  std::uint16_t out = 7;
  EXPECT_EQ(load(to(kBytes, kByteCount - 2), TypeId::kWord, out), Reached::kFine);
  EXPECT_EQ(out, 0);
  for (const std::int64_t offset : {std::int64_t{-1}, std::int64_t{kByteCount - 1}, std::int64_t{kByteCount}}) {
    EXPECT_EQ(load(to(kBytes, offset), TypeId::kWord, out), Reached::kNowhere) << offset;
    EXPECT_EQ(store(to(kBytes, offset), TypeId::kWord, std::uint16_t{0xffff}), Reached::kNowhere) << offset;
  }
  EXPECT_EQ(value<std::uint8_t>(kBytes, kByteCount - 1), 0);
  EXPECT_EQ(value<std::uint8_t>(kFlag), 0);
}

TEST_F(ObjectsOfGlobals, ConstantsAreReadAndNotWritten) {
  std::int16_t out = 7;
  EXPECT_EQ(load(to(kFixed), TypeId::kInt, out), Reached::kFine);
  EXPECT_EQ(out, 0);
  EXPECT_EQ(store(to(kFixed), TypeId::kInt, std::int16_t{1}), Reached::kNowhere);
  EXPECT_EQ(store(to(kFixed), TypeId::kByte, std::uint8_t{1}), Reached::kNowhere);
  EXPECT_FALSE(objects->place_of(to(kFixed), b.type(TypeId::kInt)));
  EXPECT_EQ(value<std::int16_t>(kFixed), 0);
}

TEST_F(ObjectsOfGlobals, ABoolIsZeroOrOne) {
  EXPECT_EQ(store(to(kFlag), TypeId::kByte, std::uint8_t{0x80}), Reached::kFine);
  EXPECT_EQ(value<std::uint8_t>(kFlag), 1);
  EXPECT_EQ(store(to(kFlag), TypeId::kByte, std::uint8_t{0}), Reached::kFine);
  EXPECT_EQ(value<std::uint8_t>(kFlag), 0);
  // And where a byte is read as one.
  EXPECT_EQ(store(to(kBytes), TypeId::kByte, std::uint8_t{6}), Reached::kFine);
  std::uint8_t out = 0;
  EXPECT_EQ(load(to(kBytes), TypeId::kBool, out), Reached::kFine);
  EXPECT_EQ(out, 1);
}

TEST_F(ObjectsOfGlobals, ASubrangeTakesTheNearestLimit) {
  EXPECT_EQ(store(to(kLevel), TypeId::kInt, std::int16_t{300}), Reached::kFine);
  EXPECT_EQ(value<std::int16_t>(kLevel), 100);
  EXPECT_EQ(store(to(kLevel), TypeId::kInt, std::int16_t{-5}), Reached::kFine);
  EXPECT_EQ(value<std::int16_t>(kLevel), 0);
  EXPECT_EQ(store(to(kLevel, 1), TypeId::kByte, std::uint8_t{1}), Reached::kFine);  // 256
  EXPECT_EQ(value<std::int16_t>(kLevel), 100);
}

TEST_F(ObjectsOfGlobals, AStringEndsAtItsFirstZero) {
  set_text(kText, "abcdef");
  std::uint8_t out = 7;
  EXPECT_EQ(load(to(kText, 6), TypeId::kByte, out), Reached::kFine);
  EXPECT_EQ(out, 0);
  EXPECT_EQ(store(to(kText, 2), TypeId::kByte, std::uint8_t{0}), Reached::kFine);
  EXPECT_EQ(text_of(kText), "ab");
  // What is behind the zero is there again when the zero goes.
  EXPECT_EQ(store(to(kText, 2), TypeId::kByte, std::uint8_t{'x'}), Reached::kFine);
  EXPECT_EQ(text_of(kText), "abxdef");
  // The zero at the end of the memory stays.
  EXPECT_EQ(store(to(kText, 8), TypeId::kByte, std::uint8_t{'y'}), Reached::kFine);
  EXPECT_EQ(text_of(kText), "abxdef");
}

TEST_F(ObjectsOfGlobals, TextsAreReadUpToTheirZeroAndCut) {
  const std::uint32_t same = image().types[image().global_type].fields[kText].type;
  set_text(kText, "abcdef");
  std::array<std::byte, 16> out{};
  EXPECT_EQ(objects->load(table->data(), to(kText), same, out.data(), 8), Reached::kFine);
  core::StringHeader header{};
  std::memcpy(&header, out.data(), sizeof header);
  EXPECT_EQ(header.length, 6);
  EXPECT_EQ(objects->load(table->data(), to(kText), same, out.data(), 3), Reached::kCut);
  std::memcpy(&header, out.data(), sizeof header);
  EXPECT_EQ(header.length, 3);
  // From the middle, and from bytes, whose zero has to be there.
  EXPECT_EQ(objects->load(table->data(), to(kText, 4), same, out.data(), 8), Reached::kFine);
  EXPECT_EQ(std::memcmp(out.data() + sizeof header, "ef", 2), 0);
  for (std::uint32_t i = 0; i < 4; ++i) store(to(kBytes, kByteCount - 4 + i), TypeId::kByte, std::uint8_t{'z'});
  EXPECT_EQ(objects->load(table->data(), to(kBytes, kByteCount - 4), same, out.data(), 8), Reached::kNowhere);
  EXPECT_EQ(store(to(kBytes, kByteCount - 1), TypeId::kByte, std::uint8_t{0}), Reached::kFine);
  EXPECT_EQ(objects->load(table->data(), to(kBytes, kByteCount - 4), same, out.data(), 8), Reached::kFine);
  EXPECT_EQ(std::memcmp(out.data() + sizeof header, "zzz", 3), 0);
}

TEST_F(ObjectsOfGlobals, LongValuesOfAnotherLayoutAreCopiedPieceByPiece) {
  std::array<std::uint8_t, kByteCount> bytes{};
  for (std::uint32_t i = 0; i < kByteCount; ++i) bytes[i] = static_cast<std::uint8_t>(i * 7 + 1);
  ASSERT_EQ(objects->store(table->data(), to(kInts), byte_array, reinterpret_cast<const std::byte*>(bytes.data()), 0),
            Reached::kFine);
  for (std::uint32_t i = 0; i < kByteCount / 2; ++i) {
    const auto expected = static_cast<std::int16_t>(bytes[i * 2] | bytes[i * 2 + 1] << 8);
    ASSERT_EQ(value<std::int16_t>(kInts, i), expected) << i;
  }
  std::array<std::uint8_t, kByteCount> back{};
  ASSERT_EQ(objects->load(table->data(), to(kInts), byte_array, reinterpret_cast<std::byte*>(back.data()), 0),
            Reached::kFine);
  EXPECT_EQ(back, bytes);
  // One byte more than there is: nothing is read.
  back.fill(9);
  EXPECT_EQ(objects->load(table->data(), to(kInts, 1), byte_array, reinterpret_cast<std::byte*>(back.data()), 0),
            Reached::kNowhere);
  EXPECT_EQ(back.front(), 9);
}

TEST_F(ObjectsOfGlobals, GapsReadAsZeroAndTakeNothing) {
  EXPECT_EQ(store(to(kPair), TypeId::kByte, std::uint8_t{5}), Reached::kFine);
  EXPECT_EQ(store(to(kPair, 1), TypeId::kByte, std::uint8_t{0xff}), Reached::kFine);
  std::uint32_t out = 7;
  EXPECT_EQ(load(to(kPair), TypeId::kUdint, out), Reached::kFine);
  EXPECT_EQ(out, 5u);
}

TEST_F(ObjectsOfGlobals, InstancesAreClosedAndTheirVariablesAreObjects) {
  const std::uint32_t timer = image().types[image().global_type].fields[kTimer].type;
  std::uint8_t out = 7;
  EXPECT_EQ(load(to(kTimer), TypeId::kByte, out), Reached::kNowhere);
  EXPECT_EQ(store(to(kTimer), TypeId::kByte, std::uint8_t{1}), Reached::kNowhere);
  for (const ImageField& field : image().types[timer].fields) {
    const Pointer pointer = objects->address_of(place(kTimer) + field.offset, field.type);
    if (field.name == "PT") {
      ASSERT_NE(pointer.bits, 0u);
      // TIME is 32 bits of milliseconds to a pointer.
      EXPECT_EQ(store(pointer, TypeId::kUdint, std::uint32_t{1500}), Reached::kFine);
      EXPECT_EQ(store(Pointer{pointer.bits + 1}, TypeId::kUdint, std::uint32_t{0}), Reached::kNowhere);
      std::int64_t ns = 0;
      std::memcpy(&ns, table->data() + place(kTimer) + field.offset, sizeof ns);
      EXPECT_EQ(ns, 1'500'000'000);
    } else if (field.role == FieldRole::kState) {
      EXPECT_EQ(pointer.bits, 0u) << field.name;
    }
  }
}

TEST_F(ObjectsOfGlobals, AddressesOf32BitsReachALittleBeyondTheirObject) {
  EXPECT_EQ(objects->to_32(Pointer{}), 0u);
  EXPECT_EQ(objects->from_32(0)->bits, 0u);
  constexpr auto kMargin = static_cast<std::int64_t>(Objects::kMargin);
  for (const std::int64_t offset : {-kMargin, std::int64_t{0}, std::int64_t{kByteCount} + kMargin - 1}) {
    const auto address = objects->to_32(to(kBytes, offset));
    ASSERT_TRUE(address) << offset;
    EXPECT_EQ(objects->from_32(*address)->bits, to(kBytes, offset).bits) << offset;
  }
  EXPECT_FALSE(objects->to_32(to(kBytes, -kMargin - 1)));
  EXPECT_FALSE(objects->to_32(to(kBytes, kByteCount + kMargin)));
  EXPECT_FALSE(objects->from_32(1));
  EXPECT_FALSE(objects->from_32(0xffffffffu));
}

}  // namespace
}  // namespace plc::test
