// Objects: what the pointers of one task can lead to. An object is a variable: a global, a variable of a program or
// function block instance, or of a frame. The variables of an instance are objects of their own, so that no access goes
// from one to the next; the instance itself is part of the object that holds it, closed but for calls and members.
//
// In: a verified image and the layout of the task's table. Out: pointers of places, and checked accesses through
// pointers, whatever bits they have. Built when a program is loaded; the accesses are RT: bounded by the size of the
// type that is read or written, and by the logarithm of the number of objects. Does not belong here: instructions
// (interpreter.cpp), events.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "bytecode/image.h"
#include "core/result.h"
#include "runtime/memory/table.h"
#include "runtime/pointers/packed_types.h"
#include "runtime/pointers/pointer.h"

namespace plc::runtime {

/// How an access through a pointer went.
enum class Reached : std::uint8_t {
  kFine,
  kCut,     ///< a text was longer than the string it went into
  kNowhere  ///< outside of the object, or closed
};

class Objects {
 public:
  /// The objects of a task with body `body`, and of `tag` (Handle::task_tag). P9001 when there are more than pointers
  /// can name.
  static core::Result<Objects> make(const bytecode::Image& image, std::uint32_t body, const TaskLayout& layout,
                                    std::uint64_t tag);

  /// The pointer to the value of `type` at byte `place` of the table; null where no pointer leads to. RT.
  [[nodiscard]] Pointer address_of(std::uint32_t place, std::uint32_t type) const noexcept;
  /// Where in the table a value of exactly `type` is that `pointer` leads to and that may be written. RT.
  [[nodiscard]] std::optional<std::uint32_t> place_of(Pointer pointer, std::uint32_t type) const noexcept;

  /// Reads the value of `type` that `pointer` leads to into `to`, a leaf or place of the same kind; a string there has
  /// `capacity` characters. RT.
  Reached load(const std::byte* table, Pointer pointer, std::uint32_t type, std::byte* to,
               std::uint16_t capacity) const noexcept;
  /// Writes the value at `from` the other way. RT.
  Reached store(std::byte* table, Pointer pointer, std::uint32_t type, const std::byte* from,
                std::uint16_t capacity) const noexcept;

  /// Bytes of a value of `type` in a table; 0 for texts, whose capacity may differ. RT.
  [[nodiscard]] std::uint32_t stored_bytes(std::uint32_t type) const noexcept {
    const bytecode::ImageType& t = types_.image_type(type);
    return t.kind == bytecode::TypeKind::kString ? 0 : t.size;
  }

  /// The pointer as an address of 32 bits, and back: addresses of one object follow each other, and reach kMargin bytes
  /// before and after it. Nothing for pointers that are further away. RT.
  [[nodiscard]] std::optional<std::uint32_t> to_32(Pointer pointer) const noexcept;
  [[nodiscard]] std::optional<Pointer> from_32(std::uint32_t address) const noexcept;
  static constexpr std::uint32_t kMargin = 16;

 private:
  static constexpr std::uint32_t kNone = 0xffffffffu;
  struct Object {
    std::uint32_t begin = 0;    ///< in the table
    std::uint32_t type = 0;     ///< of the image
    std::uint32_t parent = 0;   ///< the object that holds the instance it belongs to, or kNone
    std::uint32_t address = 0;  ///< of 32 bits; 0 = none
    bool constant = false;
  };
  /// A place in an object.
  struct Spot {
    const Object* object = nullptr;
    std::uint32_t offset = 0;
    [[nodiscard]] explicit operator bool() const { return object != nullptr; }
  };

  explicit Objects(const bytecode::Image& image) : types_(image) {}
  void add_variables(const bytecode::Image& image, std::uint32_t structure, std::uint32_t begin, std::uint32_t parent,
                     bool constant);
  /// The variables of the instances in a value of `type`.
  void add_instances(const bytecode::Image& image, std::uint32_t type, std::uint32_t begin, std::uint32_t parent,
                     bool constant);
  void give_addresses();

  [[nodiscard]] const Object* object_of(Pointer pointer) const noexcept;
  /// Where `pointer` leads to, inside of an object.
  [[nodiscard]] Spot spot_of(Pointer pointer) const noexcept;
  /// Whether the object has `size` bytes from there on, open to pointers.
  [[nodiscard]] bool holds_open(Spot spot, std::uint32_t size) const noexcept;
  [[nodiscard]] Pointer pointer_to(const Object& object, std::int64_t offset) const noexcept;
  Reached load_text(const std::byte* table, Spot spot, std::uint32_t type, std::byte* to,
                    std::uint16_t capacity) const noexcept;
  Reached store_text(std::byte* table, Spot spot, std::uint32_t type, const std::byte* from,
                     std::uint16_t capacity) const noexcept;

  PackedTypes types_;
  std::vector<Object> objects_;  ///< ascending places, those outside before those inside: globals, then the task's own
  std::uint32_t globals_ = 0;    ///< how many of them are globals
  std::uint64_t tag_ = 0;
};

/// Whether a body that is marked in `reached` uses pointers.
bool uses_pointers(const bytecode::Image& image, const std::vector<std::uint32_t>& reached);

}  // namespace plc::runtime
