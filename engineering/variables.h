// Variables: the tree of names that clients see, and reading and writing by path.
//
// In: an image, values (value_source.h). Out: nodes, values as JSON, writes to the global table. Threads: that of the
// value source. Does not belong here: paths (runtime/access.h), rows of calls.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engineering/call.h"
#include "engineering/value_source.h"
#include "runtime/access.h"

namespace plc::engineering {

/// One name below another.
struct Node {
  std::string name;
  std::string path;
  std::string_view kind;                ///< "value", "structure", "array", "list" (of globals), "reference"
  std::optional<runtime::Place> place;  ///< none of a list
};

class Variables {
 public:
  /// All must outlive it.
  Variables(runtime::Resource& resource, ValueSource& values);

  /// What is below `path`; empty: program instances, lists of globals, globals. From the `from`th on, at most `most`;
  /// `total` is how many there are. P7101 when there is no such path.
  core::Result<std::vector<Node>> children(std::string_view path, std::size_t from, std::size_t most,
                                           std::size_t& total) const;
  /// Whether a client may write it: a global that is no constant and no input of a driver.
  [[nodiscard]] bool is_writable(const runtime::Place& place) const;
  /// Whether its value is known.
  [[nodiscard]] bool is_readable(const runtime::Place& place) const { return values_.knows(place.task); }

  /// The address of a whole global, "%IX0.0"; empty without one.
  [[nodiscard]] std::string_view address(const runtime::Place& place) const;

  /// The newest value. P7101; P7720 when nobody knows it.
  core::Result<runtime::Place> find(std::string_view path) const;
  /// Of a place that is readable. After values().take().
  [[nodiscard]] Json read(const runtime::Place& place) const;

  /// Checks a value for a path and adds what is to be written to `batch`, which keeps its bytes in `kept`.
  struct Write {
    runtime::Place place;
    std::uint32_t offset = 0, type = 0;
    std::vector<std::byte> bytes;
  };
  std::optional<core::Problem> prepare(std::string_view path, const Json& value, std::vector<Write>& writes,
                                       std::string& field) const;
  /// All or nothing. P7106, P7107.
  std::optional<core::Problem> write(std::span<const Write> writes);

  [[nodiscard]] const bytecode::Image& image() const { return resource_.image(); }
  [[nodiscard]] ValueSource& values() { return values_; }
  [[nodiscard]] runtime::Resource& resource() { return resource_; }

 private:
  /// What is at the top, without its names: a plant may have 100,000 globals.
  struct Root {
    enum class Kind : std::uint8_t { kInstance, kAlias, kGlobal, kList } kind;
    std::uint32_t task = 0;
    std::uint32_t index = 0;  ///< of the field, alias or global; of a list its first global
  };
  [[nodiscard]] std::vector<Root> find_roots() const;
  [[nodiscard]] Node node_of(const Root& root) const;
  /// Those of the list from the `from`th on; `total`: how many there are.
  [[nodiscard]] std::vector<Node> in_list(std::string_view list, std::size_t from, std::size_t most,
                                          std::size_t& total) const;
  void add_part(std::string path, std::string name, const runtime::Place& place, std::vector<Node>& nodes) const;

  runtime::Resource& resource_;
  ValueSource& values_;
  std::vector<Root> roots_;
};

}  // namespace plc::engineering
