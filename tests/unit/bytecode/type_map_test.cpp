// The typed map: which leaf or value lies at an offset, which types are equal, and how places are called.
#include "bytecode/type_map.h"

#include <gtest/gtest.h>

#include "bytecode/paths.h"
#include "tests/support/sample_image.h"

namespace plc::test {
namespace {

using bytecode::leaf_at;
using bytecode::place_at;
using bytecode::same_type;

struct Fixture : ::testing::Test {
  ImageBuilder b;
  std::uint32_t boolean = b.boolean();
  std::uint32_t dint = b.type(TypeId::kDint);
  std::uint32_t point = b.structure("Point", {{"flag", boolean}, {"x", dint}});  // 8 bytes
  std::uint32_t points = b.array(point, 3, 5);
  std::uint32_t outer = b.structure("Outer", {{"first", boolean}, {"list", points}, {"last", dint}});  // 4 + 24 + 4
  const Image& image = b.image;
};

TEST_F(Fixture, LeavesAreFoundAtTheirFirstByteOnly) {
  EXPECT_EQ(leaf_at(image, outer, 0), boolean);
  EXPECT_EQ(leaf_at(image, outer, 1), std::nullopt);
  EXPECT_EQ(leaf_at(image, outer, 4), boolean);       // list[5].flag
  EXPECT_EQ(leaf_at(image, outer, 5), std::nullopt);  // padding
  EXPECT_EQ(leaf_at(image, outer, 8), dint);
  EXPECT_EQ(leaf_at(image, outer, 20), boolean);  // list[7].flag
  EXPECT_EQ(leaf_at(image, outer, 24), dint);
  EXPECT_EQ(leaf_at(image, outer, 28), dint);
  EXPECT_EQ(leaf_at(image, outer, 32), std::nullopt);
  EXPECT_EQ(leaf_at(image, outer, 0xffffffffu), std::nullopt);
  EXPECT_EQ(leaf_at(image, 9999, 0), std::nullopt);
}

TEST_F(Fixture, PlacesHaveExactlyTheType) {
  EXPECT_TRUE(place_at(image, outer, 0, outer));
  EXPECT_TRUE(place_at(image, outer, 4, points));
  EXPECT_TRUE(place_at(image, outer, 4, point));
  EXPECT_TRUE(place_at(image, outer, 12, point));
  EXPECT_FALSE(place_at(image, outer, 12, points));
  EXPECT_FALSE(place_at(image, outer, 8, point));
  EXPECT_FALSE(place_at(image, outer, 28, point));
  EXPECT_FALSE(place_at(image, outer, 4, 9999));
}

TEST_F(Fixture, AMapOfATableAgreesWithTheWalk) {
  const bytecode::LeafMap map(image, outer);
  for (std::uint32_t at = 0; at < 40; ++at) {
    const auto leaf = leaf_at(image, outer, at);
    const unsigned expected = leaf ? static_cast<unsigned>(bytecode::rep_of(image.types[*leaf])) + 1u : 0u;
    EXPECT_EQ(map.at(at), expected) << at;
  }
}

TEST_F(Fixture, EqualityIsStructuralButForStructures) {
  ImageType again = image.types[points];
  EXPECT_TRUE(same_type(image, points, b.add_type(again)));
  again.lower = 6;
  EXPECT_FALSE(same_type(image, points, b.add_type(again)));
  EXPECT_FALSE(same_type(image, point, b.add_type(ImageType(image.types[point]))));
  EXPECT_TRUE(same_type(image, b.string(10), b.string(10)));
  EXPECT_FALSE(same_type(image, b.string(10), b.string(11)));
  EXPECT_FALSE(same_type(image, b.limited(TypeId::kDint, 0, 5), dint));
  EXPECT_TRUE(same_type(image, b.limited(TypeId::kDint, 0, 5), b.limited(TypeId::kDint, 0, 5, "Named")));
}

TEST_F(Fixture, ReferencesAreEqualByTheirTargets) {
  const std::uint32_t a = b.ref(b.string(7));
  const std::uint32_t c = b.ref(b.string(7));
  EXPECT_TRUE(same_type(image, a, c));
  EXPECT_TRUE(same_type(image, b.array(a, 2), b.array(c, 2)));
  EXPECT_FALSE(same_type(image, a, b.ref(dint)));
  EXPECT_FALSE(same_type(image, b.ref(a), b.ref(c)));  // one level is looked through
  EXPECT_TRUE(same_type(image, b.ref(a), b.ref(a)));
  // Two types that refer to themselves do not make the question endless.
  const std::uint32_t x = b.ref(0), y = b.ref(0);
  b.image.types[x].element = x;
  b.image.types[y].element = y;
  EXPECT_FALSE(same_type(image, x, y));
}

TEST_F(Fixture, BrokenTypesEndTheWalk) {
  b.image.types[points].element = points;
  EXPECT_EQ(leaf_at(image, outer, 4), std::nullopt);
  EXPECT_FALSE(place_at(image, outer, 4, point));
}

TEST(Paths, NamesLeadToPlaces) {
  const Sample s = sample_image();
  const Image& image = s.image;
  using bytecode::find_global;
  using bytecode::find_path;
  EXPECT_EQ(find_global(image, "LEVEL")->offset, bytecode::offset_of(s.level));
  EXPECT_EQ(find_global(image, "io.Sensor")->type, s.boolean);
  EXPECT_FALSE(find_global(image, "gvl.sensor"));
  Image named = image;
  named.types[named.global_type].aliases.push_back({"GVL.Sensor", 0});
  EXPECT_EQ(find_global(named, "gvl.sensor")->offset, named.types[named.global_type].fields.front().offset);
  named.types[named.global_type].aliases.back().global = 1'000;
  EXPECT_FALSE(find_global(named, "gvl.sensor"));
  EXPECT_FALSE(find_global(image, "level.x"));
  EXPECT_FALSE(find_global(image, ""));
  const std::uint32_t main = image.pous[s.main].instance_type;
  EXPECT_EQ(find_path(image, main, "line[1]")->type, s.dint);
  EXPECT_EQ(find_path(image, main, "line[4]")->offset, find_path(image, main, "line")->offset + 12);
  EXPECT_FALSE(find_path(image, main, "line[0]"));
  EXPECT_FALSE(find_path(image, main, "line[5]"));
  EXPECT_FALSE(find_path(image, main, "line[1"));
  EXPECT_FALSE(find_path(image, main, "line[1]x"));
  EXPECT_EQ(find_path(image, main, "motor.ton.q")->type, s.boolean);
  EXPECT_FALSE(find_path(image, main, "motor.ton."));
}

}  // namespace
}  // namespace plc::test
