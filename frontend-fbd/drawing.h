// Drawing: the state while one drawn body is lowered: the values on its wires, pin modifiers, writes seen so far.
//
// In: Graph and Sequence. Out: IR through ir::Builder. frontend-ld derives from it to add contacts, coils and rails.
// An element is evaluated once, at its place; what it computed is published per output and never changes in this scan.
// Does not belong here: order (order.h), texts (frontend-st).
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "core/options.h"
#include "frontend-fbd/graph.h"
#include "frontend-fbd/order.h"
#include "frontend-fbd/power_flow.h"
#include "ir/builder.h"

namespace plc::fbd {

/// What arrives at an input.
struct Incoming {
  enum class State : std::uint8_t {
    kUnconnected,
    kPoison,  ///< its source had an error (reported) or is a stub: readers stay quiet
    kValue,
  } state = State::kUnconnected;
  ir::Operand operand;
  /// BOOL: the block that drives this single wire executed in this scan (its EN was TRUE); invalid = always.
  ir::ValueId executed{};
  [[nodiscard]] bool is_value() const { return state == State::kValue; }
};

/// True for an inVariable whose text may be an expression over literals only, which takes its type from its reader.
bool computes(const plcopen::Element& e);

class Drawing {
 public:
  Drawing(ir::Builder& builder, const Graph& graph, const Sequence& sequence, const core::CompileOptions& options);
  virtual ~Drawing() = default;
  Drawing(const Drawing&) = delete;
  Drawing& operator=(const Drawing&) = delete;

  /// Lowers one element of the kinds block, in/out/inOutVariable, connector, continuation, jump, label, return.
  void lower_element(NodeId node);
  /// Writes the variables that are drawn at the outputs of an element, right after it.
  void write_targets(NodeId node);
  /// After the last element: jumps without label, bodies that do nothing, order of double writes.
  void finish();

  [[nodiscard]] ir::Builder& builder() { return builder_; }
  [[nodiscard]] const Graph& graph() const { return graph_; }
  [[nodiscard]] const core::CompileOptions& options() const { return options_; }
  [[nodiscard]] const plcopen::Element& element(NodeId node) const { return graph_.element(node); }
  /// Inputs of a node, in-outs last.
  [[nodiscard]] std::span<const Input> inputs(NodeId node) const;

  // ---- wires ----

  /// What arrives at `input`: the OR of its wires, the text in the connection point, pin modifiers applied.
  Incoming read(const Input& input);
  /// The keys of what somebody may look at: an element, one of its outputs, one of its inputs.
  [[nodiscard]] ir::ProbeKey key_of(NodeId node) const {
    return ir::ProbeKey::of(element(node).at, ir::ProbeSide::kWhole);
  }
  [[nodiscard]] ir::ProbeKey key_of(const OutRef& out) const;
  [[nodiscard]] ir::ProbeKey key_of(const Input& input) const;
  /// The same as BOOL: nothing when unconnected or poisoned. Messages name the reader.
  std::optional<ir::ValueId> read_bool(const Input& input, NodeId reader);
  /// True when the operand is a BOOL value already (the common case: no message needs to be made ready).
  [[nodiscard]] bool is_bool(const ir::Operand& operand);
  void publish(const OutRef& out, ir::ValueId value, ir::ValueId executed = {});
  void publish(const OutRef& out, const ir::Operand& operand);
  void publish_poison(const OutRef& out);
  [[nodiscard]] bool has_reader(const OutRef& out) const;
  /// The place of the variable that an output gives (inVariable, inOutVariable, in-out pin), for in-out connections.
  /// Nothing where it is modified on the way.
  std::optional<ir::PlaceId> place_of_source(const OutRef& out, bool for_writing = true);
  /// True when what an output gives is a variable with a negation, an edge or a storage on the way.
  [[nodiscard]] bool is_modified_variable(const OutRef& out) const;

  // ---- modifiers: the memory they need is hidden ----

  /// BOOL `value` with negation, then edge, then storage applied. `hint` names the memory.
  ir::ValueId modify(ir::ValueId value, bool negated, plcopen::Edge edge, plcopen::Storage storage,
                     std::string_view hint);
  ir::ValueId edge_of(ir::ValueId value, plcopen::Edge edge, std::string_view hint);
  /// place := value, set or reset by it; counts as a write for the warnings about double writes.
  void write_bool(ir::PlaceId place, ir::ValueId value, plcopen::Storage storage);
  void note_write(ir::PlaceId place, NodeId node, bool plain_coil);
  /// Notes that `node` read the variable of `operand`, if it is one: for the warnings about order.
  void note_read(const ir::Operand& operand, NodeId node);
  /// The type that the readers of an output need, where the drawing tells it.
  std::optional<ir::TypeRef> expected_type(const OutRef& out) { return expected_type(out, 0); }

  /// --compat=beremiz: the value of a contact or variable computed afresh for each reader; nothing = use the published
  /// one.
  virtual std::optional<ir::ValueId> evaluate_afresh(NodeId node);

 protected:
  PowerFlows& flows() { return flows_; }
  void report(core::Code code, NodeId node, std::string message, std::string help = {});

 private:
  struct Slot {
    enum class State : std::uint8_t { kPending, kPoison, kValue, kLiteral } state = State::kPending;
    bool read = false;  ///< some wire leads from here
    ir::ValueId value{};
    ir::ValueId executed{};
    std::uint32_t literal = 0;     ///< into literals_
    std::uint32_t kept = kNoKept;  ///< hidden variable with the value of the previous scan, once a feedback wire asked
  };
  static constexpr std::uint32_t kNoKept = 0xffffffffu;
  struct Write {
    ir::PlaceId place;
    NodeId node;
    bool plain_coil;
  };
  struct Read {
    ir::PlaceId place;
    NodeId node;
  };
  struct Reader {
    std::uint32_t slot;
    NodeId node;
    std::uint32_t input;  ///< into Graph::inputs
  };
  /// A variable at an output.
  struct Target {
    OutRef out;
    const plcopen::Pin* pin;
  };
  /// A variable that in-outs work on, and whether something modifies it before them.
  struct Variable {
    std::string text;
    core::SourceRef at;
    bool modified;
  };
  struct LabelState {
    ir::LabelId label;
    NodeId first_jump = kNoNode;
    bool bound = false;
  };

  // drawing.cpp
  void add_targets(NodeId node);
  /// The outputs of an element at which a variable is drawn.
  [[nodiscard]] std::span<const Target> targets(NodeId node) const;
  [[nodiscard]] std::uint32_t slot_index(const OutRef& out) const;
  [[nodiscard]] std::optional<Variable> variable_behind(OutRef out) const;
  Incoming read_slot(const OutRef& out, const core::SourceRef& at);
  Incoming read_input(const Input& input);
  Incoming read_wire(const Wire& wire);
  /// What negation, edges and storage work on. Nothing, and reported, for other types than BOOL.
  std::optional<ir::ValueId> bool_to_modify(const ir::Operand& operand, const core::SourceRef& at,
                                            const std::string& what);
  Incoming read_feedback(const OutRef& out);
  std::optional<ir::TypeRef> infer_type(const OutRef& out, unsigned depth);
  std::optional<ir::TypeRef> expected_type(const OutRef& out, unsigned depth);
  std::optional<ir::TypeRef> expected_by_readers(const OutRef& out, unsigned depth);
  std::optional<ir::TypeRef> type_of_text(const std::string& text, const core::SourceRef& at);
  std::optional<ir::TypeRef> type_of_input(NodeId node, const Input& input, unsigned depth);
  std::uint32_t keep_for_feedback(const OutRef& out, ir::TypeRef type);
  std::vector<ir::InitItem> before_first_scan(const OutRef& out, ir::TypeRef type);
  void warn_double_writes();
  bool warn_coils_of_one_address(std::span<const Write* const> coils);
  void warn_order_of_writes();

  // modifiers.cpp
  /// Edges and storage in a function, which has no memory for them (P3026).
  void refuse_memory();
  /// Negation together with an edge (P3027), falling edges in the first scan (P3028): where tools differ.
  void warn_of_edges();

  // lower_fbd.cpp
  struct Modifiers {
    bool negated = false;
    plcopen::Edge edge = plcopen::Edge::kNone;
    plcopen::Storage storage = plcopen::Storage::kNone;
  };
  /// place := what arrives, modified, unless its block was not executed. `text` is how the drawing names the place,
  /// `what` how messages name it. The place; nothing when the text is not one.
  std::optional<ir::PlaceId> write(const std::string& text, const core::SourceRef& at, const Incoming& in,
                                   const Modifiers& modifiers, const std::string& what, NodeId node);
  /// True when a variable at an output is at the input of the same name, too: that is an in-out, nothing to write.
  bool is_left_side(const OutRef& out, const plcopen::Pin& pin);
  void lower_in_variable(NodeId node);
  void lower_out_variable(NodeId node);
  void lower_in_out_variable(NodeId node);
  void lower_passage(NodeId node);  // connector, continuation
  /// Whether a jump or return without a wire has a modifier, which is reported: nothing comes that it could modify.
  bool refuse_modifiers(NodeId node);
  void lower_jump(NodeId node);
  void lower_label(NodeId node);
  void lower_return(NodeId node);

  // lower_block.cpp, lower_call.cpp
  struct Enable;
  friend struct BlockLowering;
  void lower_block(NodeId node);
  /// True for a block that neither the project nor the standard library supplies.
  [[nodiscard]] bool is_missing(const plcopen::Element& e);

  ir::Builder& builder_;
  PowerFlows flows_;
  const Graph& graph_;
  const Sequence& sequence_;
  const core::CompileOptions& options_;
  std::vector<std::uint32_t> first_slot_;  ///< per node, and one past the end
  std::vector<Slot> slots_;
  std::vector<bool> feeds_known_;  ///< per node: some reader is not a missing block
  std::vector<ir::Operand> literals_;
  std::vector<Write> writes_;
  std::vector<Read> reads_;
  std::vector<Reader> readers_;  ///< sorted by slot
  std::vector<Target> targets_;  ///< in the order of the nodes
  unsigned type_steps_ = 0;      ///< of the question infer_type() or expected_type() answers now
  std::unordered_map<std::uint32_t, std::optional<ir::TypeRef>> expected_seen_;  ///< by slot, of the same question
  std::unordered_map<std::string, LabelState, core::NameHash, core::NameEqual> labels_;
};

}  // namespace plc::fbd
