// BodyWriter: a body of the IR as statements of ST. Values go where they are used as long as nothing in between could
// change them; others get a variable of their own. Forward jumps become IF; other jumps a loop around a CASE.
//
// In: a Module and one of its POUs. Out: statements, and the variables they need beside those declared. Does not belong
// here: declarations (declaration_writer.h).
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <unordered_set>
#include <utility>
#include <vector>

#include "core/text.h"
#include "ir/ir.h"

namespace plc::convert {

/// A variable that a body has and its source does not declare.
struct AddedVariable {
  std::string name;
  std::string type;
  std::string initial;     ///< as text, or empty
  bool temporary = false;  ///< needs no memory between calls
};

/// Names that added variables of one POU must not have, and those they got.
class AddedVariables {
 public:
  AddedVariables(const ir::Module& module, const ir::Pou& owner) : module_(module), owner_(owner) {}

  /// The name of hidden variable `index` of the owner. Nothing when its type has no name.
  std::optional<std::string> hidden(std::uint32_t index);
  /// A variable that the drawing uses and nobody declares, by its own name.
  void declare(std::string name, std::string type) { all_.push_back({std::move(name), std::move(type), {}, false}); }
  /// A new variable for a value.
  std::optional<std::string> temporary(ir::TypeRef type);
  /// A name that nothing else has which bodies of the owner see, and that nothing gets after it: `wish`, or with a
  /// number after it.
  std::string unused(const std::string& wish);
  [[nodiscard]] const std::vector<AddedVariable>& all() const { return all_; }

  /// What is added after save() is taken back by restore().
  struct State {
    std::vector<AddedVariable> all;
    std::map<std::uint32_t, std::string> hidden;
    std::unordered_set<std::string, core::NameHash, core::NameEqual> taken;
  };
  [[nodiscard]] State save() const { return {all_, hidden_, taken_}; }
  void restore(State state) {
    all_ = std::move(state.all);
    hidden_ = std::move(state.hidden);
    taken_ = std::move(state.taken);
  }

 private:
  const ir::Module& module_;
  const ir::Pou& owner_;
  std::vector<AddedVariable> all_;
  std::map<std::uint32_t, std::string> hidden_;
  std::unordered_set<std::string, core::NameHash, core::NameEqual> taken_;
};

struct WrittenBody {
  std::string text;     ///< statements, each line indented by two blanks
  bool loop = false;    ///< jumps became a loop around a CASE
  std::string problem;  ///< why there is no text, as part of a sentence; or empty
  core::SourceRef at;   ///< of the problem
};

/// Writes the body of `pou`, a POU or an action of `owner`.
WrittenBody write_body(const ir::Module& module, const ir::Pou& pou, const ir::Pou& owner, AddedVariables& added);

}  // namespace plc::convert
