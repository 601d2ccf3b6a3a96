// What a Modbus answer must look like, said independently of the handler: for tests and the fuzzer.
//
// In: request and response PDUs. Out: whether the request is well-formed (MODBUS Application Protocol V1.1b3), and
// whether the response fits it. Does not belong here: which addresses exist.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace plc::test {

using Bytes = std::span<const std::uint8_t>;

inline std::uint32_t word_at(Bytes bytes, std::size_t at) {
  return static_cast<std::uint32_t>(bytes[at]) * 256u + bytes[at + 1];
}

inline bool serves(unsigned function) {
  for (const unsigned known : {1u, 2u, 3u, 4u, 5u, 6u, 15u, 16u, 22u, 23u, 43u}) {
    if (known == function) return true;
  }
  return false;
}

/// Whether `request` is one that some server could answer normally.
inline bool well_formed(Bytes request) {
  const std::size_t n = request.size();
  if (n == 0) return false;
  const auto in = [](std::uint32_t value, std::uint32_t most) { return value >= 1 && value <= most; };
  switch (request[0]) {
    case 1:
    case 2:
    case 3:
    case 4:
      return n == 5 && in(word_at(request, 3), request[0] < 3 ? 2000 : 125) &&
             word_at(request, 1) + word_at(request, 3) <= 65536;
    case 5:
      return n == 5 && (word_at(request, 3) == 0 || word_at(request, 3) == 0xff00);
    case 6:
      return n == 5;
    case 15:
    case 16: {
      if (n < 6) return false;
      const std::uint32_t count = word_at(request, 3);
      const std::uint32_t bytes = request[0] == 15 ? (count + 7) / 8 : 2 * count;
      return in(count, request[0] == 15 ? 1968 : 123) && request[5] == bytes && n == 6 + bytes &&
             word_at(request, 1) + count <= 65536;
    }
    case 22:
      return n == 7;
    case 23:
      return n >= 10 && in(word_at(request, 3), 125) && in(word_at(request, 7), 121) &&
             request[9] == 2 * word_at(request, 7) && n == 10 + 2 * word_at(request, 7) &&
             word_at(request, 1) + word_at(request, 3) <= 65536 && word_at(request, 5) + word_at(request, 7) <= 65536;
    case 43:
      return n == 4 && request[1] == 14 && in(request[2], 4);
    default:
      return false;
  }
}

/// Empty when `response` is an answer to `request`; else what is wrong with it.
inline std::string complaint(Bytes request, Bytes response) {
  if (response.size() < 2 || response.size() > 253) return "answer of " + std::to_string(response.size()) + " bytes";
  const std::uint8_t function = request.empty() ? std::uint8_t{0} : request[0];
  if (response[0] == (function | 0x80) && response.size() == 2) {
    const bool known = response[1] == 1 || response[1] == 2 || response[1] == 3 || response[1] == 4 || response[1] == 6;
    if (!known) return "exception " + std::to_string(response[1]);
    if ((response[1] == 1) == (serves(function) && !(function == 43 && (request.size() < 2 || request[1] != 14)))) {
      return "exception 1 is for functions that are not served, and for nothing else";
    }
    return {};
  }
  if (response[0] != function) return "function " + std::to_string(response[0]);
  if (!well_formed(request)) return "normal answer to a malformed request";
  std::size_t size = 0;
  switch (function) {
    case 1:
    case 2:
      size = 2 + (word_at(request, 3) + 7) / 8;
      break;
    case 3:
    case 4:
    case 23:
      size = 2 + 2 * word_at(request, 3);
      break;
    case 43: {
      size = 7;
      for (unsigned i = 0; i < (response.size() > 6 ? response[6] : 0u); ++i) {
        if (size + 2 > response.size()) return "object outside of the answer";
        size += 2u + response[size + 1];
      }
      return size == response.size() ? "" : "objects do not fill the answer";
    }
    default:
      size = function == 22 ? 7 : 5;
      for (std::size_t i = 0; i < size && i < response.size(); ++i) {
        if (response[i] != request[i]) return "echo differs";
      }
      return response.size() == size ? "" : "echo of " + std::to_string(response.size()) + " bytes";
  }
  if (response.size() != size) return "answer of " + std::to_string(response.size()) + " bytes";
  return response[1] == size - 2 ? "" : "byte count differs";
}

}  // namespace plc::test
