#include "engineering/certificate.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <openssl/bio.h>
#include <openssl/ec.h>
#include <openssl/err.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/rand.h>
#include <openssl/x509.h>
#include <openssl/x509v3.h>

#include <array>
#include <ctime>
#include <memory>

#include "engineering/secrets.h"
#include "engineering/state_files.h"

namespace plc::engineering {
namespace {

using core::Code;
using core::Problem;

template <auto Free>
struct Freed {
  template <class T>
  void operator()(T* object) const {
    Free(object);
  }
};
using Bio = std::unique_ptr<BIO, Freed<BIO_free_all>>;
using X509Pointer = std::unique_ptr<X509, Freed<X509_free>>;
using KeyPointer = std::unique_ptr<EVP_PKEY, Freed<EVP_PKEY_free>>;
using ExtensionPointer = std::unique_ptr<X509_EXTENSION, Freed<X509_EXTENSION_free>>;

constexpr long kDay = 86'400;
constexpr core::TimeNs kSecondNs = 1'000'000'000;

std::string why_openssl() {
  const unsigned long error = ERR_get_error();
  std::array<char, 200> text{};
  ERR_error_string_n(error, text.data(), text.size());
  ERR_clear_error();
  return error == 0 ? "for an unknown reason" : text.data();
}

std::string text_of(BIO* bio) {
  char* data = nullptr;
  const long size = BIO_get_mem_data(bio, &data);
  return {data, static_cast<std::size_t>(size)};
}

X509Pointer certificate_of(const std::string& pem) {
  const Bio in(BIO_new_mem_buf(pem.data(), static_cast<int>(pem.size())));
  return X509Pointer(PEM_read_bio_X509(in.get(), nullptr, nullptr, nullptr));
}

/// Keys under a passphrase are not asked for: nobody is there to type it.
int no_passphrase(char*, int, int, void*) { return -1; }

KeyPointer key_of(const std::string& pem) {
  const Bio in(BIO_new_mem_buf(pem.data(), static_cast<int>(pem.size())));
  return KeyPointer(PEM_read_bio_PrivateKey(in.get(), nullptr, no_passphrase, nullptr));
}

std::string fingerprint_of(X509* certificate) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned size = 0;
  X509_digest(certificate, EVP_sha256(), digest.data(), &size);
  std::string text;
  for (unsigned i = 0; i < size; ++i) text += fmt::format("{}{:02X}", i == 0 ? "" : ":", digest[i]);
  return text;
}

/// Seconds since 1970.
std::int64_t end_of(X509* certificate) {
  std::tm end{};
  return ASN1_TIME_to_tm(X509_get0_notAfter(certificate), &end) == 1 ? ::timegm(&end) : 0;
}

core::Result<Certificate> check(Certificate made, const std::string& where) {
  ERR_clear_error();
  const X509Pointer certificate = certificate_of(made.chain);
  if (!certificate) return Problem{Code::P7703, where + " has no certificate in PEM: " + why_openssl(), {}};
  const KeyPointer key = key_of(made.key);
  if (!key)
    return Problem{Code::P7703, where + ": there is no key in PEM: " + why_openssl(),
                   "a key without a passphrase is needed"};
  if (X509_check_private_key(certificate.get(), key.get()) != 1) {
    ERR_clear_error();
    return Problem{Code::P7703, where + ": certificate and key do not belong together", {}};
  }
  made.fingerprint = fingerprint_of(certificate.get());
  made.until_utc_s = end_of(certificate.get());
  return made;
}

std::string alternative_names(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) {
    std::array<unsigned char, 16> bytes{};
    const bool address =
        ::inet_pton(AF_INET, name.c_str(), bytes.data()) == 1 || ::inet_pton(AF_INET6, name.c_str(), bytes.data()) == 1;
    text += fmt::format("{}{}:{}", text.empty() ? "" : ",", address ? "IP" : "DNS", name);
  }
  return text;
}

bool add_extension(X509* certificate, int kind, const std::string& value) {
  X509V3_CTX context;
  X509V3_set_ctx_nodb(&context);
  X509V3_set_ctx(&context, certificate, certificate, nullptr, nullptr, 0);
  const ExtensionPointer extension(X509V3_EXT_conf_nid(nullptr, &context, kind, value.c_str()));
  return extension && X509_add_ext(certificate, extension.get(), -1) == 1;
}

core::Result<Certificate> make_certificate(const std::vector<std::string>& names, core::TimeNs utc_ns) {
  constexpr long kYears = 10;
  ERR_clear_error();
  const KeyPointer key(EVP_EC_gen("P-256"));
  const X509Pointer certificate(X509_new());
  const auto refused = [] { return Problem{Code::P7703, "no certificate can be made: " + why_openssl(), {}}; };
  if (!key || !certificate) return refused();
  X509* const x = certificate.get();
  std::array<unsigned char, 16> serial{};
  if (RAND_bytes(serial.data(), static_cast<int>(serial.size())) != 1) return refused();
  serial[0] = static_cast<unsigned char>((serial[0] & 0x7f) | 0x40);
  const std::unique_ptr<BIGNUM, Freed<BN_free>> number(
      BN_bin2bn(serial.data(), static_cast<int>(serial.size()), nullptr));
  const time_t now = utc_ns / kSecondNs;
  X509_set_version(x, X509_VERSION_3);
  BN_to_ASN1_INTEGER(number.get(), X509_get_serialNumber(x));
  // A day before: the clocks of clients differ.
  ASN1_TIME_adj(X509_getm_notBefore(x), now, -1, 0);
  ASN1_TIME_adj(X509_getm_notAfter(x), now, static_cast<int>(kYears * 365), 0);
  X509_set_pubkey(x, key.get());
  const std::string& common = names.front();
  X509_NAME* const name = X509_get_subject_name(x);
  X509_NAME_add_entry_by_txt(name, "O", MBSTRING_ASC, reinterpret_cast<const unsigned char*>("PICARD"), -1, -1, 0);
  X509_NAME_add_entry_by_txt(name, "CN", MBSTRING_UTF8,
                             reinterpret_cast<const unsigned char*>(common.substr(0, 64).c_str()), -1, -1, 0);
  X509_set_issuer_name(x, name);
  if (!add_extension(x, NID_subject_alt_name, alternative_names(names)) ||
      !add_extension(x, NID_basic_constraints, "critical,CA:FALSE") ||
      !add_extension(x, NID_key_usage, "critical,digitalSignature") ||
      !add_extension(x, NID_ext_key_usage, "serverAuth") || X509_sign(x, key.get(), EVP_sha256()) == 0) {
    return refused();
  }
  const Bio chain(BIO_new(BIO_s_mem())), secret(BIO_new(BIO_s_mem()));
  if (PEM_write_bio_X509(chain.get(), x) != 1 ||
      PEM_write_bio_PrivateKey(secret.get(), key.get(), nullptr, nullptr, 0, nullptr, nullptr) != 1) {
    return refused();
  }
  return Certificate{text_of(chain.get()), text_of(secret.get()), fingerprint_of(x), end_of(x), true};
}

bool ends_soon(const std::string& chain, core::TimeNs utc_ns) {
  const X509Pointer certificate = certificate_of(chain);
  time_t then = utc_ns / kSecondNs + 30 * kDay;
  return !certificate || X509_cmp_time(X509_get0_notAfter(certificate.get()), &then) <= 0;
}

}  // namespace

core::Result<Certificate> read_certificate(const std::string& chain_file, const std::string& key_file) {
  Certificate given;
  for (const auto& [file, to] : {std::pair{&chain_file, &given.chain}, std::pair{&key_file, &given.key}}) {
    std::string why;
    auto text = read_whole_file(*file, why);
    if (!text)
      return Problem{Code::P7703, why.empty() ? "there is no file " + *file : why,
                     "see certificate and key under [engineering] in plc.toml"};
    *to = std::move(*text);
  }
  return check(std::move(given), chain_file);
}

core::Result<Certificate> own_certificate(const std::string& folder, const std::vector<std::string>& names,
                                          core::TimeNs utc_ns) {
  const std::string chain_file = folder + "/certificate.pem", key_file = folder + "/key.pem";
  if (!folder.empty()) {
    std::string why;
    const auto chain = read_whole_file(chain_file, why);
    const auto key = read_whole_file(key_file, why);
    if (!why.empty()) return Problem{Code::P7703, why, "plc-run must be able to read it"};
    if (chain && key && !ends_soon(*chain, utc_ns)) return check({*chain, *key, {}, 0, false}, chain_file);
  }
  auto made = make_certificate(names, utc_ns);
  if (!made || folder.empty()) return made;
  std::string why = make_private_folder(folder);
  if (why.empty()) why = write_private_file(key_file, made->key);
  if (why.empty()) why = write_private_file(chain_file, made->chain);
  if (!why.empty()) return Problem{Code::P7703, why, "the certificate is kept in the state folder"};
  return made;
}

}  // namespace plc::engineering
