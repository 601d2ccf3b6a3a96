// ST made from a seed, for measuring the compiler: what projects look like, and what no project looks like.
//
// In: a size and a seed. Out: texts; equal inputs give equal bytes. Does not belong here: measuring (compile.cpp).
#pragma once

#include <cstdint>
#include <string>

namespace plc::bench {

/// A project of at least `lines` lines that compiles: structures, enumerations, functions, function blocks of about
/// sixty lines that call each other, a program with an instance of each, a configuration.
std::string make_project(std::uint32_t lines, std::uint64_t seed);

/// One program of at least `bytes` bytes of statements, which compiles.
std::string make_statements(std::size_t bytes, std::uint64_t seed);

enum class Garbage : std::uint8_t {
  kBytes,
  kTokens,
  kMutated,
  kParentheses,
  kNestedIf,
  kOpenComment,
  kOneLine,
  kErrors
};
inline constexpr int kGarbageCount = 8;
std::string garbage_name(Garbage kind);
/// `bytes` bytes that do not compile.
std::string make_garbage(Garbage kind, std::size_t bytes, std::uint64_t seed);

}  // namespace plc::bench
