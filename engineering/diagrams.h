// Diagrams: the drawings that the image carries, unpacked while somebody looks at them, and which instances of which
// POU they are of.
//
// In: a resource. Out: POUs, their instances, and their drawings in parts (pictures/sheet.h). Nobody looks: nothing is
// in memory. Threads: any. Does not belong here: rows, values.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "bytecode/drawings.h"
#include "pictures/sheet.h"
#include "runtime/resource.h"
#include "shadow/probe_view.h"

namespace plc::engineering {

/// A POU that is drawn or written: a program, a function block, a function, an action, a transition.
struct DrawnPou {
  static constexpr std::uint32_t kNobody = 0xffffffffu;
  std::string name;
  std::uint32_t pou = kNobody;      ///< into Image::pous: whose points are numbered; kNobody: nothing executes it
  std::vector<std::uint32_t> pous;  ///< all of this name
  std::vector<const bytecode::DrawnBody*> bodies;
};

/// One instance of it, and who executes it.
struct DrawnInstance {
  std::uint32_t task = 0;
  shadow::PouInstance at;
};

class Diagrams {
 public:
  /// The resource outlives it.
  explicit Diagrams(runtime::Resource& resource);

  struct Book {
    bytecode::Drawings drawings;
    std::vector<DrawnPou> pous;  ///< in the order of the project
    /// Null when there is none of this name.
    [[nodiscard]] const DrawnPou* find(std::string_view name) const;
  };
  /// Null when the image has no drawings.
  std::shared_ptr<const Book> book();

  /// A POU that is looked at.
  struct Opened {
    std::shared_ptr<const Book> book;
    const DrawnPou* pou = nullptr;
    std::unique_ptr<const pictures::Sheet> sheet;  ///< marks have the number of their point
    std::vector<std::string_view> names;           ///< by point: the variable it is the value of, or empty
  };
  /// Null when there is none of this name.
  std::shared_ptr<const Opened> open(std::string_view name);

  /// Where it is executed, task by task; at most `most`.
  [[nodiscard]] std::vector<DrawnInstance> instances(const DrawnPou& pou, std::size_t most) const;
  /// The first one, of this path and task where they are given.
  [[nodiscard]] std::optional<DrawnInstance> instance(const DrawnPou& pou, std::string_view path,
                                                      std::string_view task) const;
  /// The points of a POU, in the order of their numbers.
  [[nodiscard]] std::span<const bytecode::ProbePoint> points(const DrawnPou& pou) const;
  [[nodiscard]] runtime::Resource& resource() const { return resource_; }

  /// About every 100 ms: lets go of what nobody has asked for during some minutes.
  void rest();

 private:
  [[nodiscard]] std::shared_ptr<const Book> make_book() const;
  [[nodiscard]] std::shared_ptr<const Opened> make_opened(const std::shared_ptr<const Book>& book,
                                                          const DrawnPou& pou) const;
  /// The one that is kept, or that somebody holds.
  std::shared_ptr<const Opened> opened_now(const DrawnPou* pou);

  runtime::Resource& resource_;
  std::vector<std::vector<std::uint32_t>> reached_;  ///< by task: POUs
  std::mutex making_;                                ///< while something is made, which takes long
  std::mutex mutex_;                                 ///< of what follows
  std::shared_ptr<const Book> book_;
  std::vector<std::shared_ptr<const Opened>> opened_;  ///< the last one that was asked for first
  std::vector<std::weak_ptr<const Opened>> held_;
  unsigned idle_ = 0;  ///< calls of rest() since somebody asked
};

}  // namespace plc::engineering
