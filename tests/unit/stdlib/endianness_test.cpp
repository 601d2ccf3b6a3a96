// The order of bytes, told from the bytes themselves.
#include <algorithm>

#include "tests/unit/stdlib/values.h"

namespace plc::test {
namespace {

using stdlib::Event;
using stdlib::Overload;

TEST(Endianness, BigEndianReversesTheBytesOfEveryType) {
  for (const char* name : {"TO_BIG_ENDIAN", "FROM_BIG_ENDIAN", "TO_LITTLE_ENDIAN", "FROM_LITTLE_ENDIAN"}) {
    std::size_t seen = 0;
    for (const Overload& o : stdlib::overloads_named(name)) {
      ++seen;
      if (core::in_category(o.t, core::kAnyString)) continue;
      const std::size_t size = core::rep_bytes(core::rep_of(o.t));
      Value in(o.t);
      for (std::size_t i = 0; i < size; ++i) in.bytes[i] = static_cast<std::byte>(0xf1 + 3 * i);
      Value want = in;
      if (std::string_view(name).ends_with("BIG_ENDIAN")) std::reverse(want.bytes, want.bytes + size);
      Value out(o.t);
      EXPECT_EQ(call(o, out, {in}), Event::kNone);
      EXPECT_TRUE(std::equal(out.bytes, out.bytes + sizeof out.bytes, want.bytes)) << stdlib::key_of(o);
      // A NaN whose bits a computation would change is bytes like any others.
      std::fill(in.bytes, in.bytes + size, std::byte{0xff});
      EXPECT_EQ(call(o, out, {in}), Event::kNone);
      EXPECT_EQ(out.bits(), in.bits()) << stdlib::key_of(o);
    }
    EXPECT_EQ(seen, core::kTypeCount - 1) << name;  // all but pointers
  }
}

TEST(Endianness, StringsOfWideCharactersAreReversedCharacterByCharacter) {
  const Value narrow(TypeId::kString, "'abc'");
  Value out(TypeId::kString);
  EXPECT_EQ(call(overload("TO_BIG_ENDIAN:STRING"), out, {narrow}), Event::kNone);
  EXPECT_EQ(out.text(), "abc");

  const Value wide(TypeId::kWstring, "\"abc\"");
  Value big(TypeId::kWstring);
  EXPECT_EQ(call(overload("TO_BIG_ENDIAN:WSTRING"), big, {wide}), Event::kNone);
  const std::byte* const chars = big.bytes + sizeof(core::StringHeader);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(chars[2 * i], std::byte{0});
    EXPECT_EQ(chars[2 * i + 1], static_cast<std::byte>('a' + i));
  }
  Value back(TypeId::kWstring);
  EXPECT_EQ(call(overload("FROM_BIG_ENDIAN:WSTRING"), back, {big}), Event::kNone);
  EXPECT_EQ(back.text(), "abc");
  Value same(TypeId::kWstring);
  EXPECT_EQ(call(overload("TO_LITTLE_ENDIAN:WSTRING"), same, {wide}), Event::kNone);
  EXPECT_EQ(same.text(), "abc");

  Value small(TypeId::kWstring);
  small.set(core::StringHeader{2, 0});
  EXPECT_EQ(call(overload("TO_BIG_ENDIAN:WSTRING"), small, {wide}), Event::kTruncated);
  EXPECT_EQ(small.get<core::StringHeader>().length, 2);
}

}  // namespace
}  // namespace plc::test
