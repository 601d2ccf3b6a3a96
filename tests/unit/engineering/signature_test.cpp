// Keys and signatures of images.
#include "engineering/signature.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "tests/support/run_tool.h"

namespace plc::test {
namespace {

using core::Code;
using engineering::make_key;
using engineering::read_public_keys;
using engineering::read_secret_key;
using engineering::sign;
using engineering::signer_of;

/// RFC 8032, 7.1, test 3: the message 0xaf82 and what is to come out.
TEST(Signature, IsEd25519) {
  const auto key = read_secret_key(
      "# of the RFC\npicard-ed25519-secret c5aa8df43f9f837bedb7442f31dcb7b166d38535076f094b85ce3a2e0b4458f7 rfc\n",
      "rfc");
  ASSERT_TRUE(key);
  EXPECT_EQ(key->public_line(),
            "picard-ed25519 fc51cd8e6218a1a38da47ed00230f0580816ed13ba3303ac5deb911548908025 rfc\n");
  EXPECT_EQ(
      sign(*key, "\xaf\x82"),
      "6291d657deec24024827e69c3abe01a30ce548a284743a445e3680d7db5ac3ac18ff9b538d16f290ae67f760984dc6594a7c15e9716ed28d"
      "c027beceea1ec40a");
}

TEST(Signature, CountsForItsKeyAndItsBytesAlone) {
  const auto anna = make_key("anna"), ben = make_key("ben");
  const auto keys = read_public_keys(anna.public_line() + "\n# another\n" + ben.public_line(), "keys");
  ASSERT_TRUE(keys);
  ASSERT_EQ(keys->size(), 2u);
  const std::string image = "an image", signature = sign(ben, image);
  const auto* signer = signer_of(*keys, image, signature);
  ASSERT_NE(signer, nullptr);
  EXPECT_EQ(signer->name, "ben");
  EXPECT_EQ(signer_of(*keys, "an imagf", signature), nullptr);
  EXPECT_EQ(signer_of(*keys, image, sign(make_key("eve"), image)), nullptr);
  for (std::size_t i = 0; i < signature.size(); ++i) {
    std::string changed = signature;
    changed[i] = changed[i] == '0' ? '1' : '0';
    EXPECT_EQ(signer_of(*keys, image, changed), nullptr) << i;
  }
  for (const std::string& none : {std::string(), signature.substr(1), signature + "0", std::string(128, 'x')})
    EXPECT_EQ(signer_of(*keys, image, none), nullptr) << none;
  EXPECT_EQ(signer_of({}, image, signature), nullptr);
}

TEST(Signature, KeysAreReadFromFilesAndFolders) {
  const ScratchFolder folder;
  const auto anna = make_key("anna"), ben = make_key("ben");
  EXPECT_EQ(read_secret_key(anna.line(), "anna.key")->seed, anna.seed);
  EXPECT_EQ(read_secret_key(anna.public_line(), "anna.pub").error().code, Code::P7754);
  EXPECT_EQ(engineering::read_public_key_files(folder.file("none")).error().code, Code::P7754);
  std::filesystem::create_directory(folder.file("keys"));
  EXPECT_EQ(engineering::read_public_key_files(folder.file("keys")).error().code, Code::P7754)
      << "nobody may upload by oversight";
  std::ofstream(folder.file("keys/ben.pub")) << ben.public_line();
  std::ofstream(folder.file("keys/anna.pub")) << anna.public_line();
  std::ofstream(folder.file("keys/note.txt")) << "not read";
  const auto keys = engineering::read_public_key_files(folder.file("keys"));
  ASSERT_TRUE(keys) << keys.error().message;
  ASSERT_EQ(keys->size(), 2u);
  EXPECT_EQ((*keys)[0].name, "anna");
  std::ofstream(folder.file("keys/eve.pub")) << anna.line();
  EXPECT_EQ(engineering::read_public_key_files(folder.file("keys")).error().code, Code::P7754)
      << "a secret key is no public one";
}

}  // namespace
}  // namespace plc::test
