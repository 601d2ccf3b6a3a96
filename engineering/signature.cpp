#include "engineering/signature.h"

#include <fmt/format.h>
#include <sodium.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <optional>

#include "core/text.h"
#include "engineering/state_files.h"

namespace plc::engineering {
namespace {

namespace fs = std::filesystem;
using core::Code;
using core::Problem;

constexpr std::string_view kPublic = "picard-ed25519", kSecret = "picard-ed25519-secret";
constexpr const char* kForm = "a line \"picard-ed25519 KEY NAME\", as plc sign --make-key writes it into NAME.pub";

void prepare() {
  if (sodium_init() < 0) std::abort();
}

const unsigned char* raw(std::string_view bytes) { return reinterpret_cast<const unsigned char*>(bytes.data()); }

std::string hexadecimal(std::string_view bytes) {
  std::string text(bytes.size() * 2 + 1, '\0');
  sodium_bin2hex(text.data(), text.size(), raw(bytes), bytes.size());
  text.pop_back();
  return text;
}

/// `size` bytes of twice as many digits.
std::optional<std::string> bytes_of(std::string_view digits, std::size_t size) {
  std::string bytes(size, '\0');
  std::size_t read = 0;
  const bool good =
      digits.size() == size * 2 && sodium_hex2bin(reinterpret_cast<unsigned char*>(bytes.data()), size, digits.data(),
                                                  digits.size(), nullptr, &read, nullptr) == 0;
  return good && read == size ? std::optional(std::move(bytes)) : std::nullopt;
}

struct KeyLine {
  std::string bytes, name;
};
/// "KIND DIGITS NAME"
std::optional<KeyLine> key_of(std::string_view line, std::string_view kind) {
  const std::size_t blank = line.find(' ');
  if (line.substr(0, blank) != kind || blank == std::string_view::npos) return std::nullopt;
  line = core::trimmed(line.substr(blank));
  const std::size_t end = std::min(line.find(' '), line.size());
  auto bytes = bytes_of(line.substr(0, end), crypto_sign_SEEDBYTES);
  if (!bytes) return std::nullopt;
  return KeyLine{std::move(*bytes), std::string(core::trimmed(line.substr(end)))};
}

/// Calls each(line) for lines with something in them, until it gives false.
template <class Each>
void for_each_line(std::string_view text, Each each) {
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = core::trimmed(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    if (!line.empty() && line.front() != '#' && !each(line)) return;
  }
}

struct Pair {
  std::array<unsigned char, crypto_sign_PUBLICKEYBYTES> open{};
  std::array<unsigned char, crypto_sign_SECRETKEYBYTES> secret{};
};
Pair pair_of(const SecretKey& key) {
  prepare();
  Pair pair;
  crypto_sign_seed_keypair(pair.open.data(), pair.secret.data(), raw(key.seed));
  return pair;
}

}  // namespace

std::string SecretKey::line() const { return fmt::format("{} {} {}\n", kSecret, hexadecimal(seed), name); }

std::string SecretKey::public_line() const {
  const Pair pair = pair_of(*this);
  const std::string_view open(reinterpret_cast<const char*>(pair.open.data()), pair.open.size());
  return fmt::format("{} {} {}\n", kPublic, hexadecimal(open), name);
}

SecretKey make_key(std::string name) {
  prepare();
  SecretKey key{std::string(crypto_sign_SEEDBYTES, '\0'), std::move(name)};
  randombytes_buf(key.seed.data(), key.seed.size());
  return key;
}

core::Result<SecretKey> read_secret_key(std::string_view text, const std::string& what) {
  std::optional<SecretKey> key;
  for_each_line(text, [&](std::string_view line) {
    if (auto found = key_of(line, kSecret)) key = SecretKey{std::move(found->bytes), std::move(found->name)};
    return !key;
  });
  if (key) return std::move(*key);
  return Problem{Code::P7754, what + " holds no secret key", "plc sign --make-key NAME makes NAME.key and NAME.pub"};
}

core::Result<std::vector<PublicKey>> read_public_keys(std::string_view text, const std::string& what) {
  std::vector<PublicKey> keys;
  bool wrong = false;
  for_each_line(text, [&](std::string_view line) {
    auto found = key_of(line, kPublic);
    wrong = !found;
    if (found) keys.push_back({std::move(found->bytes), std::move(found->name)});
    return !wrong;
  });
  if (wrong) return Problem{Code::P7754, what + " has a line that is no public key", kForm};
  if (keys.empty()) return Problem{Code::P7754, what + " holds no public key", kForm};
  return keys;
}

core::Result<std::vector<PublicKey>> read_public_key_files(const std::string& path) {
  std::error_code error;
  std::vector<std::string> files;
  if (fs::is_directory(path, error)) {
    for (fs::directory_iterator file(path, error), end; !error && file != end; file.increment(error)) {
      if (file->path().extension() == ".pub") files.push_back(file->path().string());
    }
    if (error) return Problem{Code::P7754, fmt::format("cannot read {}: {}", path, error.message()), {}};
    if (files.empty()) return Problem{Code::P7754, path + " holds no file *.pub", kForm};
    std::sort(files.begin(), files.end());
  } else {
    files.push_back(path);
  }
  std::vector<PublicKey> keys;
  for (const std::string& file : files) {
    std::string why;
    const auto text = read_whole_file(file, why);
    if (!text) return Problem{Code::P7754, why.empty() ? "there is no file " + file : why, {}};
    auto found = read_public_keys(*text, file);
    if (!found) return found;
    std::move(found->begin(), found->end(), std::back_inserter(keys));
  }
  return keys;
}

std::string sign(const SecretKey& key, std::string_view bytes) {
  const Pair pair = pair_of(key);
  std::string signature(crypto_sign_BYTES, '\0');
  crypto_sign_detached(reinterpret_cast<unsigned char*>(signature.data()), nullptr, raw(bytes), bytes.size(),
                       pair.secret.data());
  return hexadecimal(signature);
}

const PublicKey* signer_of(const std::vector<PublicKey>& keys, std::string_view bytes, std::string_view signature) {
  prepare();
  const auto made = bytes_of(signature, crypto_sign_BYTES);
  if (!made) return nullptr;
  const auto found = std::find_if(keys.begin(), keys.end(), [&](const PublicKey& key) {
    return crypto_sign_verify_detached(raw(*made), raw(bytes), bytes.size(), raw(key.bytes)) == 0;
  });
  return found == keys.end() ? nullptr : &*found;
}

}  // namespace plc::engineering
