// Generator: random choices that make a well-typed program, bounded in size and running time.
//
// In: a seed. Out: a Program. Every value has the type asked for, so types never depend on what the compiler infers but
// where an operator's rule is what is tested. Does not belong here: running and comparing (comparison.h).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tests/programs/model.h"

namespace plc::programs {

/// A variable in reach.
struct Visible {
  std::string st, c;
  const Type* type = nullptr;
  bool writable = true;
  bool checked = false;  ///< in-out: `c` is a pointer
  bool stable = true;    ///< lives as long as the program
};

class Generator {
 public:
  explicit Generator(std::uint64_t seed) : random_(seed) { program_.seed = seed; }
  Program make();

 private:
  enum class Use { kRead, kWrite, kExact, kRefer };

  // ---- types.cpp: types, literals, initial values
  void make_types();
  const Type* add(Type type);
  const Type* elementary(std::string st, std::string c, Kind kind, unsigned bits, bool is_long = false);
  const Type* string_type(bool wide);
  const Type* array_of(const Type& element, unsigned dimensions);
  const Type* structure(const std::vector<const Type*>& members, const char* prefix);
  const Type& random_scalar();
  const Type& random_type();
  Expr literal(const Type& type, bool may_be_untyped);
  Expr integer_literal(const Type& type, std::int64_t value, bool may_be_untyped);
  Expr real_literal(const Type& type, bool may_be_untyped);
  Expr duration_literal(const Type& type);
  Expr date_literal(const Type& type);
  Expr string_literal(const Type& type);
  Expr enum_literal(const Type& type);
  std::int64_t edge_value(const Type& type);
  /// Text after ":=" and C statements on "@", or nothing.
  void initial_value(Variable& variable);
  std::optional<std::pair<std::string, std::string>> initial_of(const Type& type, const std::string& place);

  // ---- places.cpp
  bool reaches(const Type& from, const Type& wanted, Use use, int depth = 0) const;
  std::optional<Place> place(const Type& wanted, Use use, int depth);
  void step(Place& place, const Type& wanted, Use use, int depth);
  Expr load(const Place& place);
  std::string store(const Place& place, const std::string& value) const;
  std::string address(const Place& place) const;
  std::string temp(const Type& type, const std::string& value, std::string& pre);

  // ---- expressions.cpp
  /// Of exactly this type (the base of a subrange).
  Expr value(const Type& type, int depth);
  /// Of this type, or of one that widens to it; converted in C.
  Expr assignable(const Type& type, int depth);
  Expr typed(const Type& type, int depth);
  Expr operand_of(const Type& type, int depth, bool may_be_untyped);
  Expr binary(const Type& result, const char* op, Power power, const std::string& function, const Expr& a,
              const Expr& b);
  Expr prefix(const Type& result, const char* op, const std::string& function, const Expr& a);
  Expr call(const Type& result, const std::string& name, const std::string& function,
            const std::vector<Expr>& arguments, const std::vector<std::string>& pins = {});
  Expr boolean(int depth);
  Expr comparison(int depth);
  Expr integer(const Type& type, int depth);
  Expr bit_string(const Type& type, int depth);
  /// Bit strings and integers mixed (docs/guides/conversions.md), made the type by a conversion.
  Expr mixed(const Type& type, int depth);
  Expr real(const Type& type, int depth);
  Expr duration(const Type& type, int depth);
  Expr date(const Type& type, int depth);
  Expr text(const Type& type, int depth);
  Expr selection(const Type& type, int depth);
  std::optional<Expr> partial_read(const Type& type, int depth);
  Expr converted(const Type& type, int depth);
  Expr widened(Expr from, const Type& to);
  std::optional<Expr> user_call(const Type& result, int depth);
  const Type* narrower(const Type& type);
  const Type* any_int();
  std::string cased(const std::string& name);

  // ---- statements.cpp
  std::vector<Stmt> statements(int depth, int count);
  Stmt statement(int depth);
  Stmt assignment();
  Stmt partial_write();
  Stmt reference_assignment();
  Stmt if_chain(int depth);
  Stmt case_of(int depth);
  Stmt for_loop(int depth);
  Stmt bounded_loop(int depth);
  Stmt function_call();
  Stmt block_call();
  Stmt eno_call();
  // ---- pointers.cpp
  void make_pointer_types();
  /// A pointer of this POU, perhaps a new one.
  Visible some_pointer();
  Stmt pointer_statement();

  Stmt simple(const std::string& st, const std::string& c) const;

  struct Call {
    std::string st, pre, after, c;
  };
  /// Arguments for a function or block; nothing when an in-out finds no variable.
  std::optional<Call> arguments(const Pou& callee, int depth, bool with_outputs, bool positional,
                                const std::string& instance);

  // ---- pous.cpp
  void make_function();
  void make_block();
  void make_program();
  void open_pou(PouKind kind, const std::string& prefix);
  void use_globals();
  void parameters(bool is_block);
  void locals(int count);
  void add_variable(Variable variable);
  void finish_block_type();
  void collect_leaves(const std::string& path, const std::string& c, const Type& type, bool input);
  std::string fresh(const char* prefix) { return prefix + std::to_string(++names_); }
  [[nodiscard]] bool affordable(double cost) const { return factor_ * cost < kMostCost && pou_->cost < kMostCost; }

  static constexpr double kMostCost = 4000;
  Random random_;
  Program program_;
  std::vector<const Type*> elementary_, scalars_, aggregates_, pointers_;
  const Type *bool_ = nullptr, *int_ = nullptr, *dint_ = nullptr, *real_ = nullptr, *lreal_ = nullptr;
  const Type *time_ = nullptr, *ltime_ = nullptr, *string_ = nullptr, *wstring_ = nullptr;
  Pou* pou_ = nullptr;
  std::vector<Visible> scope_;
  std::vector<int> loops_;
  double factor_ = 1;  ///< how often the present statement runs in one call
  int names_ = 0, temps_ = 0;
};

}  // namespace plc::programs
