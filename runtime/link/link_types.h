// Numbers and zeros of types in resolved code.
//
// In: a verified image. Out: one number for types that are equal, one block of zeros for each type. Does not belong
// here: layouts that pointers see (pointers/packed_types.h).
#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <memory>

#include "bytecode/type_map.h"
#include "runtime/link/link.h"
#include "runtime/link/link_path.h"

namespace plc::runtime {

class LinkTypes {
 public:
  /// `code` gets the blocks.
  LinkTypes(const bytecode::Image& image, LinkedCode& code) : image_(image), code_(code) {}

  /// Types that are equal have one number in handles.
  std::uint32_t canonical(std::uint32_t type) {
    if (const auto known = canonical_.find(type); known != canonical_.end()) return known->second;
    // The same in every task of the image: handles go from one to the other.
    std::uint32_t first = type;
    const bytecode::TypeKind kind = image_.types[type].kind;
    for (std::uint32_t t = 0; kind != bytecode::TypeKind::kStruct && t < type && first == type; ++t) {
      if (image_.types[t].kind == kind && bytecode::same_type(image_, t, type)) first = t;
    }
    canonical_.emplace(type, first);
    return first;
  }

  /// Zeros of a type, one block for all that need them.
  const std::byte* zeros(std::uint32_t type) {
    const auto [known, fresh] = zeros_.try_emplace(type, nullptr);
    if (!fresh) return known->second;
    auto bytes = std::make_unique<std::byte[]>(std::max<std::uint32_t>(image_.types[type].size, 1));
    fill_zeros(image_, type, bytes.get());
    code_.constants.push_back(std::move(bytes));
    return known->second = code_.constants.back().get();
  }

 private:
  const bytecode::Image& image_;
  LinkedCode& code_;
  std::map<std::uint32_t, std::uint32_t> canonical_;
  std::map<std::uint32_t, const std::byte*> zeros_;
};

}  // namespace plc::runtime
