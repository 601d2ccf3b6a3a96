// Layout: what a program keeps over a restart, by names and types.
//
// In: a loaded resource, or the bytes of a file. Out: variables in one order, their types, where each is in a set of
// values. RETAIN and PERSISTENT count with all that is in the variable, NON_RETAIN in it excepted (IEC 61131-3:2013,
// 6.5.6); references, pointers, constants and taskblocks are not kept. The list follows from the marks of the image's
// fields, so an image holds it once. Does not belong here: values (carry.h), files (store.h), threads (keeper.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bytecode/image.h"
#include "runtime/resource.h"

namespace plc::retain {

/// What a restart keeps: each keeps what the next one keeps, and more.
enum class Start : std::uint8_t {
  kWarm,    ///< RETAIN and PERSISTENT
  kCold,    ///< PERSISTENT
  kOrigin,  ///< nothing
};

/// A variable that is kept whole, but for what is marked otherwise inside of it.
struct Root {
  std::string path;         ///< "Main.Count", "GVL.Recipe", "Main.Valves[3].Strokes"
  std::uint32_t type = 0;   ///< into Layout::types
  std::uint64_t at = 0;     ///< bytes from the start of a set of values
  bool persistent = false;  ///< else RETAIN
  bool internal = false;    ///< ImageField::internal, of it or of what it is in
};

struct Layout {
  std::string project;
  std::uint64_t program = 0;  ///< bytecode::fingerprint() of the image
  /// As in an image, each built from types of lower index; references have no target, and nothing is without bytes.
  std::vector<bytecode::ImageType> types;
  std::vector<Root> roots;  ///< ascending `at`, without overlaps
  std::uint64_t bytes = 0;  ///< of a set of values
};

/// Where the variable of a root is.
struct Source {
  static constexpr std::uint32_t kShared = 0xffffffffu;
  std::uint32_t task = kShared;  ///< whose table has the newest value, or kShared: the global table
  std::uint32_t offset = 0;      ///< in the global table or the instance of the task
  bool global = false;           ///< `offset` is one of the global table
};

/// What a resource keeps.
struct Kept {
  Layout layout;
  std::vector<Source> sources;  ///< by root; those of one task side by side, shared ones last
};
/// Which variables count.
enum class What : std::uint8_t {
  kMarked,      ///< RETAIN and PERSISTENT
  kEverything,  ///< all, as if they were RETAIN: the state to begin a test with
};
Kept find_kept(const runtime::Resource& resource, What what = What::kMarked);

/// True for references and pointers: what they refer to is another thing after a restart.
bool is_reference(const bytecode::ImageType& type);

/// Stored form; equal bytes: the same layout.
std::vector<std::byte> encode(const Layout& layout);
/// Nothing when the bytes are no layout, or not a sound one: types whose parts lie inside of them, roots inside of the
/// set of values.
std::optional<Layout> decode(std::span<const std::byte> bytes);

}  // namespace plc::retain
