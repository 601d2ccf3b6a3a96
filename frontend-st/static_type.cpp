#include "frontend-st/static_type.h"

#include "core/text.h"
#include "frontend-st/addresses.h"
#include "frontend-st/literals.h"
#include "frontend-st/names.h"
#include "ir/foreign_size.h"

namespace plc::st {
namespace {

using ir::TypeKind;
using ir::TypeRef;

class Finder {
 public:
  Finder(const Ast& ast, const SourceText& source, const ir::Module& module, const ir::Pou* pou)
      : ast_(ast), source_(source), module_(module), pou_(pou) {}

  // Postfix chains have no limit: from the root to the end in a loop.
  std::optional<TypeRef> type(NodeId id) {
    std::vector<NodeId> path;
    for (; is_step(ast_[id].kind); id = ast_[id].a) path.push_back(id);
    std::optional<TypeRef> type;
    if (ast_[id].kind == NodeKind::kDirect) {
      std::string problem;
      const auto address = parse_address(name(id), problem);
      if (!address || address->unlocated) return std::nullopt;
      type = ir::ref_of(address->type());
    } else if (ast_[id].kind == NodeKind::kName) {
      type = variable(name(id));
      if (!type && !path.empty() && ast_[path.back()].kind == NodeKind::kMember) {
        const auto global = module_.global_by_name.find(std::string(name(id)) + "." + std::string(name(path.back())));
        if (global == module_.global_by_name.end()) return std::nullopt;
        type = module_.globals[global->second].variable.type;
        path.pop_back();
      }
    }
    if (type) type = followed(*type);
    for (; type && !path.empty(); path.pop_back()) {
      type = step(*type, path.back());
      if (type) type = followed(*type);
    }
    return type;
  }

 private:
  /// What a REFERENCE TO stands for.
  [[nodiscard]] TypeRef followed(TypeRef type) const {
    while (module_.types[type].implicit) type = module_.types[type].element;
    return type;
  }
  static bool is_step(NodeKind kind) {
    return kind == NodeKind::kMember || kind == NodeKind::kIndex || kind == NodeKind::kDeref || kind == NodeKind::kBit;
  }
  [[nodiscard]] std::string_view name(NodeId id) const { return source_.slice(ast_[id].name, ast_[id].name_end); }
  [[nodiscard]] TypeRef type_of(const ir::Variable& variable) const {
    return variable.role == ir::Role::kInOut ? module_.types[variable.type].element : variable.type;
  }

  std::optional<TypeRef> variable(std::string_view name) const {
    if (pou_ != nullptr) {
      const Named named = find_name(module_, *pou_, name);
      if (named.kind == Named::Kind::kVariable) return type_of(pou_->variables[named.index]);
      if (named.kind != Named::Kind::kGlobal) return std::nullopt;
      return module_.globals[named.index].variable.type;
    }
    const auto global = module_.global_by_name.find(name);
    if (global == module_.global_by_name.end()) return std::nullopt;
    return module_.globals[global->second].variable.type;
  }

  std::optional<TypeRef> step(TypeRef type, NodeId id) const {
    const ir::Type& t = module_.types[type];
    switch (ast_[id].kind) {
      case NodeKind::kMember:
        return member(type, name(id));
      case NodeKind::kDeref:
        return t.kind == TypeKind::kReference || t.kind == TypeKind::kPointer ? std::optional(t.element) : std::nullopt;
      case NodeKind::kIndex: {
        std::optional<TypeRef> element = type;
        for (NodeId index = ast_[id].b; element && index != kNoNode; index = ast_[index].next) {
          element = element_of(*element);
        }
        return element;
      }
      default: {
        const std::string_view part = name(id);
        const char size = part.size() > 1 && part[0] == '%' ? core::upper(part[1]) : 'X';
        using enum core::TypeId;
        return ir::ref_of(size == 'B' ? kByte : size == 'W' ? kWord : size == 'D' ? kDword : kBool);
      }
    }
  }

  std::optional<TypeRef> element_of(TypeRef type) const {
    const ir::Type& t = module_.types[type];
    if (t.kind == TypeKind::kArray || t.kind == TypeKind::kPointer) return t.element;
    if (t.kind != TypeKind::kString) return std::nullopt;
    return ir::ref_of(t.elementary == core::TypeId::kWstring ? core::TypeId::kWchar : core::TypeId::kChar);
  }

  std::optional<TypeRef> member(TypeRef type, std::string_view name) const {
    const ir::Type& t = module_.types[type];
    if (t.kind == TypeKind::kStruct || t.kind == TypeKind::kUnion) {
      const auto position = module_.types.position_of(type, name);
      return position ? std::optional(t.fields[*position].type) : std::nullopt;
    }
    if (t.kind == TypeKind::kBlock) {
      const stdlib::Field* const field = stdlib::field_named(*t.block, name);
      return field != nullptr ? std::optional(ir::ref_of(field->type)) : std::nullopt;
    }
    if (t.kind != TypeKind::kPou) return std::nullopt;
    const ir::Variable* const variable = module_.pous[t.pou].find(name);
    return variable != nullptr ? std::optional(type_of(*variable)) : std::nullopt;
  }

  const Ast& ast_;
  const SourceText& source_;
  const ir::Module& module_;
  const ir::Pou* pou_;
};

/// STRING(20) and STRING[20], which the grammar takes for a call and an index.
std::optional<TypeRef> sized_string(const Ast& ast, const SourceText& source, NodeId id, ir::Module& module) {
  const Node& node = ast[id];
  const bool call = node.kind == NodeKind::kCall;
  if ((!call && node.kind != NodeKind::kIndex) || ast[node.a].kind != NodeKind::kName) return std::nullopt;
  const auto type = core::type_named(source.slice(ast[node.a].name, ast[node.a].name_end));
  if (!type || !core::in_category(*type, core::kAnyString) || node.b == kNoNode) return std::nullopt;
  const NodeId length = call ? ast[node.b].a : node.b;
  if (length == kNoNode) return std::nullopt;
  std::string problem;
  const auto number = parse_literal(source.slice(ast[length].begin, ast[length].end), problem);
  if (!number || number->kind != Literal::Kind::kInt || number->int_value < 1 ||
      number->int_value > core::kMaxStringCapacity) {
    return std::nullopt;
  }
  return module.types.string(*type, static_cast<std::uint16_t>(number->int_value));
}

}  // namespace

std::optional<TypeRef> static_type(const Ast& ast, const SourceText& source, NodeId id, const ir::Module& module,
                                   const ir::Pou* pou) {
  if (id == kNoNode) return std::nullopt;
  return Finder(ast, source, module, pou).type(id);
}

std::optional<std::uint64_t> size_of_named(const Ast& ast, const SourceText& source, NodeId id, ir::Module& module,
                                           const ir::Pou* pou, std::string& problem) {
  auto type = static_type(ast, source, id, module, pou);
  const std::string_view text = source.slice(ast[id].begin, ast[id].end);
  if (!type && ast[id].kind == NodeKind::kName) type = module.types.find(text);
  if (!type) type = sized_string(ast, source, id, module);
  if (!type) {
    problem = '"' + std::string(text) + "\" is neither a variable nor a type";
    return std::nullopt;
  }
  const auto size = ir::foreign_size(module.types, *type);
  if (!size) {
    problem = '"' + std::string(text) + "\" of type " + module.types.name_of(*type) +
              " has no size that is the same everywhere";
  }
  return size;
}

}  // namespace plc::st
