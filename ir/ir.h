// The typed IR: what is computed, however it was drawn. One Module per compilation; one linear Body per POU, in
// execution order. A value is the result of one instruction, computed once, at its place, from the variables as they
// are then; it never changes afterwards (docs/guides/execution-order.md).
//
// In: built by the front ends through ir/builder.h. Out: ir::check, then bytecode/codegen. Does not belong here: XML,
// offsets (code generation lays out memory), overload lists (stdlib).
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "core/options.h"
#include "core/source_ref.h"
#include "ir/coverage.h"
#include "ir/library.h"
#include "ir/probes.h"
#include "ir/tests.h"
#include "ir/types.h"
#include "stdlib/library.h"

namespace plc::ir {

using NameSet = std::unordered_set<std::string, core::NameHash, core::NameEqual>;

/// Index of the instruction that computes the value.
struct ValueId {
  std::uint32_t index = 0xffffffffu;
  [[nodiscard]] bool valid() const { return index != 0xffffffffu; }
  friend bool operator==(ValueId, ValueId) = default;
};
struct LabelId {
  std::uint32_t index = 0xffffffffu;
  [[nodiscard]] bool valid() const { return index != 0xffffffffu; }
  friend bool operator==(LabelId, LabelId) = default;
};
/// Index into Body::places.
struct PlaceId {
  std::uint32_t index = 0xffffffffu;
  [[nodiscard]] bool valid() const { return index != 0xffffffffu; }
  friend bool operator==(PlaceId, PlaceId) = default;
};

/// A place in memory: a root, or a field or element of another place. Interned: equal places have equal ids.
struct Place {
  enum class Kind : std::uint8_t {
    kGlobal,     ///< Module::globals[index]
    kInstance,   ///< variable `index` of the POU, in the instance
    kFrame,      ///< variable `index` of the POU, in the frame (functions; VAR_TEMP)
    kSelf,       ///< the instance that the body runs on, whole: only kRun names it, for its actions
    kDeref,      ///< what the reference or pointer value `index` (a ValueId) points at
    kField,      ///< field `index` of `parent`: struct field, block port, or variable of a function block instance
    kElement,    ///< element `index` (0-based) of array `parent`
    kElementAt,  ///< element of array `parent` at the value `index` (a ValueId) of any integer or bit string type,
                 ///< lower bound included. Outside the bounds: reads give the type's zero value, writes do nothing,
                 ///< handles are null, runs do not happen; each access is one event
    kPart,  ///< the part of integer or bit string `parent` that begins at bit `index` (w.3, w.%B1). Only the builder
            ///< sees it: loads and stores of it become kExtract and kInsert
    kCharacter,  ///< character of string `parent` at position `index` (a ValueId of an integer type, from 1). Only the
                 ///< builder sees it: loads and stores of it become calls of MID and REPLACE
  };
  Kind kind = Kind::kGlobal;
  std::uint32_t index = 0;
  PlaceId parent{};
  TypeRef type{};
};

/// A constant: the bits of a scalar (zero-extended; REAL in the low 32), or the characters of a string.
struct Constant {
  TypeRef type{};
  std::uint64_t bits = 0;
  std::string text;  ///< STRING: bytes; WSTRING: UTF-16LE code units as bytes
  friend bool operator==(const Constant&, const Constant&) = default;
};

// Instructions. a, b, c by op; a value operand is a ValueId index, a place a PlaceId index.
enum class Op : std::uint8_t {
  kConst,        ///< value := constants[a]
  kLoad,         ///< value := place a
  kStore,        ///< place a := value b (equal types, or STRING of any capacity)
  kCopy,         ///< place a := place b, aggregates of equal type
  kAnd,          ///< BOOL value := a AND b      (And, Or, Xor, Not on BOOL have ops of their own: they become look-ups)
  kOr,           ///< BOOL value := a OR b
  kXor,          ///< BOOL value := a XOR b
  kNot,          ///< BOOL value := NOT a
  kCall,         ///< value := functions[a](args[b .. b+count)), a standard function
  kCallPou,      ///< value := function POU a; args[b .. b+count): one per CallArg, see Body::call_args
  kRun,          ///< runs the instance at place a (standard block or POU), or on it action b - 1, a POU (pou_run_by)
  kLabel,        ///< label a is here
  kJump,         ///< to label a
  kJumpIf,       ///< to label a when BOOL value b
  kJumpIfNot,    ///< to label a unless BOOL value b
  kReturn,       ///< ends the body
  kClearEvent,   ///< forgets events
  kEno,          ///< BOOL value := no event since the last kClearEvent
  kMakeRef,      ///< REF value := handle of place a
  kExtract,      ///< value := the part of its type that begins at bit b of value a
  kInsert,       ///< value := value a with the part that begins at bit `count` replaced by value b
  kSameRef,      ///< BOOL value := reference values a and b refer to one variable, or both to none
  kRange,        ///< value of a subrange := value a of its base, outside the limits the nearest of them with an event
  kAddress,      ///< pointer value := address of place a
  kPointerRef,   ///< REF value := handle of what pointer value a points at, exactly of the REF's target type
  kPointerTo32,  ///< UDINT or DWORD value := 32-bit address of pointer value a
  kPointerFrom32,  ///< pointer value := pointer of 32-bit address a
};
inline constexpr std::size_t kOpCount = 27;

/// What an instruction belongs to where it was not written as such: lint leaves the comparisons and stores out that a
/// loop or CASE implies. Code generation does not look at it.
enum class Part : std::uint8_t {
  kPlain,
  kCaseLabel,   ///< compares the selector of a CASE (the first argument) with a label, or jumps past the branch
  kForControl,  ///< compares, counts or stores the control variable of a FOR, or jumps because of it
  kChart,       ///< evaluates a sequential function chart around its actions and conditions
};

struct Inst {
  Op op = Op::kReturn;
  Part part = Part::kPlain;
  std::uint16_t count = 0;
  TypeRef type{};  ///< of the value, if the op makes one
  std::uint32_t a = 0, b = 0;
  std::uint32_t source = 0;  ///< index into Body::sources
};

/// One argument of a call of a function POU (kCallPou): an input value, an output to be stored, or an in-out handle.
struct CallArg {
  enum class Kind : std::uint8_t { kInput, kOutput, kInOut } kind = Kind::kInput;
  std::uint32_t variable = 0;  ///< index into the callee's variables
  ValueId value{};             ///< kInput: the value; kInOut: the reference value
  PlaceId place{};             ///< kOutput: where the output goes
};

/// What somebody may look at (Module::probes): a value, or what is in a variable when the instructions before `before`
/// have been executed; with neither, that they have.
struct Probe {
  ProbeKey key;
  ValueId value{};
  PlaceId place{};
  std::uint32_t before = 0;  ///< instruction, or their number
  ValueId when{};            ///< BOOL; valid: only where it is TRUE. Code generation makes this of branches
};

struct Body {
  std::vector<Inst> insts;
  std::vector<ValueId> args;       ///< operands of kCall
  std::vector<CallArg> call_args;  ///< operands of kCallPou
  std::vector<Place> places;
  std::vector<Constant> constants;
  std::vector<SourceRef> sources;  ///< one per element, shared by its instructions
  std::vector<const stdlib::Overload*> functions;
  std::uint32_t label_count = 0;
  std::vector<Probe> probes;  ///< in the order in which they were noted
};

enum class Role : std::uint8_t {
  kInput,
  kOutput,
  kInOut,
  kLocal,
  kTemp,
  kExternal,
  kReturnValue,
  kHidden,
  kQueue,  ///< an end of a queue, which callers name like an in-out: no memory, bound when the project is compiled
};

/// One element of an initial value: `path` leads from the variable to a scalar (field or 0-based element indices).
struct InitItem {
  std::vector<std::uint32_t> path;
  Constant value;
};

/// A reference that is made when its variable is first used: `path` leads from the variable to it, `text` is the
/// expression.
struct ReferenceInit {
  std::vector<std::uint32_t> path;
  std::string text;
  SourceRef at;
};

struct Variable {
  std::string name;  ///< as declared; hidden ones have a name with a '#', which no source can spell
  TypeRef type{};    ///< kInOut: a reference to the declared type; kQueue: the array, of a taskblock ARRAY [*]
  Role role = Role::kLocal;
  bool in_frame = false;  ///< lives in the frame (all variables of functions, VAR_TEMP), else in the instance
  bool constant = false;  ///< kQueue: elements are taken out of it, not put into it
  bool retain = false;
  bool persistent = false;
  bool nonretain = false;                 ///< begins anew, also where its instance is retained
  bool step = false;                      ///< a step of a chart: a structure of X and T that the chart alone writes
  std::string address;                    ///< located: "%IX0.0" as written; or empty
  std::uint32_t global = 0;               ///< kExternal: index into Module::globals
  std::vector<InitItem> initial;          ///< overrides of the type's defaults
  std::vector<ReferenceInit> references;  ///< initial values REF(x): tables hold no handles before a task runs
  SourceRef at;
};

struct Global {
  Variable variable;
  std::string list;           ///< name of its list for qualified access ("GVL"), or empty
  std::string prefix;         ///< name of the list or file that may be written before its name and need not, or empty
  bool file_prefix = false;   ///< the prefix is the name of a file
  bool from_library = false;  ///< brought by --lib: lint does not look at it
  bool queue = false;    ///< an array that a queue function or port names: a queue of its elements, and no variable
  bool program = false;  ///< the one instance of a program that is called or read by name
  /// A program instance as tests see it: no variable of the project, and laid out with Module::tests_run alone.
  bool mirror = false;
};

/// The functions of queues (ir/queues.h).
enum class QueueFunction : std::uint8_t { kPut, kGet, kCount, kSpace };
/// A function made for one queue; it has no body, code generation writes its one instruction.
struct QueueCall {
  QueueFunction function = QueueFunction::kPut;
  std::uint32_t global = 0;  ///< the queue, into Module::globals
};
/// A queue that is named at a port of a taskblock instance.
struct QueuePort {
  PlaceId instance{};          ///< known before the program runs: a variable of the POU's instance, or part of one
  std::uint32_t variable = 0;  ///< the port, of role kQueue, into the taskblock's variables
  std::uint32_t global = 0;    ///< the queue
};

/// An output that tests mock (MOCK): when the body has run the block, the output gets `value` if `active`.
struct Mock {
  std::uint32_t variable = 0;  ///< the block instance, into the POU's variables
  std::uint32_t output = 0;    ///< field of its type
  std::uint32_t value = 0;     ///< hidden variables of the POU
  std::uint32_t active = 0;
};

/// The hidden UDINT at the start of each instance of a taskblock: which object belongs to it, set when the image is
/// loaded.
inline constexpr const char* kObjectName = "#object";

enum class PouKind : std::uint8_t { kProgram, kFunctionBlock, kFunction };

struct Pou {
  std::string name;
  PouKind kind = PouKind::kProgram;
  TypeRef instance_type{};  ///< programs and function blocks
  TypeRef return_type{};    ///< functions; invalid when none is declared
  std::vector<Variable> variables;
  std::unordered_map<std::string, std::uint32_t, core::NameHash, core::NameEqual> by_name;  ///< into variables
  /// Inputs with R_EDGE or F_EDGE: the hidden BOOL that the POU's own body reads by their name.
  std::unordered_map<std::uint32_t, std::uint32_t> edges = {};
  Body body;
  bool compiled = false;      ///< a front end lowered its body without error
  bool stub = false;          ///< --stub-missing: does nothing
  bool from_library = false;  ///< brought by --lib: lint does not look at it
  bool test = false;          ///< a TEST block: sees and writes all that instances have, and may call test_calls.def
  /// Names whose declaration was reported as wrong: their uses are no errors of their own.
  NameSet refused = {};
  /// A component in C++: hash of its declaration, and no body; 0 = it is none. Its constant inputs are configuration
  /// ports, and a hidden variable says which object belongs to an instance.
  std::uint64_t taskblock = 0;
  std::vector<QueuePort> queue_ports = {};  ///< of taskblocks that the body runs
  std::vector<Mock> mocks = {};             ///< outputs of its blocks that tests of this compilation mock
  std::optional<QueueCall> queue_call = {};
  bool generic =
      false;  ///< has parameters ARRAY [*]: calls call what is made from it (generic.h), and it has no body itself
  bool has_made = false;     ///< functions were made from it
  bool asks_bounds = false;  ///< bounds of arrays are constants in its body
  /// The generic function that this one is made from; else kDeclared.
  std::uint32_t made_from = kDeclared;
  /// An action: a body that runs on instances of this POU and works on its variables; it has none of its own. Else
  /// kDeclared.
  std::uint32_t owner = kDeclared;
  /// Actions of a program or function block, by name, into Module::pous.
  std::unordered_map<std::string, std::uint32_t, core::NameHash, core::NameEqual> actions = {};
  /// An action that a chart runs without a final scan: what is in it stands still from then on.
  bool freezes = false;
  /// A program that is called or read by name: the global that is its one instance; else kDeclared.
  std::uint32_t instance = kDeclared;
  bool partial =
      false;  ///< parts of its body are left out (stubs, unconnected elements), with what they would read and write
  SourceRef at;

  static constexpr std::uint32_t kDeclared = 0xffffffffu;

  [[nodiscard]] const Variable* find(std::string_view variable) const {
    const auto it = by_name.find(variable);
    return it == by_name.end() ? nullptr : &variables[it->second];
  }
};

/// A variable of a program instance that is connected to a global of the same type: an input takes its value before the
/// program runs, an output gives its value afterwards.
struct InstanceWire {
  std::uint32_t variable = 0;  ///< into the program's variables
  std::uint32_t global = 0;    ///< into Module::globals
  bool output = false;
};

/// A variable "AT %I*", "%Q*" or "%M*" of an instance. Each has a global of its own, with the address that VAR_CONFIG
/// gives or the name that the machine's configuration binds. It is copied into the instance before the task's programs
/// run, and, unless it is an input, back when they have run.
struct LocatedPart {
  std::string name;                 ///< "main.valves[2].coil"
  std::vector<std::uint32_t> path;  ///< from the instance to the variable: fields, variables, 0-based elements
  std::uint32_t global = 0;         ///< into Module::globals
  bool output = false;              ///< %Q, %M
  bool begins = true;               ///< the global begins with the initial value of the part
};

struct ProgramInstance {
  std::string name;
  std::uint32_t pou = 0;
  SourceRef at;
  bool retain = false;
  std::vector<InstanceWire> wires = {};
  std::vector<InitItem> initial = {};  ///< overrides of the program's initial values; paths begin at its variables
  std::vector<LocatedPart> located = {};
  std::uint32_t global = Pou::kDeclared;  ///< the instance is this global, which others name; else it is the task's own
};

struct Task {
  std::string name;
  std::int64_t period_ns = 0;             ///< 0 = freewheeling
  std::int32_t priority = 0;              ///< 0 is the highest
  std::string single;                     ///< event variable (path of a BOOL global), or empty
  std::vector<ProgramInstance> programs;  ///< in declared order
  SourceRef at;
};

/// A located variable of an instance that is itself a global, or a part of one.
struct LocatedInGlobal {
  std::uint32_t root = 0;  ///< the global that holds the instance
  LocatedPart part;
};

/// A name under which a body writes a global that has an address.
struct WrittenName {
  std::string name;       ///< of the variable, or the address itself
  std::uint32_t pou = 0;  ///< whose body writes
  SourceRef at;           ///< of the first such write in that body
};

/// A second global variable at the address of another: two names of one place.
struct GlobalAlias {
  std::string name;
  std::string list;          ///< as in Global
  std::uint32_t global = 0;  ///< into Module::globals
  SourceRef at;
};

/// A transition that charts of a POU refer to by name: a body like an action, which gives a condition.
struct TransitionBody {
  std::uint32_t owner = 0;   ///< the POU, into Module::pous
  std::string name;          ///< as charts write it
  std::uint32_t result = 0;  ///< hidden BOOL that takes the condition, into the owner's variables
};

/// Key of Module::attributes: attribute `name` of a variable of `pou`, or of the POU itself; an empty POU means outside
/// of POUs.
inline std::string attribute_key(std::string_view pou, std::string_view variable, std::string_view name) {
  return std::string(pou) + "\n" + std::string(variable) + "\n" + std::string(name);
}

struct Module {
  core::CompileOptions options;
  std::string name;  ///< of the project
  TypeTable types;
  std::vector<Global> globals;
  std::unordered_map<std::string, std::uint32_t, core::NameHash, core::NameEqual> global_by_name;  ///< "X" and "GVL.X"
  std::vector<Pou> pous;
  std::unordered_map<std::string, std::uint32_t, core::NameHash, core::NameEqual> pou_by_name;
  std::map<std::vector<std::uint32_t>, std::uint32_t>
      specialized;  ///< generic function and argument types -> what was made
  std::map<std::pair<QueueFunction, std::uint32_t>, std::uint32_t>
      queue_functions;  ///< with the queue -> what was made
  std::vector<Task> tasks;
  std::unordered_map<std::uint32_t, std::vector<InitItem>>
      type_defaults;  ///< by index of a structure: initial values of its members, beyond zero
  std::vector<LocatedInGlobal> located;
  std::vector<GlobalAlias> global_aliases;
  std::map<std::uint32_t, std::vector<WrittenName>> written_names;  ///< by global; one for each name and POU
  Library library;                                      ///< declarations of libraries that the project may use
  NameSet attributes;                                   ///< {attribute 'name'} by attribute_key(): what pragmas ask for
  NameSet refused;                                      ///< globals whose declaration was reported as wrong
  std::map<std::uint32_t, TransitionBody> transitions;  ///< by the index of their bodies into `pous`
  std::optional<TestBench> bench = {};                  ///< the module is compiled with its tests
  std::optional<Coverage> coverage = {};                ///< the module is compiled with notes of what happened
  bool probes = false;                                  ///< front ends note what can be looked at: Body::probes
  bool tests_run = false;  ///< the tasks are that of the tests, which have mirrors of programs

  /// The transition of `pou` that is called so, into `pous`; nothing when it has none.
  [[nodiscard]] std::optional<std::uint32_t> find_transition(std::uint32_t pou, std::string_view wanted) const {
    for (const auto& [body, transition] : transitions) {
      if (transition.owner == pou && core::iequals(transition.name, wanted)) return body;
    }
    return std::nullopt;
  }
  /// The POU whose variables the body of `pou` names: of an action its owner.
  [[nodiscard]] const Pou& owner_of(const Pou& pou) const {
    return pou.owner == Pou::kDeclared ? pou : pous[pou.owner];
  }
  /// The POU that a kRun of `body` executes: an action or the body of a POU; nothing for a standard block.
  [[nodiscard]] std::optional<std::uint32_t> pou_run_by(const Body& body, const Inst& run) const {
    if (run.b != 0) return run.b - 1;
    const Type& type = types[body.places[run.a].type];
    return type.kind == TypeKind::kPou ? std::optional(type.pou) : std::nullopt;
  }
};

}  // namespace plc::ir
