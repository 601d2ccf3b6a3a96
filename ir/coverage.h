// Coverage: which drawn and written alternatives of a project were seen to happen.
//
// In: front ends that lower a module with a Coverage (--coverage of plc test): they add a site for each contact, coil,
// rung and branch, and instructions that note its outcomes. Out: the sites, and one hidden global, an array of BOOL
// with an element for each outcome that was seen. Without a Coverage nothing of this is compiled. Does not belong here:
// reading the array, tables, pictures (testing/).
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "core/source_ref.h"

namespace plc::ir {

enum class CoverKind : std::uint8_t {
#define PLC_COVER_KIND(kind, word, first, second) kind,
#include "ir/cover_kinds.def"
};
struct CoverKindInfo {
  std::string_view word;    ///< "contact"
  std::string_view first;   ///< the outcome with number 0: "closed"
  std::string_view second;  ///< the one with number 1: "open"; empty when there is only one
};
const CoverKindInfo& info(CoverKind kind);
inline constexpr std::uint32_t kCoverKinds = 0
#define PLC_COVER_KIND(kind, word, first, second) +1
#include "ir/cover_kinds.def"
    ;

struct CoverSite {
  CoverKind kind = CoverKind::kContact;
  std::string pou;         ///< its name, of an action "POU.Action"
  core::SourceRef at;      ///< the drawn element or the word of the text
  std::string text;        ///< variable of a contact or coil; head of a branch
  std::uint32_t rung = 0;  ///< of drawn ones: number of the network, from 1
};

struct Module;

/// Name of the global with the outcomes: outcome o of site s is element 2 * s + o.
inline constexpr const char* kCoverageName = "#coverage";

struct Coverage {
  std::uint32_t global = 0;  ///< into Module::globals
  std::vector<CoverSite> sites;
  /// Sites by kind, POU, place and text: a body that is lowered several times (ARRAY [*]) has its sites once.
  using Key =
      std::tuple<CoverKind, std::string, std::uint16_t, std::uint32_t, std::uint32_t, std::int64_t, std::string>;
  std::map<Key, std::uint32_t> known;
};

/// Declares the global, and makes front ends add sites from now on. Before any body of the module is lowered.
void begin_coverage(Module& module);

}  // namespace plc::ir
