// The certificate of the server: given, or made at the first start and kept.
//
// In: files in PEM, or a folder. Out: PEM texts and the fingerprint by which people know a certificate that nobody has
// signed. Threads: any; blocks on the disk. Does not belong here: TLS itself (server.cpp).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/clock.h"
#include "core/result.h"

namespace plc::engineering {

struct Certificate {
  std::string chain;             ///< PEM, the server's own first
  std::string key;               ///< PEM
  std::string fingerprint;       ///< SHA-256 of the certificate: "AB:CD:.."
  std::int64_t until_utc_s = 0;  ///< the last second in which it is valid, since 1970
  bool made = false;             ///< by this call
};

/// Reads both files. P7703 when they cannot be read, are no PEM or do not belong together.
core::Result<Certificate> read_certificate(const std::string& chain_file, const std::string& key_file);
/// The certificate in `folder`, or a new one when there is none or it ends within a month: ECDSA P-256, signed by
/// itself, for these names and addresses, ten years. Kept in `folder`, unless that is empty.
core::Result<Certificate> own_certificate(const std::string& folder, const std::vector<std::string>& names,
                                          core::TimeNs utc_ns);

}  // namespace plc::engineering
