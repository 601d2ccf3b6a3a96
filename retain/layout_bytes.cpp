// Layouts as bytes. Numbers are little-endian; elementary types are called by their names, so that no table of this
// program is part of the format.
#include <algorithm>
#include <limits>

#include "bytecode/byte_io.h"
#include "bytecode/type_map.h"
#include "core/types.h"
#include "retain/layout.h"

namespace plc::retain {
namespace {

using bytecode::ByteReader;
using bytecode::ByteWriter;
using bytecode::ImageField;
using bytecode::ImageType;
using bytecode::TypeKind;

enum class Kind : std::uint8_t { kScalar, kString, kArray, kStruct, kReference };
constexpr std::uint8_t kRetain = 1, kPersistent = 2, kFresh = 4, kInternal = 8, kConstant = 16;
/// Smallest records, bytes.
constexpr std::size_t kTypeRecord = 9, kFieldRecord = 13, kMemberRecord = 12, kRootRecord = 17;
/// Longer names are none that this program writes.
constexpr std::uint32_t kMostText = 65535;

Kind kind_of(TypeKind kind) { return static_cast<Kind>(kind); }
static_assert(static_cast<int>(TypeKind::kScalar) == 0 && static_cast<int>(TypeKind::kString) == 1 &&
              static_cast<int>(TypeKind::kArray) == 2 && static_cast<int>(TypeKind::kStruct) == 3 &&
              static_cast<int>(TypeKind::kRef) == 4);

void put_text(ByteWriter& out, std::string_view text) {
  out.put(static_cast<std::uint32_t>(text.size()));
  out.put_bytes(std::as_bytes(std::span(text.data(), text.size())));
}

void put_type(ByteWriter& out, const ImageType& type) {
  out.put(static_cast<std::uint8_t>(kind_of(type.kind)));
  out.put(type.size);
  put_text(out, type.name);
  switch (type.kind) {
    case TypeKind::kScalar:
      put_text(out, core::name_of(type.elementary));
      out.put(static_cast<std::uint8_t>(type.limited));
      out.put(type.lower);
      out.put(type.upper);
      out.put(static_cast<std::uint32_t>(type.members.size()));
      for (std::size_t m = 0; m < type.members.size(); ++m) {
        put_text(out, type.members[m]);
        out.put(type.member_values[m]);
      }
      return;
    case TypeKind::kString:
      put_text(out, core::name_of(type.elementary));
      out.put(type.capacity);
      return;
    case TypeKind::kArray:
      out.put(type.element);
      out.put(type.count);
      out.put(type.lower);
      return;
    case TypeKind::kStruct:
      out.put(static_cast<std::uint32_t>(type.fields.size()));
      for (const ImageField& field : type.fields) {
        put_text(out, field.name);
        out.put(field.type);
        out.put(field.offset);
        out.put(static_cast<std::uint8_t>((field.retain ? kRetain : 0) | (field.persistent ? kPersistent : 0) |
                                          (field.fresh ? kFresh : 0) | (field.internal ? kInternal : 0) |
                                          (field.constant ? kConstant : 0)));
      }
      return;
    case TypeKind::kRef:
      return;
  }
}

class Decoder {
 public:
  explicit Decoder(std::span<const std::byte> bytes) : in_(bytes) {}

  std::optional<Layout> run() {
    layout_.project = get_text();
    layout_.program = in_.get<std::uint64_t>();
    layout_.bytes = in_.get<std::uint64_t>();
    const std::uint32_t types = in_.count(kTypeRecord);
    for (std::uint32_t t = 0; t < types && !in_.failed(); ++t) get_type();
    const std::uint32_t roots = in_.count(kRootRecord);
    std::uint64_t end = 0;
    for (std::uint32_t r = 0; r < roots && !in_.failed(); ++r) {
      Root& root = layout_.roots.emplace_back();
      root.path = get_text();
      root.type = in_.get<std::uint32_t>();
      root.at = in_.get<std::uint64_t>();
      const auto flags = in_.get<std::uint8_t>();
      root.persistent = (flags & kPersistent) != 0;
      root.internal = (flags & kInternal) != 0;
      const bool lies = root.type < layout_.types.size() && root.at >= end && root.at <= layout_.bytes &&
                        layout_.types[root.type].size <= layout_.bytes - root.at;
      if (!lies || root.path.empty()) in_.fail();
      if (in_.failed()) break;
      end = root.at + layout_.types[root.type].size;
    }
    if (in_.failed() || !in_.at_end()) return std::nullopt;
    return std::move(layout_);
  }

 private:
  std::string get_text() {
    const auto size = in_.get<std::uint32_t>();
    if (size > kMostText) in_.fail();
    const auto bytes = in_.take(in_.failed() ? 0 : size);
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
  }

  void get_elementary(ImageType& type, bool text) {
    const std::string name = get_text();
    std::size_t id = 0;
    while (id < core::kTypeCount && core::kTypes[id].iec != name) ++id;
    if (id == core::kTypeCount) return in_.fail();
    type.elementary = static_cast<core::TypeId>(id);
    if (core::in_category(type.elementary, core::kAnyString) != text) in_.fail();
  }

  /// Of a part of the type that is being read.
  [[nodiscard]] const ImageType* part(std::uint32_t index) const {
    const bool fits = index < layout_.types.size() && depth_[index] < bytecode::kMaxTypeDepth;
    return fits ? &layout_.types[index] : nullptr;
  }

  void get_type() {
    ImageType type;
    std::uint32_t depth = 0;
    const auto kind = in_.get<std::uint8_t>();
    if (kind > static_cast<std::uint8_t>(Kind::kReference)) return in_.fail();
    type.kind = static_cast<TypeKind>(kind);
    type.size = in_.get<std::uint32_t>();
    type.name = get_text();
    switch (type.kind) {
      case TypeKind::kScalar:
        get_scalar(type);
        break;
      case TypeKind::kString: {
        get_elementary(type, true);
        type.capacity = in_.get<std::uint16_t>();
        const std::uint32_t unit = type.elementary == core::TypeId::kWstring ? 2 : 1;
        if (type.size < sizeof(core::StringHeader) + std::uint32_t{type.capacity} * unit) in_.fail();
        break;
      }
      case TypeKind::kArray: {
        type.element = in_.get<std::uint32_t>();
        type.count = in_.get<std::uint32_t>();
        type.lower = in_.get<std::int64_t>();
        const ImageType* const element = part(type.element);
        const bool bound = type.lower <= std::numeric_limits<std::int64_t>::max() - std::int64_t{type.count};
        if (element == nullptr || !bound || type.count == 0) return in_.fail();
        if (std::uint64_t{element->size} * type.count != type.size) in_.fail();
        depth = depth_[type.element] + 1;
        break;
      }
      case TypeKind::kStruct:
        depth = get_fields(type);
        break;
      case TypeKind::kRef:
        if (type.size != 8) in_.fail();
        break;
    }
    if (type.size == 0) in_.fail();
    layout_.types.push_back(std::move(type));
    depth_.push_back(depth);
  }

  void get_scalar(ImageType& type) {
    get_elementary(type, false);
    type.limited = in_.get<std::uint8_t>() != 0;
    type.lower = in_.get<std::int64_t>();
    type.upper = in_.get<std::int64_t>();
    const std::uint32_t members = in_.count(kMemberRecord);
    for (std::uint32_t m = 0; m < members && !in_.failed(); ++m) {
      type.members.push_back(get_text());
      type.member_values.push_back(in_.get<std::int64_t>());
    }
    if (type.size != core::rep_bytes(core::rep_of(type.elementary))) in_.fail();
  }

  /// How deep the fields nest.
  std::uint32_t get_fields(ImageType& type) {
    std::uint32_t depth = 0;
    std::uint64_t end = 0;
    const std::uint32_t fields = in_.count(kFieldRecord);
    for (std::uint32_t f = 0; f < fields && !in_.failed(); ++f) {
      ImageField& field = type.fields.emplace_back();
      field.name = get_text();
      field.type = in_.get<std::uint32_t>();
      field.offset = in_.get<std::uint32_t>();
      const auto flags = in_.get<std::uint8_t>();
      field.retain = (flags & kRetain) != 0;
      field.persistent = (flags & kPersistent) != 0;
      field.fresh = (flags & kFresh) != 0;
      field.internal = (flags & kInternal) != 0;
      field.constant = (flags & kConstant) != 0;
      const ImageType* const t = part(field.type);
      if (t == nullptr || field.offset < end || std::uint64_t{field.offset} + t->size > type.size) {
        in_.fail();
        break;
      }
      end = std::uint64_t{field.offset} + t->size;
      depth = std::max(depth, depth_[field.type] + 1);
    }
    return depth;
  }

  ByteReader in_;
  Layout layout_;
  std::vector<std::uint32_t> depth_;  ///< by type
};

}  // namespace

std::vector<std::byte> encode(const Layout& layout) {
  ByteWriter out;
  put_text(out, layout.project);
  out.put(layout.program);
  out.put(layout.bytes);
  out.put(static_cast<std::uint32_t>(layout.types.size()));
  for (const ImageType& type : layout.types) put_type(out, type);
  out.put(static_cast<std::uint32_t>(layout.roots.size()));
  for (const Root& root : layout.roots) {
    put_text(out, root.path);
    out.put(root.type);
    out.put(root.at);
    out.put(static_cast<std::uint8_t>((root.persistent ? kPersistent : 0) | (root.internal ? kInternal : 0)));
  }
  return std::move(out.bytes());
}

std::optional<Layout> decode(std::span<const std::byte> bytes) { return Decoder(bytes).run(); }

}  // namespace plc::retain
