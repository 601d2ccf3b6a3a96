// Drawings in images: what is packed is unpacked again, and no bytes whatever do more harm than a message.
#include "bytecode/drawings.h"

#include <gtest/gtest.h>

#include <cstring>
#include <random>
#include <string>

#include "bytecode/byte_io.h"
#include "bytecode/fingerprint.h"
#include "bytecode/format.h"
#include "bytecode/image.h"
#include "tests/support/sample_image.h"

namespace plc::test {
namespace {

using namespace bytecode;

/// A rung of a contact and a coil, a chart with a macro step, and a text: every field has a value that is not its
/// default one somewhere.
Drawings sample() {
  DrawnBody ladder;
  ladder.name = "Main";
  ladder.file = "plant.xml";
  ladder.worksheet = "Inputs";
  ladder.sheets = {"Main"};
  DrawnElement contact;
  contact.kind = core::ElementKind::kContact;
  contact.local_id = 20'000'000'001;
  contact.line = 7;
  contact.column = 3;
  contact.network = 1;
  contact.text = "Start <\"&'>";
  contact.modifiers = {true, DrawnEdge::kRising, DrawnStorage::kNone};
  contact.x = 40;
  contact.y = 20;
  contact.width = 30;
  contact.height = 20;
  contact.pins = {{"", "", false, 0, {}, {40, 30}}, {"", "", true, 0, {}, {70, 30}}};
  DrawnElement block = contact;
  block.kind = core::ElementKind::kBlock;
  block.local_id = 2;
  block.text = "TON";
  block.instance = "Delay";
  block.code = "A := B;";
  block.x = 100;
  block.pins = {{"IN", "", false, 0, {true, DrawnEdge::kFalling, DrawnStorage::kReset}, {100, 30}},
                {"PT", "T#5s", false, 1, {}, {100, 40}},
                {"Q", "", true, 0, {}, {130, 30}}};
  ladder.elements = {contact, block};
  ladder.wires = {{0, 1, 1, 0, {{70, 30}, {85, 30}, {100, 30}}}};
  ladder.comments = {{"Start of it all", 0, 0, 0, 200, 15}};

  DrawnBody chart;
  chart.name = "Main.Seq";
  chart.owner = DrawnOwner::kAction;
  chart.language = DrawnLanguage::kSfc;
  chart.sheets = {"Main.Seq", "Fill"};
  DrawnElement step;
  step.kind = core::ElementKind::kMacroStep;
  step.macro_sheet = 1;
  step.initial = true;
  step.actions = {{"SD", "Pump", "T#1s", "Busy", 12, 5}};
  DrawnElement transition;
  transition.kind = core::ElementKind::kTransition;
  transition.sheet = 1;
  transition.priority = 2;
  transition.text = "Level > 5";
  chart.elements = {step, transition};

  DrawnBody text;
  text.name = "Calc";
  text.owner = DrawnOwner::kFunction;
  text.language = DrawnLanguage::kSt;
  text.text = "a := 1;\nb := 2;";
  text.text_line = 3;
  text.text_column = 1;
  text.statements = {{3, 1, 3, 8}, {4, 1, 4, 8}};
  return {{ladder, chart, text}};
}

/// As unpack() reads it, uncompressed.
std::vector<std::byte> plain(std::span<const std::byte> content) {
  std::vector<std::byte> bytes(9);
  store_le(bytes.data() + 1, static_cast<std::uint64_t>(content.size()));
  bytes.insert(bytes.end(), content.begin(), content.end());
  return bytes;
}

/// The content of a small drawing, which is packed as it is.
std::vector<std::byte> plain_sample() {
  Drawings one = sample();
  std::vector<std::byte> content;
  // Compression is a matter of size alone: noise in a text keeps it away.
  std::mt19937 random(1);
  for (int i = 0; i < 12'000; ++i) one.bodies[2].text += static_cast<char>(random());
  std::vector<std::byte> bytes = pack(one);
  EXPECT_EQ(bytes[0], std::byte{0});
  return bytes;
}

TEST(Drawings, RoundTripKeepsEverything) {
  const Drawings drawings = sample();
  const auto again = unpack(pack(drawings));
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_EQ(*again, drawings);
  const auto none = unpack(pack({}));
  ASSERT_TRUE(none);
  EXPECT_TRUE(none->bodies.empty());
  EXPECT_TRUE(unpack(plain_sample()));
}

TEST(Drawings, AreCompressedWhereItPays) {
  Drawings many;
  for (int i = 0; i < 300; ++i) {
    many.bodies.push_back(sample().bodies[0]);
    many.bodies.back().name += std::to_string(i);
    many.bodies.back().elements[0].x = i * i % 1000;
  }
  const std::vector<std::byte> bytes = pack(many);
  EXPECT_EQ(bytes[0], std::byte{1});
  EXPECT_LT(bytes.size(), 10'000u);
  const auto again = unpack(bytes);
  ASSERT_TRUE(again);
  EXPECT_EQ(*again, many);
  // What nothing but an attack packs so small is stored as it is.
  Drawings zeros;
  zeros.bodies.resize(1);
  zeros.bodies[0].text.assign(1 << 20, 'a');
  EXPECT_EQ(pack(zeros)[0], std::byte{0});
  ASSERT_TRUE(unpack(pack(zeros)));
}

TEST(Drawings, CutAnywhereAreRefused) {
  for (const std::vector<std::byte>& bytes : {pack(sample()), plain_sample()}) {
    for (std::size_t size = 0; size < bytes.size(); ++size) {
      EXPECT_FALSE(unpack(std::span(bytes).first(size))) << size;
      std::vector<std::byte> cut(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
      if (size >= 9 && cut[0] == std::byte{0}) store_le(cut.data() + 1, static_cast<std::uint64_t>(size - 9));
      EXPECT_FALSE(unpack(cut)) << size;
    }
  }
}

/// Nothing in it leads out of it.
void expect_sound(const Drawings& drawings) {
  for (const DrawnBody& body : drawings.bodies) {
    for (const DrawnElement& e : body.elements) {
      ASSERT_LT(e.sheet, body.sheets.size());
      ASSERT_TRUE(e.macro_sheet == 0 || e.macro_sheet < body.sheets.size());
      ASSERT_LE(e.kind, core::kLastElementKind);
      ASSERT_TRUE(e.x >= 0 && e.x <= kMaxDrawn && e.width >= 0 && e.height <= kMaxDrawn);
    }
    for (const DrawnWire& wire : body.wires) {
      ASSERT_TRUE(body.elements.at(wire.from).pins.at(wire.from_pin).output);
      ASSERT_FALSE(body.elements.at(wire.to).pins.at(wire.to_pin).output);
      ASSERT_GE(wire.points.size(), 2u);
    }
    for (const DrawnComment& comment : body.comments) ASSERT_LT(comment.sheet, body.sheets.size());
  }
}

TEST(Drawings, AnyOtherByteIsUnpackedSoundOrRefused) {
  std::size_t refused = 0, taken = 0;
  for (const std::vector<std::byte>& bytes : {pack(sample()), plain_sample()}) {
    for (std::size_t at = 0; at < std::min<std::size_t>(bytes.size(), 1500); ++at) {
      for (unsigned bit = 0; bit < 8; ++bit) {
        std::vector<std::byte> mutant = bytes;
        mutant[at] ^= static_cast<std::byte>(1u << bit);
        const auto drawings = unpack(mutant);
        ++(drawings ? taken : refused);
        if (drawings) expect_sound(*drawings);
      }
    }
  }
  EXPECT_GT(refused, 500u);
  EXPECT_GT(taken, 100u);
}

TEST(Drawings, WhatLeadsOutOfThemIsRefused) {
  const auto refused = [](const auto& break_it) {
    Drawings drawings = sample();
    break_it(drawings.bodies);
    const auto result = unpack(pack(drawings));
    return !result && result.error().code == core::Code::P6004;
  };
  using Bodies = std::vector<DrawnBody>;
  EXPECT_TRUE(refused([](Bodies& b) { b[0].wires[0].to = 2; }));
  EXPECT_TRUE(refused([](Bodies& b) { b[0].wires[0].from_pin = 0; })) << "an input";
  EXPECT_TRUE(refused([](Bodies& b) { b[0].wires[0].to_pin = 3; }));
  EXPECT_TRUE(refused([](Bodies& b) { b[0].wires[0].points.resize(1); }));
  EXPECT_TRUE(refused([](Bodies& b) { b[0].elements[0].sheet = 1; }));
  EXPECT_TRUE(refused([](Bodies& b) { b[1].elements[0].macro_sheet = 2; }));
  EXPECT_TRUE(refused([](Bodies& b) { b[0].comments[0].sheet = 1; }));
  EXPECT_TRUE(refused([](Bodies& b) { b[0].elements[0].x = -1; }));
  EXPECT_TRUE(refused([](Bodies& b) { b[0].elements[0].width = kMaxDrawn + 1; }));
  EXPECT_TRUE(refused([](Bodies& b) { b[2].statements[0].end_column = 0; }));
  EXPECT_FALSE(refused([](Bodies&) {}));
}

TEST(Drawings, AFewBytesDoNotUnpackToALot) {
  // A count that the bytes cannot hold.
  std::vector<std::byte> content(4, std::byte{0xff});
  EXPECT_FALSE(unpack(plain(content)));
  // A size that the stored bytes are too few for.
  std::vector<std::byte> bytes = pack(sample());
  ASSERT_EQ(bytes[0], std::byte{1});
  store_le(bytes.data() + 1, std::uint64_t{1} << 29);
  EXPECT_FALSE(unpack(bytes));
  store_le(bytes.data() + 1, std::uint64_t{UINT64_MAX});
  EXPECT_FALSE(unpack(bytes));
}

TEST(Drawings, AreASectionOfAnImageThatSaysNothingAboutWhatItDoes) {
  Sample s = sample_image();
  const std::vector<std::byte> without = save(s.image);
  const std::uint64_t print = fingerprint(s.image);
  const Image plain_image = s.image;
  s.image.drawings = pack(sample());
  EXPECT_EQ(fingerprint(s.image), print);
  EXPECT_EQ(difference(s.image, plain_image), "");
  std::vector<std::byte> with = save(s.image);
  EXPECT_EQ(with.size(), without.size() + format::kSectionHeaderBytes + s.image.drawings.size());
  auto loaded = load(with);
  ASSERT_TRUE(loaded) << loaded.error().message;
  EXPECT_EQ(loaded->drawings, s.image.drawings);
  EXPECT_EQ(save(*loaded), with);
  const auto listed = assemble(disassemble(s.image));
  ASSERT_TRUE(listed) << listed.error().message;
  EXPECT_EQ(save(*listed), with);
  core::Diagnostics diagnostics;
  EXPECT_TRUE(verify(std::move(*loaded), diagnostics));

  s.image.frozen_addresses = "path,table,address,type\n\"a,b\",coils,16384,BOOL\n";
  EXPECT_TRUE(load(save(s.image)));
  // Damaged ones are refused like any other section.
  s.image.drawings[0] = std::byte{7};
  const auto damaged = load(save(s.image));
  ASSERT_FALSE(damaged);
  EXPECT_EQ(damaged.error().code, core::Code::P6004);
  EXPECT_EQ(damaged.error().message, "section 10 of the image does not make sense");
  // A section that nobody knows, and one that is there twice.
  const std::size_t section = without.size();
  std::vector<std::byte> wrong = with;
  wrong[section] = std::byte{11};
  reseal(wrong);
  EXPECT_FALSE(load(wrong));
  wrong = with;
  wrong.insert(wrong.end(), with.begin() + static_cast<std::ptrdiff_t>(section), with.end());
  wrong[format::kSectionCountAt] = std::byte{10};
  reseal(wrong);
  EXPECT_FALSE(load(wrong));
}

TEST(Drawings, KeysNameEveryPlace) {
  const Drawings drawings = sample();
  const DrawnElement& block = drawings.bodies[0].elements[1];
  EXPECT_EQ(key_of(3, block), (DrawnKey{3, 2, 7, 3, 0, DrawnSide::kWhole}));
  EXPECT_EQ(key_of(3, block, block.pins[1]), (DrawnKey{3, 2, 7, 3, 1, DrawnSide::kInput}));
  EXPECT_EQ(key_of(3, block, block.pins[2]), (DrawnKey{3, 2, 7, 3, 0, DrawnSide::kOutput}));
  EXPECT_EQ(key_of(3, drawings.bodies[1].elements[0], std::size_t{0}), (DrawnKey{3, -1, 12, 5, 0, DrawnSide::kWhole}));
  EXPECT_EQ(key_of(3, drawings.bodies[2].statements[1]), (DrawnKey{3, -1, 4, 1, 0, DrawnSide::kWhole}));
  DrawnElement step;
  step.kind = core::ElementKind::kStep;
  step.local_id = 9;
  step.line = 40;
  step.actions = {{"main", "Heat", "", "", 0, 0}};
  EXPECT_EQ(key_of(3, step, std::size_t{0}), (DrawnKey{3, 9, 40, 0, 2, DrawnSide::kWhole}));
}

}  // namespace
}  // namespace plc::test
