#include "retain/layout.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "bytecode/fingerprint.h"
#include "core/text.h"

namespace plc::retain {
namespace {

using bytecode::Image;
using bytecode::ImageField;
using bytecode::ImageType;
using bytecode::TypeKind;

struct Found {
  Root root;  ///< type: of the image; at: not yet
  Source source;
};

/// Walks through tables to what is marked.
class Finder {
 public:
  Finder(const Image& image, What what) : image_(image), what_(what), marked_(image.types.size()) {
    for (std::size_t t = 0; t < image.types.size(); ++t) {
      const ImageType& type = image.types[t];
      if (bytecode::is_taskblock_type(image, static_cast<std::uint32_t>(t))) continue;
      marked_[t] = type.kind == TypeKind::kArray && marked_[type.element];
      for (const ImageField& field : type.fields) {
        marked_[t] = marked_[t] || field.retain || field.persistent || marked_[field.type];
      }
    }
  }

  void look_at(const std::string& path, const ImageField& field, Source source, bool internal) {
    const ImageType& type = image_.types[field.type];
    internal = internal || field.internal;
    if (field.constant || type.size == 0 || is_reference(type)) return;
    if (what_ == What::kMarked && !field.retain && !field.persistent)
      return look_into(path, field.type, source, internal);
    if (bytecode::is_taskblock_type(image_, field.type)) return;
    found.push_back({{path, field.type, 0, field.persistent, internal}, source});
  }

  std::vector<Found> found;

 private:
  void look_into(const std::string& path, std::uint32_t index, Source source, bool internal) {
    if (!marked_[index]) return;
    const ImageType& type = image_.types[index];
    const std::uint32_t from = source.offset;
    for (const ImageField& field : type.fields) {
      source.offset = from + field.offset;
      look_at(path + "." + field.name, field, source, internal);
    }
    for (std::uint32_t i = 0; type.kind == TypeKind::kArray && i < type.count; ++i) {
      source.offset = from + i * image_.types[type.element].size;
      look_into(fmt::format("{}[{}]", path, type.lower + static_cast<std::int64_t>(i)), type.element, source, internal);
    }
  }

  const Image& image_;
  What what_;
  std::vector<bool> marked_;  ///< by type: something in it is kept
};

/// Takes over the types that are needed, in their order.
class TypeSubset {
 public:
  TypeSubset(const Image& image, What what, std::vector<ImageType>& out)
      : image_(image), what_(what), out_(out), index_(image.types.size()) {}

  std::uint32_t take(std::uint32_t from) {
    if (index_[from]) return *index_[from];
    ImageType type = image_.types[from];
    type.aliases.clear();
    if (type.kind == TypeKind::kRef) type.element = 0;
    if (type.kind == TypeKind::kArray) type.element = take(type.element);
    // What a taskblock shows is its object's, and the object is made anew.
    const bool taskblock = bytecode::is_taskblock_type(image_, from);
    std::erase_if(type.fields,
                  [&](const ImageField& field) { return taskblock || image_.types[field.type].size == 0; });
    for (ImageField& field : type.fields) {
      field.type = take(field.type);
      if (what_ == What::kEverything) field.fresh = false;
    }
    out_.push_back(std::move(type));
    index_[from] = static_cast<std::uint32_t>(out_.size() - 1);
    return *index_[from];
  }

 private:
  const Image& image_;
  What what_;
  std::vector<ImageType>& out_;
  std::vector<std::optional<std::uint32_t>> index_;
};

std::vector<Found> find_all(const runtime::Resource& resource, What what) {
  const Image& image = resource.image();
  Finder finder(image, what);
  std::set<std::string> instances, twice;
  for (const bytecode::ImageTask& task : image.tasks) {
    for (const ImageField& field : image.types[image.pous[task.body].instance_type].fields) {
      if (!instances.insert(core::folded(field.name)).second) twice.insert(core::folded(field.name));
    }
  }
  for (std::uint32_t t = 0; t < image.tasks.size(); ++t) {
    const bytecode::ImageTask& task = image.tasks[t];
    for (const ImageField& field : image.types[image.pous[task.body].instance_type].fields) {
      const bool several = twice.contains(core::folded(field.name));
      finder.look_at(several ? task.name + "." + field.name : field.name, field, {t, field.offset, false}, false);
    }
  }
  const std::vector<ImageField>& globals = image.types[image.global_type].fields;
  for (std::uint32_t g = 0; g < globals.size(); ++g) {
    const std::string& list = image.globals[g].list;
    std::string path = list.empty() ? globals[g].name : list + "." + globals[g].name;
    // As in CODESYS, where a dot says that the global is meant.
    if (instances.contains(core::folded(path))) path.insert(0, 1, '.');
    const auto owner = resource.globals().owning_task(g);
    finder.look_at(path, globals[g], {owner.value_or(Source::kShared), globals[g].offset, true}, false);
  }
  return std::move(finder.found);
}

}  // namespace

bool is_reference(const ImageType& type) {
  return type.kind == TypeKind::kRef || (type.kind == TypeKind::kScalar && type.elementary == core::TypeId::kPointer);
}

Kept find_kept(const runtime::Resource& resource, What what) {
  const Image& image = resource.image();
  std::vector<Found> found = find_all(resource, what);
  std::stable_sort(found.begin(), found.end(), [](const Found& a, const Found& b) {
    return std::pair(a.source.task, a.source.global) < std::pair(b.source.task, b.source.global);
  });
  Kept kept;
  Layout& layout = kept.layout;
  layout.project = image.project;
  if (!found.empty()) layout.program = bytecode::fingerprint(image);
  TypeSubset types(image, what, layout.types);
  const Source* before = nullptr;
  std::uint64_t end_there = 0;  // of the last one, in its table
  for (Found& one : found) {
    const Source& source = one.source;
    const std::uint32_t size = image.types[one.root.type].size;
    // What is between neighbours is copied with them.
    const bool neighbour = before != nullptr && before->task == source.task && before->global == source.global &&
                           source.offset >= end_there && source.offset - end_there < image.types[one.root.type].align;
    one.root.at = layout.bytes + (neighbour ? source.offset - end_there : 0);
    layout.bytes = one.root.at + size;
    end_there = std::uint64_t{source.offset} + size;
    one.root.type = types.take(one.root.type);
    before = &source;
    layout.roots.push_back(std::move(one.root));
  }
  for (const Found& one : found) kept.sources.push_back(one.source);
  return kept;
}

}  // namespace plc::retain
