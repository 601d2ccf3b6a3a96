// The parts of verify(), one per concern. Each assumes what the parts before it have established, so verify() stops
// after the first part that broke a rule.
//
// In: an image that may be wrong in every number. Out: broken rules. Internal to bytecode/verify*.cpp.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <unordered_map>
#include <vector>

#include "bytecode/image.h"
#include "bytecode/rules.h"
#include "bytecode/type_map.h"
#include "core/diagnostics.h"
#include "stdlib/library.h"

namespace plc::bytecode {

/// Where the verifier writes what it finds.
class Report {
 public:
  Report(const Image& image, core::Diagnostics& diagnostics) : image_(image), diagnostics_(diagnostics) {}
  /// `what` was found, which breaks `rule`.
  void broken(Rule rule, const std::string& what);
  /// In the code of `pou` at `word`: the drawn element is named when the debug entries know it.
  void broken(Rule rule, const ImagePou& pou, std::size_t word, const std::string& what);
  [[nodiscard]] bool clean() const { return count_ == 0; }
  [[nodiscard]] bool full() const { return count_ >= kMaxReports; }

 private:
  void report(Rule rule, const core::SourceRef& at, std::string_view pou, const std::string& what);
  const Image& image_;
  core::Diagnostics& diagnostics_;
  std::size_t count_ = 0;
};

/// Fields `first` .. `first + count` of the global table that a task body exports.
struct GlobalRange {
  std::uint64_t first = 0, count = 0;
};
struct CallEdge {
  std::uint32_t callee = 0;
  std::uint64_t times = 0;  ///< call instructions
};
/// What verify_code() finds out about one POU for verify_calls().
struct PouFacts {
  std::uint64_t work = 0;  ///< words of one pass without loops and calls; copies count their bytes / 8
  std::vector<CallEdge> calls;
  std::vector<GlobalRange> exports;
  struct QueueUse {
    std::uint32_t queue = 0;
    bool takes = false;
  };
  std::vector<QueueUse> queues;  ///< elements put or taken by its instructions and ports
};

/// Leaf maps of the tables' structures, made when first asked for.
class LeafMaps {
 public:
  explicit LeafMaps(const Image& image) : image_(image) {}
  const LeafMap& of(std::uint32_t type) {
    std::unique_ptr<LeafMap>& map = maps_[type];
    if (!map) map = std::make_unique<LeafMap>(image_, type);
    return *map;
  }

 private:
  const Image& image_;
  std::unordered_map<std::uint32_t, std::unique_ptr<LeafMap>> maps_;
};

void verify_types(const Image& image, Report& report);
/// Needs sound types.
void verify_tables(const Image& image, Report& report);
/// Needs sound types.
void verify_library(const Image& image, Report& report);
/// Needs sound types, tables and library. One entry per POU in `facts`.
void verify_code(const Image& image, Report& report, std::vector<PouFacts>& facts);
/// Needs all of the above.
void verify_probes(const Image& image, Report& report);
/// Needs sound types, tables, library and code. Returns the deepest nesting of calls.
std::uint32_t verify_calls(const Image& image, Report& report, std::vector<PouFacts>& facts);

}  // namespace plc::bytecode
