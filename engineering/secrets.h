// Secrets: random texts, hashes and passwords, by libsodium.
//
// Threads: any. Does not belong here: who has which password (users.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace plc::engineering {

/// 32 random bytes as 43 letters, digits, - and _: a session or a token. Nobody guesses it.
std::string random_secret();
/// "ABCD-EFGH-JKLM": 58 random bits for people to type; without letters that look like others.
std::string random_code();
/// `text` in capitals, and only what codes consist of.
std::string plain_code(std::string_view text);

/// BLAKE2b of 32 bytes, as 64 hexadecimal digits: under which a secret is known.
std::string hash_of_secret(std::string_view secret);
/// SHA-256 as 64 hexadecimal digits.
std::string sha256(std::string_view bytes);
/// That of a file's content, which is read in pieces; empty when it cannot be read.
std::string sha256_of_file(const std::string& path);
/// Equal, in a time that does not tell where they differ.
bool same_secret(std::string_view a, std::string_view b);

/// How much a password costs to check. The default takes 32 MB and about 0.1 s.
struct PasswordCost {
  std::uint64_t operations = 3;
  std::size_t bytes = std::size_t{32} << 20;
};
/// argon2id with a random salt, as a text; empty when there is no memory for it.
std::string hash_password(std::string_view password, const PasswordCost& cost);

enum class PasswordCheck : std::uint8_t { kRight, kWrong, kNoMemory };
/// Takes as long as hash_password().
PasswordCheck check_password(const std::string& hash, std::string_view password);

}  // namespace plc::engineering
