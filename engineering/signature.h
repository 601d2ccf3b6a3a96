// Signatures of images: Ed25519, by libsodium.
//
// In: images, keys as lines of text. Out: signatures as 128 hexadecimal digits, or what is wrong. A public key is a
// line "picard-ed25519 <64 hexadecimal digits> NAME", a secret one "picard-ed25519-secret <64> NAME"; lines that begin
// with
// '#' are comments. Threads: any. Does not belong here: which keys count (io-drivers/config), who may upload.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"

namespace plc::engineering {

struct PublicKey {
  std::string bytes;  ///< 32
  std::string name;   ///< of who has the other half
};
struct SecretKey {
  std::string seed;  ///< 32 bytes
  std::string name;
  /// The line of the other half, with a line feed.
  [[nodiscard]] std::string public_line() const;
  /// Its own line, with a line feed.
  [[nodiscard]] std::string line() const;
};

/// A key that nobody has had before.
SecretKey make_key(std::string name);
/// P7754 when `text` has no secret key; `what` names it in the message.
core::Result<SecretKey> read_secret_key(std::string_view text, const std::string& what);
/// All keys of a text; P7754 for a line that is none, and for a text without any.
core::Result<std::vector<PublicKey>> read_public_keys(std::string_view text, const std::string& what);
/// The keys of a file, or of all files "*.pub" of a folder, in the order of their names; P7754.
core::Result<std::vector<PublicKey>> read_public_key_files(const std::string& path);

/// 128 hexadecimal digits.
std::string sign(const SecretKey& key, std::string_view bytes);
/// The key by which `signature` was made for `bytes`; null when none of them has made it.
const PublicKey* signer_of(const std::vector<PublicKey>& keys, std::string_view bytes, std::string_view signature);

}  // namespace plc::engineering
