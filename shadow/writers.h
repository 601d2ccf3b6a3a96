// Writers: where drawings and texts write a variable: coils, output variables, assignments, actions, outputs of blocks.
//
// In: a resource whose image has drawings. Out: for a place of its tables, the elements that write it, with the
// instance they do it on. Threads: one. Does not belong here: what they wrote (cause.h).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "bytecode/drawings.h"
#include "runtime/access.h"
#include "shadow/probe_view.h"

namespace plc::shadow {

/// The place that a name in a POU means on an instance of it; nothing when it is no name of a variable.
std::optional<runtime::Place> place_in(runtime::Resource& resource, std::string_view instance, std::string_view name);

struct Writer {
  enum class Kind : std::uint8_t {
    kCoil,
    kVariable,   ///< an output variable, or one at an output pin of a block
    kStatement,  ///< of ST or IL, at `line` and `column`
    kAction,     ///< of a step, `pin` is its number
    kInstance,   ///< a block whose instance the variable is a part of
  };
  Kind kind = Kind::kCoil;
  const bytecode::DrawnBody* body = nullptr;
  std::uint32_t pou = 0;      ///< into Image::pous
  std::uint32_t element = 0;  ///< into DrawnBody::elements
  std::uint32_t pin = 0;
  std::uint32_t line = 0, column = 0;
  std::string name;  ///< as it stands there
  std::uint32_t task = 0;
  PouInstance instance;
};

class Writers {
 public:
  /// All must outlive it.
  Writers(runtime::Resource& resource, const bytecode::Drawings& drawings);
  /// In the order of the project. Those of kInstance only when there are no others.
  [[nodiscard]] std::vector<Writer> of(const runtime::Place& place) const;

 private:
  struct Row {
    Writer writer;
    bool in_instance = false;  ///< `offset` counts from the begin of the instance
    runtime::Place place;
    std::uint32_t bytes = 0;
    std::size_t instances = 0;  ///< into instances_
  };
  void add_body(const bytecode::DrawnBody& body, std::uint32_t pou, std::uint32_t task, std::size_t instances);
  void add(Writer writer, std::uint32_t task, std::size_t instances);

  runtime::Resource& resource_;
  std::vector<Row> rows_;
  std::vector<std::vector<PouInstance>> instances_;
};

}  // namespace plc::shadow
