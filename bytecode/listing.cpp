#include "bytecode/listing.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstring>

#include "bytecode/type_map.h"

namespace plc::bytecode::listing {

namespace {

bool is_plain(std::string_view name) {
  return !name.empty() && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_' || c == '#';
  });
}

/// False when `type` leads beyond `bytes`, which only a broken image can do.
bool fill_capacities(const Image& image, std::uint32_t index, std::span<std::byte> bytes) {
  const ImageType& type = image.types[index];
  if (type.size > bytes.size()) return false;
  switch (type.kind) {
    case TypeKind::kScalar:
    case TypeKind::kRef:
      return true;
    case TypeKind::kString:
      if (type.size < sizeof(core::StringHeader)) return false;
      std::memcpy(bytes.data(), &type.capacity, sizeof type.capacity);
      return true;
    case TypeKind::kArray: {
      if (type.element >= index) return false;
      const std::size_t size = image.types[type.element].size;
      if (size * type.count > bytes.size()) return false;
      if (size == 0 || type.count == 0) return true;
      if (!fill_capacities(image, type.element, bytes.first(size))) return false;
      for (std::size_t done = size; done < size * type.count; done += size) {
        std::memcpy(bytes.data() + done, bytes.data(), size);
      }
      return true;
    }
    case TypeKind::kStruct:
      for (const ImageField& field : type.fields) {
        if (field.type >= index || field.offset > type.size) return false;
        if (!fill_capacities(image, field.type, bytes.subspan(field.offset, type.size - field.offset))) return false;
      }
      return true;
  }
  return false;
}

}  // namespace

const Names::Index& Names::index_of(std::uint32_t type) {
  const auto [it, added] = indices_.try_emplace(type);
  if (added) {
    const auto& fields = image_.types[type].fields;
    for (std::uint32_t i = 0; i < fields.size(); ++i) {
      if (is_plain(fields[i].name)) it->second.emplace(fields[i].name, i);
    }
  }
  return it->second;
}

std::optional<std::string> Names::path(std::uint32_t type, std::uint32_t offset, std::uint32_t wanted) {
  std::string path;
  if (type >= image_.types.size() || image_.types[type].kind != TypeKind::kStruct) return std::nullopt;
  for (bool root = true;; root = false) {
    const ImageType& t = image_.types[type];
    if (!root && offset == 0 && type == wanted) return path;
    if (t.kind == TypeKind::kStruct) {
      const auto after = std::upper_bound(t.fields.begin(), t.fields.end(), offset,
                                          [](std::uint32_t at, const ImageField& field) { return at < field.offset; });
      if (after == t.fields.begin()) return std::nullopt;
      const ImageField& field = *(after - 1);
      const Index& index = index_of(type);
      const auto known = index.find(field.name);
      if (field.type >= type || known == index.end() || &t.fields[known->second] != &field) return std::nullopt;
      if (!root) path += '.';
      path += field.name;
      offset -= field.offset;
      type = field.type;
    } else if (t.kind == TypeKind::kArray) {
      if (t.element >= type || image_.types[t.element].size == 0) return std::nullopt;
      const std::uint32_t size = image_.types[t.element].size;
      if (offset / size >= t.count) return std::nullopt;
      path += fmt::format("[{}]", offset / size);
      offset %= size;
      type = t.element;
    } else {
      if (offset != 0) return std::nullopt;
      return path;
    }
  }
}

std::optional<Names::Place> Names::find(std::uint32_t type, std::string_view path) {
  Place place{0, type};
  for (bool root = true; root || !path.empty(); root = false) {
    if (place.type >= image_.types.size()) return std::nullopt;
    const ImageType& t = image_.types[place.type];
    if (t.kind == TypeKind::kArray && !root && path.front() == '[') {
      std::uint32_t element = 0;
      const char* const end = path.data() + path.size();
      const auto [stop, error] = std::from_chars(path.data() + 1, end, element);
      if (error != std::errc{} || stop == end || *stop != ']' || element >= t.count || t.element >= place.type) {
        return std::nullopt;
      }
      path.remove_prefix(static_cast<std::size_t>(stop - path.data()) + 1);
      place = {place.offset + element * image_.types[t.element].size, t.element};
      continue;
    }
    if (t.kind != TypeKind::kStruct) return std::nullopt;
    if (!root) {
      if (path.front() != '.') return std::nullopt;
      path.remove_prefix(1);
    }
    const std::string_view name = path.substr(0, path.find_first_of(".["));
    const Index& index = index_of(place.type);
    const auto known = index.find(name);
    if (known == index.end() || t.fields[known->second].type >= place.type) return std::nullopt;
    path.remove_prefix(name.size());
    place = {place.offset + t.fields[known->second].offset, t.fields[known->second].type};
  }
  return place;
}

std::optional<std::vector<std::byte>> default_bytes(const Image& image, std::uint32_t type) {
  if (type >= image.types.size() || image.types[type].size > kMaxTableBytes) return std::nullopt;
  std::vector<std::byte> bytes(image.types[type].size);
  if (!fill_capacities(image, type, bytes)) return std::nullopt;
  return bytes;
}

std::string quoted(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    const auto code = static_cast<unsigned char>(c);
    if (code < 0x20 || code >= 0x7f || c == '"' || c == '\\') {
      out += fmt::format("\\{:02x}", code);
    } else {
      out += c;
    }
  }
  return out + '"';
}

std::optional<std::string> unquoted(std::string_view text) {
  std::string out;
  if (text.size() < 2 || text.front() != '"' || text.back() != '"') return std::nullopt;
  text = text.substr(1, text.size() - 2);
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '"') return std::nullopt;
    if (text[i] != '\\') {
      out += text[i];
      continue;
    }
    if (text.size() - i < 3) return std::nullopt;
    unsigned code = 0;
    const auto [stop, error] = std::from_chars(text.data() + i + 1, text.data() + i + 3, code, 16);
    if (error != std::errc{} || stop != text.data() + i + 3) return std::nullopt;
    out += static_cast<char>(code);
    i += 2;
  }
  return out;
}

}  // namespace plc::bytecode::listing
