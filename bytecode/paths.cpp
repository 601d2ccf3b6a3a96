#include "bytecode/paths.h"

#include <charconv>

#include "core/text.h"

namespace plc::bytecode {

namespace {

/// Splits the name before the first '.' or '[' off `path`.
std::string_view take_name(std::string_view& path) {
  const std::size_t end = std::min(path.find_first_of(".["), path.size());
  const std::string_view name = path.substr(0, end);
  path.remove_prefix(end);
  return name;
}

const ImageField* field_named(const Image& image, std::uint32_t type, std::string_view name) {
  if (type >= image.types.size() || image.types[type].kind != TypeKind::kStruct) return nullptr;
  for (const ImageField& field : image.types[type].fields) {
    if (field.type < type && core::iequals(field.name, name)) return &field;
  }
  return nullptr;
}

/// Follows "[i]" and ".field" from `place`.
std::optional<NamedPlace> follow(const Image& image, NamedPlace place, std::string_view path) {
  while (!path.empty()) {
    if (place.type >= image.types.size()) return std::nullopt;
    const ImageType& type = image.types[place.type];
    const char sign = path.front();
    path.remove_prefix(1);
    if (sign == '.') {
      const ImageField* field = field_named(image, place.type, take_name(path));
      if (field == nullptr) return std::nullopt;
      place = {place.offset + field->offset, field->type};
      continue;
    }
    std::int64_t index = 0;
    const auto [end, error] = std::from_chars(path.data(), path.data() + path.size(), index);
    if (error != std::errc{} || end == path.data() + path.size() || *end != ']') return std::nullopt;
    path.remove_prefix(static_cast<std::size_t>(end - path.data()) + 1);
    if (type.kind != TypeKind::kArray || type.element >= place.type || index < type.lower) return std::nullopt;
    const std::uint64_t element = static_cast<std::uint64_t>(index) - static_cast<std::uint64_t>(type.lower);
    if (element >= type.count) return std::nullopt;
    place.offset += static_cast<std::uint32_t>(element) * image.types[type.element].size;
    place.type = type.element;
  }
  return place;
}

}  // namespace

std::optional<NamedPlace> find_path(const Image& image, std::uint32_t type, std::string_view path) {
  const ImageField* field = field_named(image, type, take_name(path));
  if (field == nullptr) return std::nullopt;
  return follow(image, {field->offset, field->type}, path);
}

std::optional<NamedPlace> find_global(const Image& image, std::string_view path) {
  if (image.global_type >= image.types.size()) return std::nullopt;
  const ImageType& globals = image.types[image.global_type];
  for (std::size_t i = 0; i < globals.fields.size() && i < image.globals.size(); ++i) {
    const ImageField& field = globals.fields[i];
    // Addresses, and names of located variables, hold dots themselves.
    const std::string& address = image.globals[i].address;
    const bool at_address = !address.empty() && !address.ends_with('*') && core::iequals(address, path);
    if (core::iequals(field.name, path) || at_address) {
      return NamedPlace{field.offset, field.type};
    }
  }
  if (const auto place = find_path(image, image.global_type, path)) return place;
  for (const ImageAlias& alias : globals.aliases) {
    if (alias.global >= globals.fields.size() || !core::iequals(alias.name, path)) continue;
    return NamedPlace{globals.fields[alias.global].offset, globals.fields[alias.global].type};
  }
  const std::string_view list = take_name(path);
  if (path.empty() || path.front() != '.') return std::nullopt;
  path.remove_prefix(1);
  const std::string_view name = take_name(path);
  for (std::size_t i = 0; i < globals.fields.size() && i < image.globals.size(); ++i) {
    const ImageField& field = globals.fields[i];
    if (core::iequals(image.globals[i].list, list) && core::iequals(field.name, name)) {
      return follow(image, {field.offset, field.type}, path);
    }
  }
  return std::nullopt;
}

}  // namespace plc::bytecode
