#include "engineering/variables.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "core/text.h"
#include "engineering/value_json.h"
#include "runtime/path_lister.h"

namespace plc::engineering {

using bytecode::Image;
using bytecode::ImageField;
using bytecode::ImageType;
using bytecode::TypeKind;
using core::Code;
using core::Problem;
using runtime::Place;

namespace {

bool is_hidden(std::string_view name) { return name.find('#') != std::string_view::npos; }

std::string_view kind_of(const ImageType& type) {
  switch (type.kind) {
    case TypeKind::kStruct:
      return "structure";
    case TypeKind::kArray:
      return "array";
    case TypeKind::kRef:
      return "reference";
    case TypeKind::kScalar:
    case TypeKind::kString:
      break;
  }
  return "value";
}

}  // namespace

void Variables::add_part(std::string path, std::string name, const Place& place, std::vector<Node>& nodes) const {
  nodes.push_back({std::move(name), std::move(path), kind_of(image().types[place.type]), place});
}

Variables::Variables(runtime::Resource& resource, ValueSource& values)
    : resource_(resource), values_(values), roots_(find_roots()) {}

std::vector<Variables::Root> Variables::find_roots() const {
  std::vector<Root> roots;
  const Image& image = this->image();
  std::set<std::uint32_t> named;  // globals that have a name below an instance
  for (std::uint32_t t = 0; t < image.tasks.size(); ++t) {
    const ImageType& whole = image.types[image.pous[image.tasks[t].body].instance_type];
    for (std::uint32_t f = 0; f < whole.fields.size(); ++f) {
      if (is_hidden(whole.fields[f].name)) continue;
      roots.push_back({Root::Kind::kInstance, t, f});
      for (const auto& alias : image.types[whole.fields[f].type].aliases) named.insert(alias.global);
    }
    for (std::uint32_t a = 0; a < whole.aliases.size(); ++a) {
      if (is_hidden(whole.aliases[a].name) || !named.insert(whole.aliases[a].global).second) continue;
      roots.push_back({Root::Kind::kAlias, t, a});
    }
  }
  const auto& globals = image.types[image.global_type].fields;
  std::set<std::string> lists;
  for (std::uint32_t i = 0; i < globals.size(); ++i) {
    const std::string& list = image.globals[i].list;
    if (is_hidden(globals[i].name)) continue;
    if (!list.empty()) {
      if (lists.insert(core::folded(list)).second) roots.push_back({Root::Kind::kList, 0, i});
    } else if (runtime::is_declared_global(globals[i]) || !named.contains(i)) {
      roots.push_back({Root::Kind::kGlobal, 0, i});
    }
  }
  return roots;
}

Node Variables::node_of(const Root& root) const {
  const Image& image = this->image();
  std::vector<Node> one;
  switch (root.kind) {
    case Root::Kind::kInstance: {
      const bytecode::ImageTask& task = image.tasks[root.task];
      const ImageField& field = image.types[image.pous[task.body].instance_type].fields[root.index];
      const std::string name = runtime::in_several_tasks(image, field.name) ? task.name + "." + field.name : field.name;
      const std::uint32_t instances = resource_.program(root.task).table().layout().instance;
      add_part(name, name, {root.task, instances + field.offset, field.type, field.constant}, one);
      break;
    }
    case Root::Kind::kAlias: {
      const auto& alias = image.types[image.pous[image.tasks[root.task].body].instance_type].aliases[root.index];
      add_part(alias.name, alias.name, runtime::place_of_global(image, alias.global), one);
      break;
    }
    case Root::Kind::kGlobal: {
      const std::string& name = image.types[image.global_type].fields[root.index].name;
      add_part(name, name, runtime::place_of_global(image, root.index), one);
      break;
    }
    case Root::Kind::kList: {
      const std::string& list = image.globals[root.index].list;
      one.push_back({list, list, "list", std::nullopt});
      break;
    }
  }
  return std::move(one.front());
}

std::vector<Node> Variables::in_list(std::string_view list, std::size_t from, std::size_t most,
                                     std::size_t& total) const {
  std::vector<Node> nodes;
  const Image& image = this->image();
  const auto& globals = image.types[image.global_type].fields;
  total = 0;
  for (std::uint32_t i = 0; i < globals.size(); ++i) {
    if (is_hidden(globals[i].name) || image.globals[i].list.empty() || !core::iequals(image.globals[i].list, list))
      continue;
    if (total++ < from || nodes.size() >= most) continue;
    add_part(image.globals[i].list + "." + globals[i].name, globals[i].name, runtime::place_of_global(image, i), nodes);
  }
  return nodes;
}

core::Result<std::vector<Node>> Variables::children(std::string_view path, std::size_t from, std::size_t most,
                                                    std::size_t& total) const {
  const Image& image = this->image();
  std::vector<Node> nodes;
  const auto cut = [&](std::vector<Node> all) {
    total = all.size();
    std::vector<Node> part;
    for (std::size_t i = from; i < all.size() && part.size() < most; ++i) part.push_back(std::move(all[i]));
    return part;
  };
  if (path.empty()) {
    total = roots_.size();
    for (std::size_t i = from; i < roots_.size() && nodes.size() < most; ++i) nodes.push_back(node_of(roots_[i]));
    return nodes;
  }
  auto place = runtime::Access(resource_).find(path);
  if (!place) {
    nodes = in_list(path, from, most, total);
    if (total == 0) return place.error();
    return nodes;
  }
  const ImageType& type = image.types[place->type];
  const std::string begin(core::trimmed(path));
  if (type.kind == TypeKind::kArray) {
    total = type.count;
    const std::uint32_t size = image.types[type.element].size;
    for (std::size_t i = from; i < type.count && nodes.size() < most; ++i) {
      const std::string name = "[" + std::to_string(type.lower + static_cast<std::int64_t>(i)) + "]";
      add_part(begin + name, name,
               {place->task, place->offset + static_cast<std::uint32_t>(i) * size, type.element, place->constant},
               nodes);
    }
    return nodes;
  }
  if (type.kind == TypeKind::kStruct) {
    for (const ImageField& field : type.fields) {
      if (is_hidden(field.name)) continue;
      add_part(begin + "." + field.name, field.name,
               {place->task, place->offset + field.offset, field.type, place->constant || field.constant}, nodes);
    }
    for (const auto& alias : type.aliases) {
      if (is_hidden(alias.name)) continue;
      add_part(begin + "." + alias.name, alias.name, runtime::place_of_global(image, alias.global), nodes);
    }
  }
  return cut(std::move(nodes));
}

bool Variables::is_writable(const Place& place) const {
  if (place.task != Place::kGlobal || place.constant) return false;
  const runtime::GlobalTable& globals = resource_.globals();
  return globals.writable(globals.field_of(place.offset));
}

std::string_view Variables::address(const Place& place) const {
  if (place.task != Place::kGlobal) return {};
  const Image& image = this->image();
  const std::uint32_t field = resource_.globals().field_of(place.offset);
  const ImageField& whole = image.types[image.global_type].fields[field];
  if (whole.offset != place.offset || whole.type != place.type) return {};
  return image.globals[field].address;
}

core::Result<Place> Variables::find(std::string_view path) const {
  auto place = runtime::Access(resource_).find(path);
  if (place && !is_readable(*place)) {
    return Problem{Code::P7720,
                   "\"" + std::string(path) + "\" is a variable of task " + image().tasks[place->task].name +
                       ", which tells its globals alone",
                   "make it a global, or map it to one"};
  }
  return place;
}

Json Variables::read(const Place& place) const {
  std::vector<std::byte> bytes(image().types[place.type].size);
  values_.read(place.task, place.offset, static_cast<std::uint32_t>(bytes.size()), bytes.data());
  return value_json(image(), place.type, bytes.data());
}

std::optional<Problem> Variables::prepare(std::string_view path, const Json& value, std::vector<Write>& writes,
                                          std::string& field) const {
  const auto place = runtime::Access(resource_).find(path);
  if (!place) return place.error();
  if (place->task != Place::kGlobal) {
    return Problem{Code::P7106, "\"" + std::string(path) + "\" is a variable of a task, which alone writes it",
                   "write a global that the program reads"};
  }
  if (place->constant) return Problem{Code::P7106, "the variable is declared CONSTANT", {}};
  if (!is_writable(*place)) {
    return Problem{Code::P7106, "the variable is an input of a driver", "take it out of [inputs] in plc.toml"};
  }
  std::vector<LeafValue> leaves;
  if (auto problem = leaves_of(image(), place->type, value, 0, leaves, field)) return problem;
  for (LeafValue& leaf : leaves) {
    writes.push_back({*place, place->offset + leaf.offset, leaf.type, std::move(leaf.bytes)});
  }
  return std::nullopt;
}

std::optional<Problem> Variables::write(std::span<const Write> writes) {
  std::vector<runtime::GlobalWrite> batch;
  batch.reserve(writes.size());
  for (const Write& write : writes) batch.push_back({write.offset, write.type, write.bytes.data(), nullptr});
  switch (resource_.globals().write(batch)) {
    case runtime::WriteResult::kDone:
      return std::nullopt;
    case runtime::WriteResult::kBusy:
      return Problem{Code::P7107, "a task has not started for long and too many writes are waiting for it",
                     "is it stopped by a fault, or its period very long?"};
    case runtime::WriteResult::kRefused:
      break;
  }
  return Problem{Code::P7106, "a variable is a constant or an input of a driver", {}};
}

}  // namespace plc::engineering
