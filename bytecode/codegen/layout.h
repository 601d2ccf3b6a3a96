// Layout: IR types -> the image's types, with natural alignment; where every variable lies; initial bytes.
//
// In: a Module whose bodies are complete (hidden variables are part of the layout). Out: Image::types and offsets for
// body generation. Does not belong here: instructions, order of globals (tasks.h decides, lay_out_globals places).
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "bytecode/image.h"
#include "ir/ir.h"

namespace plc::bytecode {

inline constexpr std::uint32_t kNoIndex = 0xffffffffu;

/// A structure that grows field by field at natural alignment.
class StructBuilder {
 public:
  /// Adds a field; returns its index. Sizes beyond kMaxTableBytes stick: see too_large().
  std::uint32_t add(const Image& image, ImageField field);
  [[nodiscard]] std::uint32_t offset(std::uint32_t field) const { return fields_[field].offset; }
  [[nodiscard]] bool too_large() const { return end_ > kMaxTableBytes; }
  /// The finished structure.
  ImageType finish(std::string name);

 private:
  std::vector<ImageField> fields_;
  std::uint64_t end_ = 0;
  std::uint32_t align_ = 1;
};

/// What a field says of a declaration with RETAIN, PERSISTENT or NON_RETAIN. Not `kept`: nothing of the first two.
void keep(const ir::Variable& variable, bool kept, ImageField& field);

/// Where the variables of one POU lie. Both vectors are indexed like Pou::variables.
struct PouLayout {
  std::vector<std::uint32_t> offset;  ///< in the instance or the frame; kNoIndex for externals
  std::vector<std::uint32_t> field;   ///< field index there
  std::uint32_t instance_type = kNoIndex;
};

class Layout {
 public:
  Layout(const ir::Module& module, Image& image) : module_(module), image_(image) {}

  /// Says which field of the global table each global is; before any type of an instance is made.
  void place_globals(std::vector<std::uint32_t> fields) { global_fields_ = std::move(fields); }

  /// The image type of `ref`, made at first use.
  std::uint32_t type(ir::TypeRef ref);
  /// The same where it has been made, else kNoIndex.
  [[nodiscard]] std::uint32_t known_type(ir::TypeRef ref) const {
    return ref.index < by_ref_.size() ? by_ref_[ref.index] : kNoIndex;
  }
  /// The image type of references to `target`, whether a source names it or not.
  std::uint32_t reference(ir::TypeRef target);
  /// A structure without fields, for functions and tasks without memory.
  std::uint32_t empty_struct();
  /// Instance layout of a POU, of an action that of its owner; frame variables (functions, VAR_TEMP) get places when
  /// lay_out_frame is called.
  const PouLayout& pou(std::uint32_t index);
  /// Adds the frame variables of `index` to `frame`.
  void lay_out_frame(std::uint32_t index, StructBuilder& frame);
  /// Makes the targets of references that were only named so far. Call when no type will be asked for any more.
  void finish();

  /// Field index in the image of field (or POU variable) `index` of structure, block or POU type `ref`.
  std::uint32_t field_index(ir::TypeRef ref, std::uint32_t index);
  std::uint32_t field_offset(ir::TypeRef ref, std::uint32_t index);

  /// Field index in the global table of global `index` of the module.
  [[nodiscard]] std::uint32_t global_field(std::uint32_t index) const { return global_fields_[index]; }

  /// Writes a fresh value of `ref` to `to` (type(ref).size bytes, zeroed).
  void initialise(ir::TypeRef ref, std::byte* to);
  /// The same with the overrides of a variable.
  void initialise(const ir::Variable& variable, std::byte* to);
  /// Writes single parts of a value of `ref`.
  void override_values(ir::TypeRef ref, std::span<const ir::InitItem> items, std::byte* to);
  /// Where the part that `path` leads to (fields, variables, 0-based elements) begins in a value of type `ref`.
  std::uint32_t offset_of(ir::TypeRef ref, std::span<const std::uint32_t> path);
  /// A fresh value as far as the image's types know it: capacities of strings, lowest legal numbers.
  void initialise_raw(std::uint32_t image_type, std::byte* to) const;
  /// Writes the bits or characters of a constant.
  void write_constant(const ir::Constant& constant, ir::TypeRef as, std::byte* to) const;
  /// Fresh bytes of an instance of a POU.
  const std::vector<std::byte>& instance_initial(std::uint32_t pou);

  /// A type or instance grew beyond what a table holds.
  [[nodiscard]] bool too_large() const { return too_large_; }

 private:
  /// offset_of(); `at` becomes the type of the part.
  std::uint32_t walk(ir::TypeRef& at, std::span<const std::uint32_t> path);
  /// One step of it.
  std::uint32_t walk_step(ir::TypeRef& at, std::uint32_t step);
  /// Writes an initial value that lies in a union; false when it does not.
  bool write_in_union(const ir::InitItem& item, ir::TypeRef ref, std::byte* to);
  std::uint32_t add(ImageType type);
  std::uint32_t make(ir::TypeRef ref);
  std::uint32_t make_scalar(const ir::Type& type);
  std::uint32_t make_string(core::TypeId id, std::uint16_t capacity);
  std::uint32_t make_array(const ir::Type& type);
  std::uint32_t make_struct(const ir::Type& type);
  std::uint32_t make_union(ir::TypeRef ref);
  std::uint32_t make_block(const stdlib::BlockSpec& spec);
  std::uint32_t make_instance(std::uint32_t pou);

  const ir::Module& module_;
  Image& image_;
  std::vector<std::uint64_t> parts_;  ///< by image type: parts_of()
  std::vector<std::uint32_t> by_ref_;
  std::vector<std::vector<std::uint32_t>> block_fields_;  ///< by TypeRef: image field of each port (blocks only)
  struct Pending {
    std::uint32_t image_type;
    ir::TypeRef target;
  };
  std::vector<Pending> pending_;
  std::vector<std::optional<PouLayout>> pous_;
  std::vector<std::optional<std::vector<std::byte>>> instance_initial_;
  std::map<std::pair<core::TypeId, std::uint16_t>, std::uint32_t> strings_;
  std::map<std::uint32_t, std::uint32_t> references_;  ///< by TypeRef index of the target
  std::vector<std::uint32_t> global_fields_;           ///< by index into Module::globals
  std::uint32_t empty_ = kNoIndex;
  bool too_large_ = false;
};

}  // namespace plc::bytecode
