// Lowering: syntax tree of one text -> IR through the Builder of its POU. Shared by expressions, places, calls and
// statements; what each file adds is in its own .cpp (lower_expression, lower_place, lower_call,
// lower_arguments, lower_library_call, lower_statements, lower_case, lower_loops, ..).
//
// In: Ast and SourceText of one text. Out: instructions, operands, places. Does not belong here: syntax, declarations.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "frontend-st/ast.h"
#include "frontend-st/names.h"
#include "frontend-st/source_text.h"
#include "ir/builder.h"
#include "ir/generic.h"

namespace plc::st {

/// Values that the labels of one CASE took so far.
class LabelRanges {
 public:
  /// Takes `low` to `high`. False when all of it was taken before.
  bool take(std::int64_t low, std::int64_t high);

 private:
  std::map<std::int64_t, std::int64_t> ranges_;  ///< first value -> last value, apart from each other
};

class Lowering {
 public:
  Lowering(ir::Builder& builder, const SourceText& source, const Ast& ast)
      : builder_(builder), source_(source), ast_(ast) {}

  std::optional<ir::Operand> value(NodeId id, std::optional<ir::TypeRef> expected);
  /// Nothing after an error, and for members of stubs (which are warnings; see stub_used).
  std::optional<ir::PlaceId> place(NodeId id, bool for_writing);
  /// What nodes kGiven with the number `number` stand for from now on.
  void give(std::uint32_t number, const ir::Operand& operand);
  /// Lowers the list that begins with `first`. False when any statement had an error.
  bool statements(NodeId first);
  /// Makes the REFERENCE TO at `where` stand for the variable at `written`. False after an error.
  bool bind(ir::PlaceId where, NodeId written);
  /// True when the last place() failed without an error because a stub is in its way.
  [[nodiscard]] bool stub_used() const { return stub_used_; }

 private:
  using Expected = std::optional<ir::TypeRef>;

  /// A parameter of a function POU, function block or standard function, copied: tables grow while arguments are
  /// lowered.
  struct Parameter {
    std::string name;
    ir::Role role = ir::Role::kInput;
    std::uint32_t index = 0;  ///< into the callee's variables or fields
    ir::TypeRef type{};       ///< in-outs: the declared type, not the reference
    std::string alias{};      ///< another name drawings and texts use for it, or empty
    bool constant = false;    ///< in-outs: VAR_IN_OUT CONSTANT, which is read and never written
    /// Whether an argument without name may stand for it.
    [[nodiscard]] bool has_place() const;
  };
  /// Arguments of one call, EN and ENO taken out; `parameter` numbers an entry of the parameter list.
  struct Bound {
    std::uint32_t parameter = 0;
    NodeId argument = kNoNode;
  };
  struct Arguments {
    std::vector<Bound> bound;
    NodeId en = kNoNode;   ///< value of EN
    NodeId eno = kNoNode;  ///< place that takes ENO
    bool fine = true;
  };

  // helpers
  [[nodiscard]] const Node& node(NodeId id) const { return ast_[id]; }
  [[nodiscard]] std::string_view text(NodeId id) const { return source_.slice(node(id).begin, node(id).end); }
  [[nodiscard]] std::string_view name_text(NodeId id) const { return source_.slice(node(id).name, node(id).name_end); }
  [[nodiscard]] core::SourceRef at(NodeId id) const { return source_.locate(node(id).begin); }
  [[nodiscard]] core::SourceRef name_at(NodeId id) const { return source_.locate(node(id).name); }
  void report(core::Code code, const core::SourceRef& where, std::string message, std::string help = {}) {
    builder_.report(code, where, std::move(message), std::move(help));
  }
  ir::TypeTable& types() { return builder_.module().types; }
  ir::Operand operand(ir::ValueId value, NodeId id);
  /// The value a stub gives: a variable of the expected type (or BOOL) that is never written.
  ir::Operand stub_value(NodeId id, Expected expected);
  void warn_stub(const core::SourceRef& where, const std::string& what);

  // lower_expression.cpp
  std::optional<ir::Operand> literal(NodeId id, Expected expected);
  std::optional<ir::Operand> enum_value(NodeId id);
  void report_unknown_value(NodeId id, ir::TypeRef enumeration, std::string_view value);
  std::optional<ir::Operand> name_value(NodeId id, Expected expected);
  ir::Operand enum_constant(const EnumValueRef& value, NodeId id);
  std::optional<ir::Operand> part_value(NodeId id);
  std::optional<ir::Constant> known_constant(ir::PlaceId where);
  std::optional<ir::Operand> unary(NodeId id, Expected expected);
  std::optional<ir::Operand> binary(NodeId id, Expected expected);
  std::optional<ir::Operand> compare_references(NodeId id, const ir::Operand& left, const ir::Operand& right);
  bool is_duration(const ir::Operand& operand);
  /// Whether a duration is multiplied by it.
  bool is_factor(const ir::Operand& operand);
  std::optional<ir::Operand> combine(NodeId id, const ir::Operand& left, const ir::Operand& right, Expected expected);
  std::optional<ir::Operand> short_circuit(NodeId id, const std::optional<ir::Operand>& left);
  /// What is expected of a call of `function`: where its result is compared, no power of integers is.
  Expected expected_of(std::string_view function, Expected expected);
  std::optional<ir::Operand> negated(NodeId id, ir::Operand operand, Expected expected);
  bool is_unresolved_name(NodeId id);
  bool names_enumeration(NodeId id);

  // lower_place.cpp
  std::optional<ir::PlaceId> root_place(NodeId id, bool for_writing);
  std::optional<ir::PlaceId> program_place(NodeId id, std::uint32_t program);
  /// Variables that the whole program shows to others; nothing for other parents.
  struct Found {
    std::optional<ir::PlaceId> place;  ///< nothing when it was reported
  };
  std::optional<Found> program_variable(ir::PlaceId parent, NodeId id, bool for_writing);
  std::optional<ir::PlaceId> direct_place(NodeId id, bool for_writing);
  std::optional<ir::PlaceId> member_place(ir::PlaceId parent, NodeId id, bool for_writing);
  std::optional<ir::PlaceId> index_place(ir::PlaceId array, NodeId id);
  /// An index: its number, where it is known, and its value, where it is no untyped literal.
  struct Index {
    std::optional<std::int64_t> known;
    ir::ValueId value{};
  };
  std::optional<Index> index_of(NodeId index, std::uint16_t categories);
  std::optional<ir::PlaceId> character_place(ir::PlaceId string, NodeId index);
  std::optional<ir::PlaceId> element_place(ir::PlaceId array, NodeId index);
  bool is_step(ir::PlaceId place);
  bool check_writable(const ir::Variable& variable, const core::SourceRef& where);
  void report_unknown_name(NodeId id);
  bool report_unknown_in_list(NodeId root, NodeId member);

  // lower_parts.cpp
  struct Part {
    ir::TypeRef type;
    unsigned bit;
  };
  /// Whether values of this type have bits that are named, as in w.3.
  bool has_parts(ir::TypeRef word);
  /// What "3", "%X3" or "%B1" after a value of type `word` names.
  std::optional<Part> part_of(NodeId id, ir::TypeRef word);
  std::optional<ir::PlaceId> part_place(ir::PlaceId word, NodeId id);
  /// The number that the name after the dot of a member stands for, where it is a constant.
  std::optional<std::int64_t> bit_constant(NodeId id);
  std::optional<ir::PlaceId> constant_bit_place(ir::PlaceId word, NodeId id, std::int64_t bit);
  /// Whether a function is called whose result is a REFERENCE TO: the call stands for a variable.
  bool gives_reference(NodeId id);
  /// A place that holds the result of a call.
  std::optional<ir::PlaceId> result_place(NodeId id, bool keep_reference);
  /// A place that can be referred to later: no part of a result, but what a reference in one leads to.
  std::optional<ir::PlaceId> lasting_place(NodeId id);

  // lower_call.cpp
  /// Whether the place is a configuration port of a taskblock, or part of one.
  bool is_configuration(ir::PlaceId place);
  /// Whether the place belongs to a variable declared CONSTANT, or to a configuration port.
  bool is_constant(ir::PlaceId place);
  std::optional<ir::Operand> call(NodeId id, Expected expected, bool as_statement);
  std::optional<ir::Operand> call_function(NodeId id, std::uint32_t pou, bool as_statement);
  /// Arguments that were lowered to find out which function is called, by their node.
  struct Given {
    std::map<NodeId, ir::PlaceId> places;
    std::map<NodeId, ir::Operand> values;
  };
  std::optional<std::uint32_t> function_for(NodeId id, std::uint32_t pou, const Arguments& arguments,
                                            const std::vector<Parameter>& parameters, Given& given);
  /// `action`: runs this action of the instance, into Module::pous.
  bool call_block(NodeId id, std::optional<std::uint32_t> action = std::nullopt);
  void report_unknown_function(NodeId id, std::string_view name);
  std::optional<ir::Operand> call_method(NodeId id, Expected expected);

  // lower_library_call.cpp
  std::optional<ir::Operand> call_array_bound(NodeId id, ir::ArrayBound bound);
  std::optional<ir::Operand> call_queue(NodeId id, ir::QueueFunction function, bool as_statement);
  Expected argument_type(std::string_view name, std::size_t i);
  std::optional<ir::Operand> call_standard(NodeId id, std::string_view name, Expected expected);
  std::optional<ir::Operand> call_bundle(NodeId id, const stdlib::BundleSpec& bundle, bool as_statement);

  // lower_pointer.cpp
  ir::PlaceId follow_implicit(ir::PlaceId where);
  /// place() of a name of type REFERENCE TO: the reference itself.
  std::optional<ir::PlaceId> reference_place(NodeId id);
  std::optional<ir::Operand> take_reference(NodeId id, Expected expected);
  std::optional<ir::PlaceId> pointer_element(ir::PlaceId pointer, NodeId index);
  std::optional<ir::Operand> pointer_operation(NodeId id, const ir::Operand& left, const ir::Operand& right);
  std::optional<ir::ValueId> bound_reference(NodeId written, ir::TypeRef reference, const std::string& what);
  bool bind_reference(NodeId id);
  std::optional<ir::PlaceId> described(NodeId written, ir::TypeRef any, const std::string& what);
  std::optional<ir::Operand> call_is_valid_ref(NodeId id);

  // lower_machine.cpp
  std::optional<ir::Operand> call_sizeof(NodeId id);
  std::optional<ir::Operand> call_uptime(NodeId id);
  /// UTC_DT() and its like; nothing when `name` is none of them.
  std::optional<ir::Operand> call_sys_time(NodeId id, std::string_view name);

  // lower_arguments.cpp
  std::vector<Parameter> parameters_of_pou(std::uint32_t pou);
  std::vector<Parameter> parameters_of_block(const stdlib::BlockSpec& block);
  Arguments bind_arguments(NodeId call, const std::vector<Parameter>& parameters, std::string_view callee,
                           bool is_block);
  std::optional<ir::ValueId> in_out(NodeId written, const Parameter& parameter, std::string_view callee,
                                    std::optional<ir::PlaceId> known = std::nullopt);
  bool names_place(NodeId id);
  std::optional<ir::ValueId> kept_reference(const ir::Operand& given, ir::TypeRef type, const std::string& what);
  bool all_in_outs_given(NodeId call, const std::vector<Parameter>& parameters, const Arguments& arguments,
                         std::string_view callee);
  std::optional<ir::ValueId> condition(NodeId id, std::string_view what);
  bool deliver(NodeId argument, ir::ValueId value);

  // lower_statements.cpp
  /// The key of what somebody may look at in a statement: the value of a name or an expression.
  [[nodiscard]] ir::ProbeKey value_key(NodeId id) const { return ir::ProbeKey::text(at(id), ir::ProbeSide::kOutput); }
  void probe_written(NodeId id, ir::PlaceId where, const ir::Operand& given);
  bool statement(NodeId id);
  bool assign(NodeId id);
  bool assign_chain(NodeId id);
  bool set_or_reset(NodeId id, ir::PlaceId where, const ir::Operand& given);
  bool if_chain(NodeId id);
  bool call_statement(NodeId call_id);
  /// A standard function that a variable of the same name does not hide, because the variable cannot be called.
  bool names_instance(NodeId callee);
  bool is_standard_call(NodeId callee);
  /// Whether branches are noted (ir/coverage.h), and the note of one: `id` is its IF, ELSE, CASE or branch.
  bool covered();
  void cover_branch(NodeId id, std::string_view word);

  // lower_test_calls.cpp
  struct Compared {
    ir::ValueId expected;
    ir::ValueId got;
  };
  bool refuse_test_call(NodeId id, const ir::TestCallInfo& info, const std::string& why);
  bool test_call(NodeId id, const ir::TestCallInfo& info);
  /// Tells the runner of the test: the call, and these inputs of its component.
  void call_host(ir::TestCall call, std::initializer_list<std::pair<const char*, ir::ValueId>> inputs);
  /// Stores the value in a hidden variable, whose name it gives.
  std::string keep_for_message(std::string_view hint, ir::ValueId kept);
  void assert_that(NodeId id, ir::Assertion assertion, ir::ValueId holds, std::span<const ir::ValueId> kept);
  bool assert_condition(NodeId id, const ir::TestCallInfo& info, NodeId argument, std::string message);
  std::optional<Compared> compared_values(const ir::TestCallInfo& info, NodeId first, NodeId second);
  bool assert_comparison(NodeId id, const ir::TestCallInfo& info, const std::vector<NodeId>& arguments,
                         std::string message);
  std::optional<ir::ValueId> as_lreal(NodeId id, const ir::Operand& given, std::string_view what);
  bool assert_near(NodeId id, const ir::TestCallInfo& info, const std::vector<NodeId>& arguments, std::string message);
  bool advance_time(NodeId id, NodeId argument);
  bool set_clock(NodeId argument);
  bool run_cycles(NodeId id, const ir::TestCallInfo& info, const std::vector<NodeId>& arguments);
  /// MOCK, and UNMOCK where `given` is kNoNode.
  bool mock(NodeId id, const ir::TestCallInfo& info, NodeId output, NodeId given);

  // lower_case.cpp
  bool case_of(NodeId id);
  std::optional<ir::ValueId> case_label(NodeId label, ir::ValueId selector, LabelRanges& taken);
  std::optional<std::int64_t> label_number(ir::ValueId label);
  /// The constant value of a label as an operand of the selector's type.
  std::optional<ir::ValueId> label_value(NodeId id, ir::TypeRef selector);
  std::optional<ir::Operand> number_of_constant(const ir::Operand& given, ir::TypeRef selector);
  std::optional<ir::ValueId> compare(std::string_view function, ir::ValueId a, ir::ValueId b, NodeId where);

  // lower_loops.cpp
  /// Where EXIT and CONTINUE of the innermost loop go.
  struct Loop {
    ir::LabelId exit;
    ir::LabelId again;
  };
  bool for_loop(NodeId id);
  bool for_known_step(NodeId id, ir::PlaceId control, ir::ValueId initial, ir::ValueId final_value, std::int64_t step);
  bool for_any_step(NodeId id, ir::PlaceId control, ir::ValueId final_value, ir::ValueId step);
  bool while_loop(NodeId id);
  bool repeat_loop(NodeId id);
  bool loop_body(NodeId id, Loop loop);
  bool leave_loop(NodeId id);
  ir::ValueId integer(ir::TypeRef type, std::int64_t value);
  /// The sum or difference of two values of a control variable's type.
  std::optional<ir::ValueId> counted(std::string_view function, ir::ValueId a, ir::ValueId b, NodeId where);

  ir::Builder& builder_;
  const SourceText& source_;
  const Ast& ast_;
  std::vector<ir::Operand> given_;  ///< by number
  bool stub_used_ = false;
  bool in_statement_ = false;    ///< what is lowered is part of a statement, whose values may be looked at
  bool compared_ = false;        ///< what is lowered is compared with a value, whose type is expected as a hint
  bool keep_reference_ = false;  ///< the next place() does not follow a reference that it ends at
  std::vector<Loop> loops_;      ///< around the statement being lowered, innermost last
};

}  // namespace plc::st
