// Declarer: one pass of declare() over a project. Split by what is declared: declare_types (data types), declare_pous
// (interfaces, globals, externals), declare_located, initial_values, declare_configuration (tasks and instances).
//
// In: Project. Out: the symbols of an ir::Module. Does not belong here: bodies.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "core/diagnostics.h"
#include "core/options.h"
#include "declare/constants.h"
#include "frontend-st/addresses.h"
#include "ir/ir.h"
#include "plcopen/project.h"

namespace plc::st {

template <class T>
using NameMap = std::unordered_map<std::string, T, core::NameHash, core::NameEqual>;

class Declarer final : public ConstantScope {
 public:
  Declarer(const plcopen::Project& project, const core::CompileOptions& options, core::Diagnostics& diagnostics,
           ir::Module& module);
  void run();
  std::optional<ConstantValue> constant_named(std::string_view name) override;
  std::optional<ConstantValue> variable_value(std::string_view root, std::span<const PathStep> path) override;
  bool is_own_function(std::string_view name) override;
  std::optional<std::uint64_t> size_of(const Ast& ast, const SourceText& source, NodeId id,
                                       std::string& problem) override;
  [[nodiscard]] bool in_library() const override { return is_library(asking_); }

 private:
  using Items = std::vector<ir::InitItem>;

  /// The third edition has a function or block of this name, so that hiding it deserves a warning in every compilation.
  /// For what else the library has, plc check warns (warn_of_hidden_names).
  static bool is_standard(std::string_view name);
  /// Where something was declared first: "at line 12", as seen from `second`.
  std::string first_place(const core::SourceRef& first, const core::SourceRef& second) const;

  /// Whose declaration is being read, for messages: a POU (or empty) and a variable, member or type.
  struct Owner {
    std::string_view pou;
    std::string_view name;
    core::SourceRef at;
  };
  enum class State : std::uint8_t { kNew, kInProgress, kDone };
  struct UserType {
    const plcopen::DataType* declaration = nullptr;
    State state = State::kNew;
    std::optional<ir::TypeRef> type;
    std::uint32_t pointer_depth = 0;  ///< pointers_ when its resolution began: more means a legal cycle
    bool has_defaults = false;
    Items defaults;  ///< initial values of members, beyond zero
  };

  void report(core::Code code, const core::SourceRef& at, std::string_view pou, std::string message,
              std::string help = {}) {
    diagnostics_.report(code, at, pou, std::move(message), std::move(help));
  }
  ir::TypeTable& types() { return module_.types; }
  [[nodiscard]] core::SourceRef whole_file() const {
    core::SourceRef at;
    at.file = project_.file;
    return at;
  }
  [[nodiscard]] const core::SourceRef& place(const core::SourceRef& preferred, const Owner& owner) const {
    return preferred.line != 0 ? preferred : owner.at;
  }
  [[nodiscard]] const core::SourceRef& place(const core::SourceRef& exact, const core::SourceRef& preferred,
                                             const Owner& owner) const {
    return exact.line != 0 ? exact : place(preferred, owner);
  }

  // declare_libraries.cpp
  void declare_libraries();
  void refuse_circular_blocks();
  /// The declaration at `user` names the one at `used`, at `at`.
  void note_use(const core::SourceRef& user, const core::SourceRef& used, const core::SourceRef& at,
                std::string_view pou);
  /// Whether `name`, which stands for nothing, is that of something broken in a library; notes that it is used.
  bool is_broken(std::string_view name, const core::SourceRef& user, const core::SourceRef& at, std::string_view pou);
  void report_uses();
  [[nodiscard]] bool is_library(const core::SourceRef& at) const { return diagnostics_.is_library(at.file); }

  // declare_types.cpp
  void declare_data_types();
  std::optional<ir::TypeRef> resolve_user_type(std::uint32_t index, const core::SourceRef& at, const Owner& owner);
  std::optional<ir::TypeRef> resolve(const plcopen::TypeSpec& spec, const Owner& owner);
  std::optional<ir::TypeRef> resolve_name(std::string_view name, const core::SourceRef& at, const Owner& owner);
  std::optional<ir::TypeRef> unknown_type(std::string_view name, const core::SourceRef& at, const Owner& owner);
  std::optional<ir::TypeRef> resolve_array(const plcopen::TypeSpec& spec, const Owner& owner, bool open_allowed);
  void report_depth(const core::SourceRef& at, const Owner& owner);
  [[nodiscard]] std::uint32_t depth_of(ir::TypeRef type) const;
  void set_depth(ir::TypeRef type, std::uint32_t depth);
  std::optional<ir::TypeRef> resolve_string(const plcopen::TypeSpec& spec, const Owner& owner);
  std::optional<ir::TypeRef> anonymous(ir::Type type, const Owner& owner, std::string_view kind);
  bool refuse_extended(const plcopen::TypeSpec& spec, const Owner& owner);
  void check_union(ir::TypeRef type, const plcopen::TypeSpec& spec, const Owner& owner);
  bool fill_struct(ir::TypeRef type, const plcopen::TypeSpec& spec, const Owner& owner);
  std::optional<ir::Type> make_enum(const plcopen::TypeSpec& spec, const Owner& owner);
  std::optional<ir::Type> make_subrange(const plcopen::TypeSpec& spec, const Owner& owner);
  std::optional<std::int64_t> integer_constant(std::string_view text, const core::SourceRef& at, const Owner& owner,
                                               std::string_view what);

  // initial_values.cpp
  const Items& defaults_of(std::uint32_t user_type);
  Items spec_defaults(const plcopen::TypeSpec& spec, ir::TypeRef type, const Owner& owner);
  std::optional<ConstantValue> evaluate_text(std::string_view text, const core::SourceRef& at, ir::TypeRef type,
                                             const Owner& owner, core::Diagnostics& diagnostics);
  bool add_items(const plcopen::InitialValue& value, ir::TypeRef type, std::vector<std::uint32_t>& path, Items& out,
                 const Owner& owner);
  bool add_array_items(const plcopen::InitialValue& value, ir::TypeRef type, std::vector<std::uint32_t>& path,
                       Items& out, const Owner& owner);
  bool add_struct_items(const plcopen::InitialValue& value, ir::TypeRef type, std::vector<std::uint32_t>& path,
                        Items& out, const Owner& owner);
  /// evaluate_constant() of a text of this project.
  std::optional<ConstantValue> evaluate(std::string_view text, const core::SourceRef& at,
                                        core::Diagnostics& diagnostics, std::string_view pou,
                                        std::optional<ir::TypeRef> expected = std::nullopt);
  std::optional<ConstantValue> constant_value(const plcopen::Variable* variable, bool is_local);
  std::optional<core::TypeId> underlying_number(const plcopen::TypeSpec& spec, std::uint32_t depth);
  Items initial_of(const plcopen::Variable& variable, ir::TypeRef type, const Owner& owner);
  /// Whether the value is to be computed by the POU itself, and what is said of it; false when it has an error.
  bool add_scalar(const plcopen::InitialValue& value, ir::TypeRef type, const std::vector<std::uint32_t>& path,
                  Items& out, const Owner& owner);
  void initialize_all();
  void initialize(std::uint32_t pending);

  // variable_values.cpp
  void index_pending();
  [[nodiscard]] const ir::Pou* scope_pou() const;
  /// True when the text names a variable, or part of one, of this type, which holds no instances.
  bool names_place_of(std::string_view text, ir::TypeRef type);
  /// What the part of `variable` at `path` begins with; `fresh` leaves out what the variable itself is given.
  std::optional<ConstantValue> part_value(const ir::Variable& variable, std::span<const PathStep> path, bool fresh);
  ConstantValue value_of(const ir::Constant& constant, ir::TypeRef type);
  /// Initialises these pending variables now, since another one asks for them. False when that nests too deep.
  bool initialize_first(std::uint32_t first, std::uint32_t last);
  void enter_scope(std::uint32_t pou);

  // declare_pous.cpp
  void declare_pou_names();
  void declare_actions(std::uint32_t owner);
  void declare_transitions(std::uint32_t owner);
  void declare_globals();
  void declare_global(const plcopen::Variable& variable);
  const core::SourceRef& place_of_global(std::string_view name, std::uint32_t global) const;
  void name_global(const plcopen::Variable& variable, std::uint32_t index);
  void supply_missing_globals();
  void declare_interface(std::uint32_t pou);
  void declare_variable(std::uint32_t pou, const plcopen::Variable& variable);
  void detect_edges(std::uint32_t pou);
  bool bind_external(ir::Variable& out, const plcopen::Variable& variable, const Owner& owner);
  bool bind_static(ir::Variable& out, const plcopen::Variable& variable, const Owner& owner);
  std::optional<Address> address_of(const plcopen::Variable& variable, ir::TypeRef type, const Owner& owner);

  // declare_located.cpp
  /// What an instance lies in: a program of a task, or a global.
  struct InstanceRoot {
    static constexpr std::uint32_t kGlobal = 0xffffffffu;
    std::uint32_t task = kGlobal;
    std::uint32_t index = 0;  ///< of the program in the task, or of the global
    friend auto operator<=>(const InstanceRoot&, const InstanceRoot&) = default;
  };
  bool bind_located(ir::Variable& out, const plcopen::Variable& variable, const Owner& owner);
  bool holds_located(ir::TypeRef type);
  void locate_instances();

  // declare_programs.cpp
  /// Programs that are named somewhere become globals, once all instances are known.
  void place_programs();
  bool check_nesting();
  void locate_parts(const InstanceRoot& root, ir::TypeRef type, const std::string& name,
                    std::vector<std::uint32_t>& path, std::vector<ir::LocatedPart>& out);
  ir::LocatedPart locate(const InstanceRoot& root, const ir::Variable& variable, const std::string& name,
                         const std::vector<std::uint32_t>& path);

  // declare_configuration.cpp and declare_instances.cpp
  void declare_configuration();
  void declare_task(const plcopen::Task& task, const std::string& resource);
  void declare_instances(const plcopen::Resource& resource, std::size_t first_task);
  std::optional<ir::ProgramInstance> instance(const plcopen::PouInstance& instance);
  void connect(ir::ProgramInstance& instance, const plcopen::InstanceConnection& connection);
  std::optional<std::uint32_t> global_at(std::string_view name, ir::TypeRef type, const core::SourceRef& at);
  void configure_variable(const plcopen::Variable& entry);
  void declare_single_pou();
  std::string pou_list(bool function_blocks) const;
  /// The path of the BOOL variable that `name` means as the trigger of a task, as Task::single spells it.
  std::optional<std::string> resolve_trigger(std::string_view name);

  /// A variable whose initial value is still to be computed, once all types and constants are known.
  struct Pending {
    const plcopen::Variable* declaration;
    std::uint32_t pou;       ///< kNoPou for globals
    std::uint32_t variable;  ///< into the POU's variables or Module::globals
  };
  static constexpr std::uint32_t kNoPou = 0xffffffffu;

  const plcopen::Project& project_;
  const core::CompileOptions& options_;
  core::Diagnostics& diagnostics_;
  ir::Module& module_;

  std::vector<UserType> user_types_;
  NameMap<std::uint32_t> user_type_by_name_;
  std::vector<std::uint32_t> resolving_;  ///< user types in progress, outermost first
  std::uint32_t pointers_ = 0;
  std::uint32_t nesting_ = 0;
  bool open_allowed_ = false;  ///< the type that is resolved next may be ARRAY [*]
  std::uint32_t chain_ = 0;    ///< constants that are being computed because another one needs them
  std::pair<const plcopen::Variable*, bool> too_deep_{};  ///< where a chain was given up, and whether that is local
  std::vector<std::uint32_t> depth_;                      ///< levels of arrays and structures, by type
  std::uint32_t anonymous_count_ = 0;
  NameMap<std::int64_t> earlier_values_;  ///< values of the enumeration being declared

  NameMap<const plcopen::Variable*> global_constants_;
  NameMap<const plcopen::Variable*> local_constants_;  ///< of the POU being declared
  std::map<const plcopen::Variable*, std::optional<ConstantValue>> constant_values_;

  static constexpr std::uint32_t kNoPending = 0xffffffffu;
  /// What an initial value takes from variables.
  struct InitialUse {
    bool variable = false;       ///< it names one that is no constant
    bool while_running = false;  ///< it is known only when the POU runs
    std::string later{};         ///< it names one that is declared later
  };
  /// A declaration of a library that the project's own declarations name.
  struct Use {
    ir::Library::Index part;
    core::SourceRef at;
    std::string pou;
    std::string name;  ///< by which it is used; empty = the first it has
  };
  std::vector<Use> uses_;
  std::vector<bool> circular_;  ///< by POU: of a library, and contains itself
  core::SourceRef asking_;      ///< the constant expression that is being computed

  std::vector<Pending> pending_;
  std::vector<State> pending_state_;
  std::unordered_map<std::uint64_t, std::uint32_t> pending_of_;  ///< by POU and variable
  std::uint32_t current_ = kNoPending;                           ///< the variable that is being initialised
  std::uint32_t scope_pou_ = kNoPou;                             ///< whose names expressions see
  InitialUse use_;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pending_of_pou_;  ///< first, and one past the last
  std::uint32_t nested_initial_values_ = 0;
  std::size_t initial_items_ = 0;
  bool ltime_fits_ = false;  ///< the TIME that is being initialised is a timer's, which takes LTIME
  std::vector<ir::ReferenceInit>* references_ = nullptr;  ///< takes REF(x) of the variable being initialised
  std::unordered_set<std::uint32_t> owned_by_one_pou_;    ///< located globals made for one POU: named POU.variable
  std::vector<std::uint8_t> holds_located_;               ///< by type: not known yet, no, yes
  /// Addresses that VAR_CONFIG gives to variables of instances.
  std::map<std::pair<InstanceRoot, std::vector<std::uint32_t>>, std::string> given_addresses_;
  bool instance_failed_ = false;
};

/// Nanoseconds of a task interval, in every spelling tools use: T#20ms, PT0.02S, 00:00:00.1, 10ms, or a number with
/// `unit`
/// ("us", "ms"). Nothing, and why in `problem`, when it is none of these.
std::optional<std::int64_t> parse_interval(std::string_view text, std::string_view unit, std::string& problem);

}  // namespace plc::st
