#include "frontend-st/choosing.h"

#include <algorithm>
#include <optional>
#include <string_view>

#include "core/text.h"
#include "frontend-st/parser.h"
#include "frontend-st/static_type.h"
#include "stdlib/library.h"

namespace plc::st {
namespace {

class Names : public Surroundings {
 public:
  Names(ir::Module& module, const ir::Pou& pou) : module_(module), pou_(pou) {}

  [[nodiscard]] bool has_variable(std::string_view path) const override { return type_of(path).has_value(); }
  [[nodiscard]] bool has_type(std::string_view name) const override {
    const auto type = module_.types.find(name);
    return core::type_named(name).has_value() || (type && module_.types[*type].kind != ir::TypeKind::kPou &&
                                                  module_.types[*type].kind != ir::TypeKind::kBlock);
  }
  [[nodiscard]] bool has_pou(std::string_view name) const override {
    return module_.pou_by_name.find(name) != module_.pou_by_name.end() || stdlib::is_function(name) ||
           stdlib::block_named(name) != nullptr;
  }
  [[nodiscard]] bool has_task(std::string_view name) const override {
    return std::any_of(module_.tasks.begin(), module_.tasks.end(),
                       [&](const ir::Task& task) { return core::iequals(task.name, name); });
  }
  [[nodiscard]] bool is_of_type(std::string_view path, std::string_view type) const override {
    const auto found = type_of(path);
    if (!found) return false;
    const auto elementary = core::type_named(type);
    const auto wanted = elementary ? std::optional(ir::ref_of(*elementary)) : module_.types.find(type);
    const bool text = elementary && core::in_category(*elementary, core::kAnyString);
    if (text) return module_.types.elementary_of(*found) == elementary;
    return wanted && *wanted == *found;
  }
  [[nodiscard]] bool pou_has_attribute(std::string_view pou, std::string_view attribute) const override {
    return module_.attributes.contains(ir::attribute_key(pou, {}, attribute));
  }
  [[nodiscard]] bool variable_has_attribute(std::string_view variable, std::string_view attribute) const override {
    return module_.attributes.contains(ir::attribute_key(pou_.name, variable, attribute)) ||
           module_.attributes.contains(ir::attribute_key({}, variable, attribute));
  }

 private:
  [[nodiscard]] std::optional<ir::TypeRef> type_of(std::string_view path) const {
    const SourceText source(path);
    core::Diagnostics unused;
    Parser parser(source, unused, {});
    const NodeId root = parser.parse_expression();
    return root == kNoNode ? std::nullopt : static_type(parser.ast(), source, root, module_, &pou_);
  }

  ir::Module& module_;
  const ir::Pou& pou_;
};

}  // namespace

ChosenText choose(const SourceText& source, ir::Builder& builder, const std::vector<std::string>* defines) {
  const Names names(builder.module(), builder.pou());
  return {source, Defines(defines != nullptr ? *defines : builder.module().options.defines), names,
          builder.diagnostics(), builder.name()};
}

}  // namespace plc::st
