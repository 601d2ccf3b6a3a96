#include "bytecode/type_map.h"

#include <algorithm>
#include <cstring>
#include <unordered_map>

namespace plc::bytecode {

namespace {

bool same_scalar(const ImageType& a, const ImageType& b) {
  return a.elementary == b.elementary && a.limited == b.limited &&
         (!a.limited || (a.lower == b.lower && a.upper == b.upper));
}

/// Targets of the two references at the end of two types.
struct Targets {
  std::uint32_t a = 0, b = 0;
};

/// Equality but for the targets of references, which go to `targets`; without `targets` references differ.
bool same_but_targets(const Image& image, std::uint32_t a, std::uint32_t b, Targets* targets) {
  for (std::uint32_t depth = 0; depth <= kMaxTypeDepth; ++depth) {
    if (a >= image.types.size() || b >= image.types.size()) return false;
    if (a == b) return true;
    const ImageType& x = image.types[a];
    const ImageType& y = image.types[b];
    if (x.kind != y.kind) return false;
    switch (x.kind) {
      case TypeKind::kScalar:
        return same_scalar(x, y);
      case TypeKind::kString:
        return x.elementary == y.elementary && x.capacity == y.capacity;
      case TypeKind::kStruct:
        return false;
      case TypeKind::kArray:
        if (x.count != y.count || x.lower != y.lower) return false;
        a = x.element;
        b = y.element;
        continue;
      case TypeKind::kRef:
        if (targets == nullptr) return false;
        *targets = {x.element, y.element};
        return true;
    }
  }
  return false;
}

/// Steps from `type` into the part that covers byte `offset`; false when there is none.
bool descend(const Image& image, std::uint32_t& type, std::uint32_t& offset, bool& constant) {
  const ImageType& t = image.types[type];
  std::uint32_t next = 0;
  if (t.kind == TypeKind::kArray) {
    if (t.element >= type) return false;
    const std::uint32_t size = image.types[t.element].size;
    if (size == 0 || offset / size >= t.count) return false;
    next = t.element;
    offset %= size;
  } else if (t.kind == TypeKind::kStruct) {
    const auto after = std::upper_bound(t.fields.begin(), t.fields.end(), offset,
                                        [](std::uint32_t at, const ImageField& field) { return at < field.offset; });
    if (after == t.fields.begin()) return false;
    const ImageField& field = *(after - 1);
    if (field.type >= type || offset - field.offset >= image.types[field.type].size) return false;
    next = field.type;
    offset -= field.offset;
    constant = constant || field.constant;
  } else {
    return false;
  }
  type = next;
  return true;
}

bool is_leaf(TypeKind kind) { return kind != TypeKind::kArray && kind != TypeKind::kStruct; }

}  // namespace

core::Rep rep_of(const ImageType& type) {
  return type.kind == TypeKind::kRef ? core::Rep::kRef : core::rep_of(type.elementary);
}

std::uint64_t parts_of(const ImageType& type, std::span<const std::uint64_t> known) {
  constexpr std::uint64_t kEnough = std::uint64_t{1} << 62;
  const auto of = [known](std::uint32_t part) { return part < known.size() ? known[part] : 1; };
  std::uint64_t parts = 1;
  if (type.kind == TypeKind::kArray) {
    if (__builtin_mul_overflow(std::uint64_t{type.count}, of(type.element), &parts)) return kEnough;
  } else if (type.kind == TypeKind::kStruct && !type.fields.empty()) {
    parts = 0;
    for (const ImageField& field : type.fields) parts = std::min(kEnough, parts + of(field.type));
  }
  return std::min(kEnough, parts);
}

bool same_type(const Image& image, std::uint32_t a, std::uint32_t b) {
  Targets targets;
  if (!same_but_targets(image, a, b, &targets)) return false;
  return targets.a == targets.b || same_but_targets(image, targets.a, targets.b, nullptr);
}

std::optional<Found> find_leaf(const Image& image, std::uint32_t type, std::uint32_t offset) {
  bool constant = false;
  if (type >= image.types.size()) return std::nullopt;
  for (std::uint32_t depth = 0; depth <= kMaxTypeDepth; ++depth) {
    if (is_leaf(image.types[type].kind)) {
      if (offset != 0) return std::nullopt;
      return Found{type, constant};
    }
    if (!descend(image, type, offset, constant)) return std::nullopt;
  }
  return std::nullopt;
}

std::optional<Found> find_place(const Image& image, std::uint32_t type, std::uint32_t offset, std::uint32_t wanted) {
  bool constant = false;
  if (type >= image.types.size() || wanted >= image.types.size()) return std::nullopt;
  if (image.types[wanted].size == 0) {
    if (offset > image.types[type].size) return std::nullopt;
    return Found{wanted, false};
  }
  for (std::uint32_t depth = 0; depth <= kMaxTypeDepth; ++depth) {
    if (offset == 0 && same_type(image, type, wanted)) return Found{type, constant};
    if (is_leaf(image.types[type].kind) || !descend(image, type, offset, constant)) return std::nullopt;
  }
  return std::nullopt;
}

std::optional<std::uint32_t> leaf_at(const Image& image, std::uint32_t type, std::uint32_t offset) {
  const auto found = find_leaf(image, type, offset);
  return found ? std::optional(found->type) : std::nullopt;
}

bool place_at(const Image& image, std::uint32_t type, std::uint32_t offset, std::uint32_t wanted) {
  return find_place(image, type, offset, wanted).has_value();
}

std::optional<PathTarget> follow_path(const Image& image, std::uint32_t type, std::uint32_t step,
                                      std::uint32_t number) {
  const ImageType& t = image.types[type];
  if (t.kind == TypeKind::kStruct && step == static_cast<std::uint32_t>(PathStep::kField)) {
    if (number >= t.fields.size()) return std::nullopt;
    return PathTarget{t.fields[number].type, t.fields[number].offset, t.fields[number].constant};
  }
  if (t.kind != TypeKind::kArray) return std::nullopt;
  if (step == static_cast<std::uint32_t>(PathStep::kIndex)) return PathTarget{t.element, 0, false};
  if (step != static_cast<std::uint32_t>(PathStep::kElement) || number >= t.count) return std::nullopt;
  return PathTarget{t.element, number * image.types[t.element].size, false};
}

bool leaf_fits(const Image& image, const ImageType& given, const ImageType& wanted) {
  const core::Rep rep = rep_of(wanted);
  if (rep == core::Rep::kRef) return given.kind == TypeKind::kRef && same_type(image, given.element, wanted.element);
  RepMask reps = mask_of(rep);
  for (const RepMask width : {kM8, kM16, kM32, kM64}) {
    if ((width & reps) != 0) reps = width;
  }
  return (mask_of(rep_of(given)) & reps) != 0;
}

// Fills one map. A structure that occurs again is copied: the work is bounded by the table's bytes and the types'
// fields, however often a structure with many empty fields occurs.
class LeafMap::Filler {
 public:
  Filler(const Image& image, std::vector<std::uint8_t>& map) : image_(image), map_(map) {}

  void fill(std::uint32_t type, std::size_t at, std::uint8_t flags) {
    const ImageType& t = image_.types[type];
    if (t.size == 0) return;
    switch (t.kind) {
      case TypeKind::kArray:
        fill_array(t, at, flags);
        return;
      case TypeKind::kStruct: {
        const std::uint64_t key = std::uint64_t{type} << 8 | flags;
        const auto known = known_.find(key);
        if (known != known_.end()) {
          std::memcpy(map_.data() + at, map_.data() + known->second, t.size);
          return;
        }
        for (const ImageField& field : t.fields) {
          fill(field.type, at + field.offset, static_cast<std::uint8_t>(flags | (field.constant ? kConstantLeaf : 0)));
        }
        known_.emplace(key, at);
        return;
      }
      case TypeKind::kScalar:
      case TypeKind::kString:
      case TypeKind::kRef:
        map_[at] = static_cast<std::uint8_t>((static_cast<unsigned>(rep_of(t)) + 1u) | flags);
        return;
    }
  }

 private:
  void fill_array(const ImageType& t, std::size_t at, std::uint8_t flags) {
    fill(t.element, at, flags);
    for (std::size_t done = image_.types[t.element].size; done < t.size;) {
      const std::size_t more = std::min<std::size_t>(done, t.size - done);
      std::memcpy(map_.data() + at + done, map_.data() + at, more);
      done += more;
    }
  }

  const Image& image_;
  std::vector<std::uint8_t>& map_;
  std::unordered_map<std::uint64_t, std::size_t> known_;  // structure and flags -> where it is
};

LeafMap::LeafMap(const Image& image, std::uint32_t type) : map_(image.types[type].size) {
  Filler(image, map_).fill(type, 0, 0);
}

}  // namespace plc::bytecode
