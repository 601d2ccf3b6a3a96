#include "retain/carry.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <map>
#include <optional>

#include "core/text.h"
#include "retain/convert.h"

namespace plc::retain {
namespace {

using bytecode::ImageField;
using bytecode::ImageType;
using bytecode::TypeKind;

/// From how much of a restart a variable is kept.
enum class Keep : std::uint8_t { kNever, kWarm, kCold };

Keep keep_of(const Root& root) { return root.persistent ? Keep::kCold : Keep::kWarm; }
Keep keep_of(const ImageField& field, Keep around) {
  if (field.fresh) return Keep::kNever;
  if (field.persistent) return Keep::kCold;
  return field.retain ? std::max(around, Keep::kWarm) : around;
}
bool is_kept(Keep keep, Start start) {
  return start == Start::kWarm ? keep != Keep::kNever : start == Start::kCold && keep == Keep::kCold;
}

/// A part of a set of values.
struct Part {
  std::uint32_t type = 0;
  std::uint64_t at = 0;
  Keep keep = Keep::kNever;
  bool internal = false;
  bool constant = false;
};

const ImageField* field_named(const ImageType& type, std::string_view name) {
  const core::NameEqual equal;
  for (const ImageField& field : type.fields) {
    if (equal(field.name, name)) return &field;
  }
  return nullptr;
}

Part part_of(const ImageField& field, const Part& whole) {
  return {field.type, whole.at + field.offset, keep_of(field, whole.keep), whole.internal || field.internal,
          whole.constant || field.constant};
}

/// What `rest` (".field[3]") leads to from `part`.
std::optional<Part> follow(const std::vector<ImageType>& types, Part part, std::string_view rest) {
  while (!rest.empty()) {
    const ImageType& type = types[part.type];
    if (rest.front() == '.') {
      const std::size_t end = std::min(rest.find_first_of(".[", 1), rest.size());
      const ImageField* const field = field_named(type, rest.substr(1, end - 1));
      if (field == nullptr) return std::nullopt;
      part = part_of(*field, part);
      rest.remove_prefix(end);
      continue;
    }
    std::int64_t index = 0;
    const char* const last = rest.data() + rest.size();
    const auto [end, error] = std::from_chars(rest.data() + 1, last, index);
    if (error != std::errc{} || end == last || *end != ']' || type.kind != TypeKind::kArray) return std::nullopt;
    if (index < type.lower || index - type.lower >= std::int64_t{type.count}) return std::nullopt;
    part.at += static_cast<std::uint64_t>(index - type.lower) * (type.size / type.count);
    part.type = type.element;
    rest.remove_prefix(static_cast<std::size_t>(end - rest.data()) + 1);
  }
  return part;
}

/// "a[3].b" and "a[4].b" are one kind of place.
std::string without_indices(std::string_view path) {
  std::string out;
  bool inside = false;
  for (const char c : path) {
    if (c == '[') inside = true;
    if (!inside) out += c;
    if (c == ']') inside = false;
  }
  return out;
}

class Carrier {
 public:
  Carrier(const Layout& old, std::span<const std::byte> from, const Layout& now, std::span<std::byte> to, Start start)
      : old_(old), from_(from), now_(now), to_(to), start_(start) {
    for (std::uint32_t r = 0; r < now.roots.size(); ++r) by_path_.emplace(core::folded(now.roots[r].path), r);
  }

  Carried run() {
    Carried out;
    out.same_program = same_ = old_.program == now_.program;
    for (const Root& root : old_.roots) {
      taken_ = 0;
      carry_root(root);
      out.kept += taken_ != 0 ? 1 : 0;
    }
    for (const Misfit& misfit : misfits_) {
      const std::string more = misfit.count == 1 ? "" : fmt::format(" (and {} more)", misfit.count - 1);
      out.misfits.push_back(fmt::format("{}{}: {}", misfit.path, more, misfit.reason));
    }
    return out;
  }

 private:
  struct Misfit {
    std::string path, reason;
    std::uint64_t count = 1;
  };

  void misfit(const std::string& path, std::string reason) {
    const auto [known, fresh] = misfit_of_.emplace(without_indices(path), misfits_.size());
    if (!fresh) {
      ++misfits_[known->second].count;
      return;
    }
    misfits_.push_back({path, std::move(reason)});
  }

  static Part part_of_root(const Root& root) { return {root.type, root.at, keep_of(root), root.internal, false}; }

  void carry_root(const Root& root) {
    if (root.internal && !same_) return;
    const std::string key = core::folded(root.path);
    // What is kept now is it, or what it is in.
    for (std::size_t end = key.size(); end != std::string::npos && end != 0; end = key.find_last_of(".[", end - 1)) {
      const auto found = by_path_.find(key.substr(0, end));
      if (found == by_path_.end()) continue;
      const auto part =
          follow(now_.types, part_of_root(now_.roots[found->second]), std::string_view(root.path).substr(end));
      if (!part) return misfit(root.path, "is not there any more");
      std::string path = root.path;
      return carry(part_of_root(root), *part, path);
    }
    // Or parts of it.
    bool any = false;
    for (const char sign : {'.', '['}) {
      const std::string begin = key + sign;
      for (auto found = by_path_.lower_bound(begin); found != by_path_.end() && found->first.rfind(begin, 0) == 0;
           ++found) {
        const Root& part = now_.roots[found->second];
        std::string path = part.path;
        const auto given = follow(old_.types, part_of_root(root), std::string_view(path).substr(key.size()));
        any = true;
        if (given) carry(*given, part_of_root(part), path);
      }
    }
    if (!any) misfit(root.path, "is not there any more, or not retained");
  }

  void carry(const Part& old, const Part& now, std::string& path) {
    if ((old.internal || now.internal) && !same_) return;
    if (old.constant || now.constant) return;
    const ImageType& was = old_.types[old.type];
    const ImageType& is = now_.types[now.type];
    if (is_reference(was) || is_reference(is)) return;
    if (was.kind == TypeKind::kStruct && is.kind == TypeKind::kStruct) return carry_fields(old, now, path);
    if (was.kind == TypeKind::kArray && is.kind == TypeKind::kArray) return carry_elements(old, now, path);
    const auto leaf = [](const ImageType& t) { return t.kind == TypeKind::kScalar || t.kind == TypeKind::kString; };
    if (!is_kept(now.keep, start_)) return;
    std::string reason = leaf(was) && leaf(is) ? convert_leaf(was, from_.data() + old.at, is, to_.data() + now.at)
                                               : fmt::format("was {} and is {}", type_text(old_.types, old.type),
                                                             type_text(now_.types, now.type));
    if (reason.empty()) {
      ++taken_;
    } else {
      misfit(path, std::move(reason));
    }
  }

  void carry_fields(const Part& old, const Part& now, std::string& path) {
    const ImageType& was = old_.types[old.type];
    const ImageType& is = now_.types[now.type];
    const std::size_t length = path.size();
    for (std::size_t f = 0; f < was.fields.size(); ++f) {
      const ImageField& field = was.fields[f];
      // Mostly it is where it was.
      const core::NameEqual equal;
      const bool there = f < is.fields.size() && equal(is.fields[f].name, field.name);
      const ImageField* const same = there ? &is.fields[f] : field_named(is, field.name);
      path += "." + field.name;
      if (same != nullptr) {
        carry(part_of(field, old), part_of(*same, now), path);
      } else if (!field.internal && !field.fresh && is_kept(now.keep, start_)) {
        misfit(path, "is not there any more");
      }
      path.resize(length);
    }
  }

  void carry_elements(const Part& old, const Part& now, std::string& path) {
    const ImageType& was = old_.types[old.type];
    const ImageType& is = now_.types[now.type];
    const std::uint64_t old_bytes = was.size / was.count, now_bytes = is.size / is.count;
    const std::size_t length = path.size();
    std::uint64_t outside = 0;
    for (std::uint32_t i = 0; i < was.count; ++i) {
      const std::int64_t index = was.lower + static_cast<std::int64_t>(i);
      if (index < is.lower || index - is.lower >= std::int64_t{is.count}) {
        ++outside;
        continue;
      }
      const auto place = static_cast<std::uint64_t>(index - is.lower);
      path += '[';
      path += std::to_string(index);
      path += ']';
      carry({was.element, old.at + i * old_bytes, old.keep, old.internal, false},
            {is.element, now.at + place * now_bytes, now.keep, now.internal, false}, path);
      path.resize(length);
    }
    if (outside == 0 || !is_kept(now.keep, start_)) return;
    misfit(path,
           fmt::format("{} of its {} elements are outside of {}", outside, was.count, type_text(now_.types, now.type)));
  }

  const Layout& old_;
  std::span<const std::byte> from_;
  const Layout& now_;
  std::span<std::byte> to_;
  Start start_;
  bool same_ = false;
  std::map<std::string, std::uint32_t> by_path_;  ///< folded, roots of now_
  std::size_t taken_ = 0;                         ///< values of the present root
  std::vector<Misfit> misfits_;
  std::map<std::string, std::size_t> misfit_of_;
};

}  // namespace

Carried carry_over(const Layout& old, std::span<const std::byte> from, const Layout& now, std::span<std::byte> to,
                   Start start) {
  if (start == Start::kOrigin) return {};
  return Carrier(old, from, now, to, start).run();
}

std::string type_text(const std::vector<ImageType>& types, std::uint32_t index) {
  const ImageType& type = types[index];
  if (type.kind == TypeKind::kArray) {
    return fmt::format("ARRAY [{}..{}] OF {}", type.lower, type.lower + std::int64_t{type.count} - 1,
                       type_text(types, type.element));
  }
  if (!type.name.empty()) return type.name;
  if (type.kind == TypeKind::kString) return fmt::format("{}[{}]", core::name_of(type.elementary), type.capacity);
  if (type.kind == TypeKind::kStruct) return "a structure";
  return type.kind == TypeKind::kRef ? "a reference" : std::string(core::name_of(type.elementary));
}

}  // namespace plc::retain
