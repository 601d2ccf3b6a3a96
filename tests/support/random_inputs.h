// RandomInputs: what the world does to a program: before a scan some of its variables have other values.
//
// In: an image. Out: writes to variables of tasks and to globals, the same in every engine. Does not belong here: which
// values matter (random_values.h).
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "bytecode/image.h"
#include "runtime/resource.h"
#include "tests/support/random_values.h"

namespace plc::test {

class RandomInputs {
 public:
  /// Takes scalars and strings of the first `most` parts of each table; of structures at most `depth` deep. References
  /// and the numbers of taskblock objects are left alone: they are made by the engine.
  explicit RandomInputs(const bytecode::Image& image, unsigned depth = 4, std::size_t most = 2000) : image_(image) {
    add(kGlobal, image.global_type, 0, depth, most);
    for (std::uint32_t task = 0; task < image.tasks.size(); ++task) {
      add(task, image.pous[image.tasks[task].body].instance_type, 0, depth, most);
    }
  }
  [[nodiscard]] std::size_t places() const { return leaves_.size(); }

  /// Chooses values for about one in `sparsity` of the places; write() then puts them there.
  void choose(Random& random, std::size_t sparsity) {
    chosen_.clear();
    values_.clear();
    if (leaves_.empty()) return;
    // As many as that on average, without asking each place.
    const std::size_t count =
        leaves_.size() < sparsity ? random.below(3) : random.below(2 * leaves_.size() / sparsity + 1);
    for (std::size_t n = 0; n < count; ++n) {
      const Leaf& leaf = random.one_of(leaves_);
      const bytecode::ImageType& type = image_.types[leaf.type];
      const std::size_t at = (values_.size() + 7) / 8 * 8;
      values_.resize(at + type.size);
      if (type.kind == bytecode::TypeKind::kString) {
        const core::StringHeader header{type.capacity, 0};
        std::memcpy(values_.data() + at, &header, sizeof header);
      }
      random_value(type, random, values_.data() + at);
      chosen_.push_back({&leaf, at});
    }
  }
  void write(runtime::Resource& resource) const {
    for (const Chosen& chosen : chosen_) {
      const Leaf& leaf = *chosen.leaf;
      const std::byte* const value = values_.data() + chosen.at;
      if (leaf.task == kGlobal) {
        // One that a task exports waits for that task; a constant is refused.
        const runtime::GlobalWrite one{leaf.offset, leaf.type, value};
        resource.globals().write({&one, 1});
        continue;
      }
      runtime::Program& program = resource.program(leaf.task);
      program.write_local(program.table().layout().instance + leaf.offset,
                          {value, used_bytes(image_.types[leaf.type], value)});
    }
  }

 private:
  static constexpr std::uint32_t kGlobal = 0xffffffffu;
  struct Leaf {
    std::uint32_t task;    ///< or kGlobal
    std::uint32_t offset;  ///< in the global table, or the instance of the task
    std::uint32_t type;
  };
  struct Chosen {
    const Leaf* leaf;
    std::size_t at;  ///< into values_
  };

  static std::size_t used_bytes(const bytecode::ImageType& type, const std::byte* value) {
    if (type.kind != bytecode::TypeKind::kString) return type.size;
    core::StringHeader header;
    std::memcpy(&header, value, sizeof header);
    return sizeof header + header.length * (type.elementary == core::TypeId::kWstring ? 2u : 1u);
  }

  void add(std::uint32_t task, std::uint32_t index, std::uint32_t offset, unsigned depth, std::size_t most) {
    const bytecode::ImageType& type = image_.types[index];
    switch (type.kind) {
      case bytecode::TypeKind::kScalar:
      case bytecode::TypeKind::kString:
        leaves_.push_back({task, offset, index});
        return;
      case bytecode::TypeKind::kRef:
        return;
      case bytecode::TypeKind::kArray:
        for (std::uint32_t i = 0; i < type.count && depth > 0 && leaves_.size() < most; ++i) {
          add(task, type.element, offset + i * image_.types[type.element].size, depth - 1, most);
        }
        return;
      case bytecode::TypeKind::kStruct:
        for (const bytecode::ImageField& field : type.fields) {
          if (depth == 0 || leaves_.size() >= most) return;
          if (field.name != bytecode::kObjectField && !field.constant) {
            add(task, field.type, offset + field.offset, depth - 1, most);
          }
        }
    }
  }

  const bytecode::Image& image_;
  std::vector<Leaf> leaves_;
  std::vector<Chosen> chosen_;
  std::vector<std::byte> values_;
};

}  // namespace plc::test
