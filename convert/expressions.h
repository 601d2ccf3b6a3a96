// Expressions: values and places of a body as text of ST, and the statements of instructions that neither jump nor are
// jumped to.
//
// In: a body, its plan. Out: text; or the problem that leaves none. Does not belong here: control flow
// (body_writer.h).
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "convert/body_plan.h"
#include "convert/body_writer.h"
#include "ir/ir.h"

namespace plc::convert {

class Expressions {
 public:
  Expressions(const ir::Module& module, const ir::Pou& pou, const ir::Pou& owner, const BodyPlan& plan,
              AddedVariables& added)
      : module_(module),
        pou_(pou),
        body_(pou.body),
        owner_(owner),
        plan_(plan),
        added_(added),
        values_(pou.body.insts.size()) {
    find_eno();
  }

  /// The statements that instruction `i` needs: none for values that are written where they are used.
  std::vector<std::string> statements(std::uint32_t i);
  /// BOOL value `value` for an IF.
  std::string condition(std::uint32_t value, bool negate);
  /// A variable that counts the blocks of a body.
  std::optional<std::string> counter();
  /// Forgets the values: the body is written anew.
  void reset() {
    values_.assign(body_.insts.size(), {});
    arguments_.clear();
  }

  /// Why there is no text, as part of a sentence; empty when there is.
  [[nodiscard]] const std::string& problem() const { return problem_; }
  [[nodiscard]] const core::SourceRef& problem_at() const { return problem_at_; }

 private:
  /// How tightly a text binds, as operators of ST do (IEC 61131-3, table 71).
  enum class Binding : std::uint8_t { kNothing, kOr, kXor, kAnd, kCompare, kSum, kProduct, kNot, kOperand };
  struct Value {
    std::string text;
    Binding binding = Binding::kNothing;
    std::string_view op;  ///< of an operator that takes a further operand of its own kind: "AND"
  };

  void find_eno();
  std::string fail(std::string problem);
  /// The text of a value as an operand of something that binds so tightly.
  std::string operand(std::uint32_t value, Binding binding, std::string_view op = {});
  const Value& value(std::uint32_t id);
  Value binary(std::string_view op, Binding binding, std::uint32_t a, std::uint32_t b);
  Value compute(std::uint32_t i);
  Value call(std::uint32_t i);
  Value call_pou(std::uint32_t i);
  std::string extract(const ir::Inst& inst);
  std::string place(ir::PlaceId id);
  /// Whether it is a REFERENCE TO: a name of this type is what it refers to.
  [[nodiscard]] bool stands_for_variable(ir::TypeRef type) const;
  /// What a reference leads to, where its receiver takes a variable.
  std::string referred(std::uint32_t reference);
  std::string root_name(const ir::Place& p);
  std::string variable_name(std::uint32_t index);
  std::string global_name(std::uint32_t index);
  std::string part_suffix(ir::TypeRef part, std::uint32_t bit) const;
  void store(std::uint32_t i, std::vector<std::string>& out);
  void run(std::uint32_t i, std::vector<std::string>& out);
  void keep_output(std::uint32_t i, std::vector<std::string>& out);
  void keep(std::uint32_t i, const Value& made, std::vector<std::string>& out);

  const ir::Module& module_;
  const ir::Pou& pou_;
  const ir::Body& body_;
  const ir::Pou& owner_;
  const BodyPlan& plan_;
  AddedVariables& added_;
  std::vector<Value> values_;
  std::map<std::uint32_t, std::vector<std::uint32_t>> arguments_;  ///< stores by the run they are arguments of
  std::map<std::uint32_t, std::string> eno_of_call_;               ///< BOOL that ENO of a call goes to
  std::uint32_t now_ = 0;                                          ///< the instruction that is written
  std::string problem_;
  core::SourceRef problem_at_;
};

}  // namespace plc::convert
