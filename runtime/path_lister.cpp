#include "runtime/path_lister.h"

#include <algorithm>

#include "core/glob.h"

namespace plc::runtime {

using bytecode::Image;
using bytecode::ImageAlias;
using bytecode::ImageField;
using bytecode::ImageType;
using bytecode::TypeKind;

namespace {

bool matches_everything(std::string_view pattern) {
  return !pattern.empty() && pattern.find_first_not_of('*') == std::string_view::npos;
}

/// The variable's own name: "Lamp" of "Logic.Lamp" and "main.valves[2].Lamp".
std::string_view last_name(std::string_view name) {
  return name.starts_with('%') ? name : name.substr(name.rfind('.') + 1);
}

}  // namespace

bool is_declared_global(const ImageField& global) {
  return !global.name.starts_with('%') && global.name.find('.') == std::string::npos;
}

bool in_several_tasks(const Image& image, std::string_view name) {
  std::size_t tasks = 0;
  for (const bytecode::ImageTask& task : image.tasks) {
    const auto& fields = image.types[image.pous[task.body].instance_type].fields;
    tasks +=
        std::any_of(fields.begin(), fields.end(), [name](const ImageField& f) { return core::iequals(f.name, name); })
            ? 1
            : 0;
  }
  return tasks > 1;
}

Place place_of_global(const Image& image, std::size_t index) {
  const ImageField& field = image.types[image.global_type].fields[index];
  return {Place::kGlobal, field.offset, field.type, field.constant};
}

PathLister::PathLister(const Resource& resource, std::string_view pattern, std::size_t limit, Paths paths)
    : resource_(resource),
      image_(resource.image()),
      globals_(image_.types[image_.global_type].fields),
      pattern_(pattern),
      limit_(limit),
      hidden_(pattern.find('#') != std::string_view::npos),
      paths_(paths == Paths::kAll && matches_everything(pattern) ? Paths::kOnce : paths),
      listed_(globals_.size()) {
  if (paths_ != Paths::kNames) return;
  for (std::size_t i = 0; i < globals_.size(); ++i) {
    if (is_declared_global(globals_[i])) named_.insert(std::to_string(i) + " " + globals_[i].name);
  }
}

void PathLister::run() {
  for (std::uint32_t t = 0; t < image_.tasks.size(); ++t) {
    const bytecode::ImageTask& task = image_.tasks[t];
    const std::uint32_t instances = resource_.program(t).table().layout().instance;
    const ImageType& whole = image_.types[image_.pous[task.body].instance_type];
    for (const ImageField& field : whole.fields) {
      if (!shows(field.name)) continue;
      std::string path = in_several_tasks(image_, field.name) ? task.name + "." + field.name : field.name;
      walk(path, {t, instances + field.offset, field.type, field.constant}, false);
    }
    std::string path;
    walk_aliases(path, whole);  // located variables of the instances have whole paths
  }
  for (const bool declared : {true, false}) {
    for (std::size_t i = 0; i < globals_.size(); ++i) {
      if (is_declared_global(globals_[i]) == declared) add_global(i);
    }
    std::string path;
    if (declared) walk_aliases(path, image_.types[image_.global_type]);  // second names of globals
  }
}

void PathLister::add_global(std::size_t index) {
  if (!shows(globals_[index].name) || (paths_ != Paths::kAll && listed_[index])) return;
  listed_[index] = true;
  const std::string& list = image_.globals[index].list;
  root_name_ = last_name(globals_[index].name);
  std::string path = list.empty() ? globals_[index].name : list + "." + globals_[index].name;
  walk(path, place_of_global(image_, index), false);
  if (pattern_.starts_with('%') && !image_.globals[index].address.empty()) {
    path = root_name_ = image_.globals[index].address;
    walk(path, place_of_global(image_, index), false);
  }
}

void PathLister::walk(std::string& path, const Place& place, bool inside_alias) {
  if (found_.size() >= limit_) return;
  const ImageType& type = image_.types[place.type];
  const std::size_t length = path.size();
  switch (type.kind) {
    case TypeKind::kScalar:
    case TypeKind::kString:
      if (!core::glob_match(pattern_, path) || !known_.insert(path).second) return;
      found_.push_back({path, place});
      if (paths_ != Paths::kOnce) keys_.push_back(key_of(place));
      return;
    case TypeKind::kRef:
      return;
    case TypeKind::kArray:
      for (std::uint32_t i = 0; i < type.count && found_.size() < limit_; ++i) {
        path += '[';
        path += std::to_string(type.lower + static_cast<std::int64_t>(i));
        path += ']';
        Place element = place;
        element.offset += i * image_.types[type.element].size;
        element.type = type.element;
        walk(path, element, inside_alias);
        path.resize(length);
      }
      return;
    case TypeKind::kStruct:
      for (const ImageField& field : type.fields) {
        if (!states_ && field.role == bytecode::FieldRole::kState) continue;
        const Place member = {place.task, place.offset + field.offset, field.type, place.constant || field.constant};
        walk_named(path, field.name, member, inside_alias);
      }
      if (!inside_alias) walk_aliases(path, type);
      return;
  }
}

void PathLister::walk_aliases(std::string& path, const ImageType& type) {
  const std::string_view before = root_name_;
  for (const ImageAlias& alias : type.aliases) {
    if (!lists_alias(alias)) continue;
    root_name_ = last_name(alias.name);
    walk_named(path, alias.name, place_of_global(image_, alias.global), true);
  }
  root_name_ = before;
}

void PathLister::walk_named(std::string& path, const std::string& name, const Place& place, bool inside_alias) {
  if (!shows(name)) return;
  const std::size_t length = path.size();
  if (!path.empty()) path += '.';
  path += name;
  walk(path, place, inside_alias);
  path.resize(length);
}

bool PathLister::lists_alias(const ImageAlias& alias) {
  if (paths_ == Paths::kAll) return true;
  if (!shows(alias.name)) return false;
  if (paths_ == Paths::kNames) {
    const bool fresh = named_.insert(std::to_string(alias.global) + " " + std::string(last_name(alias.name))).second;
    if (fresh && !is_declared_global(globals_[alias.global])) listed_[alias.global] = true;
    return fresh;
  }
  if (is_declared_global(globals_[alias.global]) || listed_[alias.global]) return false;
  listed_[alias.global] = true;
  return true;
}

std::string PathLister::key_of(const Place& place) const {
  if (place.task != Place::kGlobal) return {};
  return std::to_string(place.offset) + " " + std::to_string(place.type) + " " + std::string(root_name_);
}

void PathLister::add_missing(PathLister&& other) {
  Names keys(keys_.begin(), keys_.end());
  for (std::size_t i = 0; i < other.found_.size() && found_.size() < limit_; ++i) {
    const bool fresh =
        other.keys_[i].empty() ? known_.insert(other.found_[i].path).second : keys.insert(other.keys_[i]).second;
    if (fresh) found_.push_back(std::move(other.found_[i]));
  }
}

}  // namespace plc::runtime
