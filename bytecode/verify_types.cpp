#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <string_view>
#include <unordered_set>

#include "bytecode/type_map.h"
#include "bytecode/verifier.h"
#include "core/text.h"

namespace plc::bytecode {

namespace {

bool is_power_of_two(std::uint32_t n) { return n != 0 && (n & (n - 1)) == 0; }

bool is_name(std::string_view text) {
  return std::none_of(text.begin(), text.end(),
                      [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; });
}

struct Range {
  std::int64_t lowest = 0, highest = 0;
};
/// The numbers of an integer representation, as far as 64-bit limits can tell; empty (0, -1) for the others.
Range range_of(Rep rep) {
  switch (rep) {
    case Rep::kI8:
      return {INT8_MIN, INT8_MAX};
    case Rep::kU8:
      return {0, UINT8_MAX};
    case Rep::kI16:
      return {INT16_MIN, INT16_MAX};
    case Rep::kU16:
      return {0, UINT16_MAX};
    case Rep::kI32:
      return {INT32_MIN, INT32_MAX};
    case Rep::kU32:
      return {0, UINT32_MAX};
    case Rep::kI64:
      return {INT64_MIN, INT64_MAX};
    case Rep::kU64:
      return {0, INT64_MAX};
    default:
      return {0, -1};
  }
}

class TypeVerifier {
 public:
  TypeVerifier(const Image& image, Report& report) : image_(image), report_(report) {}

  void run() {
    depth_.resize(image_.types.size());
    for (index_ = 0; index_ < image_.types.size() && !report_.full(); ++index_) {
      const ImageType& type = image_.types[index_];
      parts_.push_back(parts_of(type, parts_));
      if (parts_.back() > kMaxTableBytes) broken(Rule::kV109, "too many parts");
      check(type);
    }
  }

 private:
  void broken(Rule rule, const std::string& what) {
    report_.broken(rule, fmt::format("type {} \"{}\": {}", index_, image_.types[index_].name, what));
  }

  void check(const ImageType& type) {
    if (type.size > kMaxTableBytes) broken(Rule::kV109, fmt::format("{} bytes", type.size));
    if (!is_name(type.name)) broken(Rule::kV112, "its name holds control characters");
    check_unused(type);
    switch (type.kind) {
      case TypeKind::kScalar:
        check_scalar(type);
        break;
      case TypeKind::kString:
        check_string(type);
        break;
      case TypeKind::kArray:
        check_array(type);
        break;
      case TypeKind::kStruct:
        check_struct(type);
        break;
      case TypeKind::kRef:
        if (type.element >= image_.types.size()) {
          broken(Rule::kV101, fmt::format("refers to type {}, which does not exist", type.element));
        }
        if (type.size != 8 || type.align != 8) {
          broken(Rule::kV105, fmt::format("{} bytes aligned to {}", type.size, type.align));
        }
        break;
    }
  }

  void check_unused(const ImageType& type) {
    const bool scalar = type.kind == TypeKind::kScalar;
    const bool array = type.kind == TypeKind::kArray;
    const bool string = type.kind == TypeKind::kString;
    const bool ok = (scalar || string || type.elementary == core::TypeId::kBool) && (string || type.capacity == 0) &&
                    (array || type.kind == TypeKind::kRef || type.element == 0) && (array || type.count == 0) &&
                    (array || type.limited || type.lower == 0) && (type.limited || type.upper == 0) &&
                    (scalar || !type.limited) && (scalar || (type.members.empty() && type.member_values.empty())) &&
                    (type.kind == TypeKind::kStruct || (type.fields.empty() && type.aliases.empty()));
    if (!ok) broken(Rule::kV113, "has a part that its kind does not use");
  }

  void check_scalar(const ImageType& type) {
    const Rep rep = rep_of(type);
    if (core::rep_bytes(rep) == 0 || type.size != core::rep_bytes(rep) || type.align != type.size) {
      broken(Rule::kV102,
             fmt::format("{} of {} bytes aligned to {}", core::name_of(type.elementary), type.size, type.align));
    }
    const Range range = range_of(rep);
    if (type.limited && (type.lower > type.upper || type.lower < range.lowest || type.upper > range.highest)) {
      broken(Rule::kV110, fmt::format("{} within {}..{}", core::name_of(type.elementary), type.lower, type.upper));
    }
    bool members = type.members.size() == type.member_values.size() && (type.members.empty() || type.limited);
    for (const std::int64_t value : type.member_values) members = members && value >= type.lower && value <= type.upper;
    if (!members) broken(Rule::kV111, "its members do not match its values or limits");
    for (const std::string& member : type.members) {
      if (member.empty() || !is_name(member)) broken(Rule::kV112, "a member has no proper name");
    }
  }

  void check_string(const ImageType& type) {
    const bool wide = type.elementary == core::TypeId::kWstring;
    const std::uint32_t bytes = 4u + type.capacity * (wide ? 2u : 1u);
    const bool align = type.align == 2 || type.align == 4 || type.align == 8;
    if ((!wide && type.elementary != core::TypeId::kString) || type.capacity > core::kMaxStringCapacity || !align ||
        type.size != (bytes + type.align - 1) / type.align * type.align) {
      broken(Rule::kV103, fmt::format("{} of {} characters, {} bytes, aligned to {}", core::name_of(type.elementary),
                                      type.capacity, type.size, type.align));
    }
  }

  /// True when `part` may be a part of the current type.
  bool is_lower(std::uint32_t part) {
    if (part < index_) {
      depth_[index_] = std::max(depth_[index_], depth_[part] + 1);
      return true;
    }
    broken(Rule::kV101, fmt::format("is built from type {}", part));
    return false;
  }
  void check_depth() {
    if (depth_[index_] == kMaxTypeDepth) broken(Rule::kV106, "is nested deeper");
  }

  void check_array(const ImageType& type) {
    if (!is_lower(type.element)) return;
    check_depth();
    const ImageType& element = image_.types[type.element];
    const bool bound = type.count != 0 && type.lower <= std::numeric_limits<std::int64_t>::max() - (type.count - 1);
    if (!bound || type.size != std::uint64_t{element.size} * type.count || type.align != element.align) {
      broken(Rule::kV104, fmt::format("{} elements from {} of {} bytes in {} bytes aligned to {}", type.count,
                                      type.lower, element.size, type.size, type.align));
    }
  }

  void check_struct(const ImageType& type) {
    const bool align = is_power_of_two(type.align) && type.align <= 64;
    if (!align || type.size % type.align != 0) {
      broken(Rule::kV108, fmt::format("{} bytes aligned to {}", type.size, type.align));
      return;
    }
    std::uint64_t end = 0;
    for (const ImageField& field : type.fields) {
      if (report_.full()) return;
      if (field.name.empty() || !is_name(field.name)) broken(Rule::kV112, "a field has no proper name");
      if ((field.retain || field.persistent) && (field.constant || field.fresh)) {
        broken(Rule::kV115,
               fmt::format("field \"{}\" is kept, and {}", field.name, field.constant ? "constant" : "NON_RETAIN"));
      }
      if (!is_lower(field.type)) return;
      const ImageType& t = image_.types[field.type];
      if (field.offset < end || field.offset + std::uint64_t{t.size} > type.size) {
        broken(Rule::kV107, fmt::format("field \"{}\" at {}", field.name, field.offset));
      }
      if (t.align == 0 || t.align > type.align || field.offset % t.align != 0) {
        broken(Rule::kV108, fmt::format("field \"{}\" at {}", field.name, field.offset));
      }
      end = field.offset + std::uint64_t{t.size};
    }
    if (type.fields.empty() && type.size != 0) broken(Rule::kV107, fmt::format("{} bytes without a field", type.size));
    check_depth();
    check_aliases(type);
  }

  // The list of globals has one entry per field of the global table (V208).
  void check_aliases(const ImageType& type) {
    if (type.aliases.empty()) return;
    std::unordered_set<std::string_view, core::NameHash, core::NameEqual> names;
    for (const ImageField& field : type.fields) names.insert(field.name);
    for (const ImageAlias& alias : type.aliases) {
      if (report_.full()) return;
      if (alias.name.empty() || !is_name(alias.name)) broken(Rule::kV114, "an alias has no proper name");
      if (!names.insert(alias.name).second) broken(Rule::kV114, fmt::format("a second \"{}\"", alias.name));
      if (alias.global >= image_.globals.size()) {
        broken(Rule::kV114, fmt::format("alias \"{}\" of global {}", alias.name, alias.global));
      }
    }
  }

  const Image& image_;
  Report& report_;
  std::uint32_t index_ = 0;
  std::vector<std::uint64_t> parts_;  ///< by type
  std::vector<std::uint32_t> depth_;
};

}  // namespace

void verify_types(const Image& image, Report& report) { TypeVerifier(image, report).run(); }

}  // namespace plc::bytecode
