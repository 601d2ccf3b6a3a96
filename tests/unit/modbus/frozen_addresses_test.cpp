// Automatic addresses stay where they are, whatever happens to the project.
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "tests/unit/modbus/map_support.h"

namespace plc::test {
namespace {

/// The lock file after a build of these variables, in order.
std::string freeze(std::initializer_list<std::pair<const char*, TypeId>> variables,
                   const FrozenAddresses& before = {}) {
  MapFixture f;
  for (const auto& [name, type] : variables) f.variable(name, type);
  f.frozen = before;
  f.build();
  EXPECT_TRUE(f.map) << f.said();
  const std::string text = modbus::frozen_text(f.frozen);
  return text.substr(text.find("path,"));
}

class LockFile : public testing::Test {
 protected:
  core::Result<FrozenAddresses> read(const std::string& text) {
    std::ofstream(file_, std::ios::binary) << text;
    return modbus::read_frozen(file_);
  }
  /// Reads what must be readable.
  FrozenAddresses parsed(const std::string& text) {
    auto frozen = read(text);
    EXPECT_TRUE(frozen) << frozen.error().message;
    return frozen ? *frozen : FrozenAddresses{};
  }
  void SetUp() override {
    file_ = (std::filesystem::temp_directory_path() / ("plc-lock-" + std::to_string(::getpid()) + ".csv")).string();
  }
  void TearDown() override { std::filesystem::remove(file_); }
  std::string file_;
};

TEST_F(LockFile, WhatWasWrittenIsReadBack) {
  const std::string text = freeze({{"A", TypeId::kInt}, {"B", TypeId::kReal}, {"C", TypeId::kBool}});
  EXPECT_EQ(text,
            "path,table,address,type\n"
            "C,coils,16384,BOOL\n"
            "A,holding-registers,16384,INT\n"
            "B,holding-registers,16386,REAL\n");
  FrozenAddresses frozen = parsed(text);
  EXPECT_FALSE(frozen.changed);
  EXPECT_EQ(freeze({{"A", TypeId::kInt}, {"B", TypeId::kReal}, {"C", TypeId::kBool}}, frozen), text);
}

TEST_F(LockFile, AnImageBringsItsAddresses) {
  bytecode::Image image;
  image.frozen_addresses = "path,table,address,type\nA,holding-registers,16400,INT\n";
  const auto both = [&](const std::string& text) {
    std::filesystem::remove(file_);
    if (!text.empty()) std::ofstream(file_, std::ios::binary) << text;
    const auto frozen = modbus::read_frozen(file_, image);
    if (!frozen) return std::string(core::info(frozen.error().code).name) + ": " + frozen.error().message;
    return modbus::frozen_text(*frozen).substr(modbus::frozen_text(*frozen).find("type\n") + 5);
  };
  EXPECT_EQ(both(""), "A,holding-registers,16400,INT\n") << "no file beside it";
  EXPECT_EQ(both("path,table,address,type\na,holding-registers,16400,INT\nB,holding-registers,16401,INT\n"),
            "A,holding-registers,16400,INT\nB,holding-registers,16401,INT\n")
      << "the file may have more, and letter case does not count";
  EXPECT_EQ(both("path,table,address,type\nA,holding-registers,16384,INT\n"),
            "P7507: " + file_ + ": \"A\" is at holding-registers 16384, and the image was compiled with " +
                "holding-registers 16400");
  image.frozen_addresses = "rubbish";
  EXPECT_EQ(both("").substr(0, 36), "P7501: frozen addresses of the image");
  image.frozen_addresses.clear();
  EXPECT_EQ(both("path,table,address,type\nA,holding-registers,16384,INT\n"), "A,holding-registers,16384,INT\n");
}

TEST_F(LockFile, NewVariablesInFrontMoveNothing) {
  const FrozenAddresses frozen = parsed(freeze({{"A", TypeId::kInt}, {"B", TypeId::kInt}}));
  EXPECT_EQ(freeze({{"New", TypeId::kInt}, {"B", TypeId::kInt}, {"A", TypeId::kInt}}, frozen),
            "path,table,address,type\n"
            "A,holding-registers,16384,INT\n"
            "B,holding-registers,16385,INT\n"
            "New,holding-registers,16386,INT\n");
}

TEST_F(LockFile, GoneVariablesKeepTheirAddress) {
  const FrozenAddresses frozen = parsed(freeze({{"A", TypeId::kInt}, {"B", TypeId::kInt}}));
  EXPECT_EQ(freeze({{"B", TypeId::kInt}, {"New", TypeId::kInt}}, frozen),
            "path,table,address,type\n"
            "A,holding-registers,16384,INT\n"
            "B,holding-registers,16385,INT\n"
            "New,holding-registers,16386,INT\n");
}

TEST_F(LockFile, AnotherSizeIsAnotherAddress) {
  const FrozenAddresses frozen = parsed(freeze({{"A", TypeId::kInt}, {"B", TypeId::kInt}, {"C", TypeId::kInt}}));
  EXPECT_EQ(freeze({{"A", TypeId::kInt}, {"B", TypeId::kReal}, {"C", TypeId::kUint}}, frozen),
            "path,table,address,type\n"
            "A,holding-registers,16384,INT\n"
            "C,holding-registers,16386,UINT\n"
            "B,holding-registers,16388,REAL\n");
}

TEST_F(LockFile, LetterCaseOfANameDoesNotCount) {
  const FrozenAddresses frozen = parsed(freeze({{"A", TypeId::kInt}, {"Level", TypeId::kInt}}));
  MapFixture f;
  f.variable("LEVEL", TypeId::kInt);
  f.frozen = frozen;
  f.build();
  EXPECT_EQ(f.place("LEVEL"), "holding-registers 16385*");
  EXPECT_FALSE(f.frozen.changed);
}

TEST_F(LockFile, ItsTableCountsBeforeTheRights) {
  MapFixture f;
  f.b.global("Limit", f.b.type(TypeId::kInt), {}, {.constant = true});
  f.frozen = parsed("path,table,address,type\nLimit,holding-registers,20000,INT\n");
  f.build();
  EXPECT_EQ(f.place("Limit"), "holding-registers 20000*");
  EXPECT_FALSE(f.point("Limit")->writable);
}

TEST_F(LockFile, AMissingOneIsEmpty) {
  const auto frozen = modbus::read_frozen(file_ + ".not-there");
  ASSERT_TRUE(frozen);
  EXPECT_TRUE(frozen->entries.empty());
}

TEST_F(LockFile, CommentsAndQuotesAreFine) {
  const FrozenAddresses frozen = parsed("# note\npath,table,address,type\n\"a,b\",coils,16390,BOOL\n");
  ASSERT_EQ(frozen.entries.count("a,b"), 1u);
  EXPECT_EQ(frozen.entries.at("a,b").address, 16390);
}

TEST_F(LockFile, NonsenseIsRefusedWithItsLine) {
  const std::string head = "path,table,address,type\nA,holding-registers,16384,DINT\n";
  struct Row {
    const char* line;
    const char* code;
    const char* message;
  };
  const Row rows[] = {
      {"B,holding-registers,16386", "P7501", "3 cells"},
      {",holding-registers,16386,INT", "P7501", "no path"},
      {"B,holding,16386,INT", "P7501", "\"holding\" is no table"},
      {"B,holding-registers,16386,INTEGER", "P7501", "\"INTEGER\" is no type"},
      {"B,holding-registers,16386,STRING", "P7501", "\"STRING\" is no type"},
      {"B,holding-registers,16386,BOOL", "P7501", "BOOL in holding-registers"},
      {"B,coils,16386,INT", "P7501", "INT in coils"},
      {"B,holding-registers,1024,INT", "P7501", "\"1024\" is no address"},
      {"B,holding-registers,65535,REAL", "P7501", "16384 to 65534"},
      {"B,holding-registers,99999999999,INT", "P7501", "is no address"},
      {"B,holding-registers,-1,INT", "P7501", "is no address"},
      {"B,holding-registers,0x4000,INT", "P7501", "is no address"},
      {"B,holding-registers,16385,INT", "P7502", "16385 of \"B\" belongs to \"A\" in line 2"},
      {"a,holding-registers,16390,INT", "P7502", "has an address already, in line 2"},
      {"\"B,holding-registers,16390,INT", "P7501", ":3"},
  };
  for (const Row& row : rows) {
    const auto frozen = read(head + row.line + "\n");
    ASSERT_FALSE(frozen) << row.line;
    EXPECT_EQ(core::info(frozen.error().code).name, row.code) << row.line;
    EXPECT_NE(frozen.error().message.find(row.message), std::string::npos)
        << row.line << ": " << frozen.error().message;
    EXPECT_NE(frozen.error().message.find(file_ + ":3"), std::string::npos)
        << row.line << ": " << frozen.error().message;
  }
  EXPECT_FALSE(read("something else\n"));
  EXPECT_FALSE(modbus::read_frozen(std::filesystem::temp_directory_path().string())) << "a folder";
}

TEST_F(LockFile, LiesBesideTheProjectOrWherePlcTomlSays) {
  io::Configuration configuration;
  EXPECT_EQ(modbus::lock_file_of(configuration, "plants/tank.xml"), "plants/tank.modbus.csv");
  EXPECT_EQ(modbus::lock_file_of(configuration, "tank.pbc"), "tank.modbus.csv");
  configuration.file = "etc/plc.toml";
  EXPECT_EQ(modbus::lock_file_of(configuration, "plants/tank.xml"), "plants/tank.modbus.csv");
  configuration.modbus.lock_file.text = "frozen.csv";
  EXPECT_EQ(modbus::lock_file_of(configuration, "plants/tank.xml"), "etc/frozen.csv");
  configuration.modbus.lock_file.text = "/var/lib/frozen.csv";
  EXPECT_EQ(modbus::lock_file_of(configuration, "plants/tank.xml"), "/var/lib/frozen.csv");
}

TEST_F(LockFile, EntriesThatOverlapGiveNoMap) {
  MapFixture f;
  f.variable("A", TypeId::kReal);
  f.variable("B", TypeId::kReal);
  f.frozen.entries["A"] = {Table::kHoldingRegisters, 16384, TypeId::kReal};
  f.frozen.entries["B"] = {Table::kHoldingRegisters, 16385, TypeId::kReal};
  f.build();
  EXPECT_FALSE(f.map);
  EXPECT_NE(f.said().find("P7502"), std::string::npos) << f.said();
}

}  // namespace
}  // namespace plc::test
