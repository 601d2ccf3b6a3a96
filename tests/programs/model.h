// What a generated program is made of. Every piece carries its ST text and its C translation side by side, so that one
// random choice makes both and dropping a statement drops it from both.
//
// In: built by Generator. Out: two texts. Does not belong here: choices, meaning of operators.
#pragma once

#include <cstdint>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace plc::programs {

/// Random numbers that are the same with every library: a seed is a program.
class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed * 0x9e3779b97f4a7c15ull + 1) {}
  std::uint64_t bits() { return engine_(); }
  /// 0 .. n-1
  std::size_t below(std::size_t n) { return static_cast<std::size_t>(engine_() % n); }
  std::int64_t between(std::int64_t low, std::int64_t high) {
    return low + static_cast<std::int64_t>(engine_() % (static_cast<std::uint64_t>(high - low) + 1));
  }
  bool chance(unsigned percent) { return engine_() % 100 < percent; }
  template <class T>
  const T& pick(const std::vector<T>& from) {
    return from[below(from.size())];
  }

 private:
  std::mt19937_64 engine_;
};

enum class Kind {
  kBool,
  kSigned,
  kUnsigned,
  kBits,
  kReal,
  kDuration,
  kDate,
  kTod,
  kDt,
  kString,
  kEnum,
  kSubrange,
  kArray,
  kStruct,
  kBlock,
  kRef,
  kPointer,
};

struct Type;

enum class Role { kLocal, kInput, kOutput, kInOut, kTemp };

/// A variable or a member.
struct Variable {
  std::string name;
  const Type* type = nullptr;
  Role role = Role::kLocal;
  std::string initial_st;  ///< after ":=", or empty
  std::string initial_c;   ///< statements on the variable, written "@"
};

struct Type {
  Kind kind = Kind::kBool;
  std::string st;                                             ///< as a declaration writes it
  std::string c;                                              ///< C type
  unsigned bits = 8;                                          ///< of integers, bit strings and reals
  bool is_long = false;                                       ///< LTIME, LDATE, .., WSTRING
  std::uint16_t capacity = 0;                                 ///< kString
  const Type* base = nullptr;                                 ///< kEnum, kSubrange; kArray: element; kRef: target
  std::int64_t lower = 0, upper = 0, initial = 0;             ///< kSubrange; kEnum: initial
  std::vector<std::pair<std::string, std::int64_t>> values;   ///< kEnum
  std::vector<std::pair<std::int64_t, std::int64_t>> bounds;  ///< kArray, one per dimension
  std::vector<Variable> members;                              ///< kStruct; kBlock: inputs, outputs, in-outs and locals
  std::string declaration_st, declaration_c;

  [[nodiscard]] bool is_int() const { return kind == Kind::kSigned || kind == Kind::kUnsigned; }
  [[nodiscard]] bool is_scalar() const { return kind < Kind::kArray || kind == Kind::kRef; }
  /// The type that expressions have where this one is read.
  [[nodiscard]] const Type& plain() const { return kind == Kind::kSubrange ? *base : *this; }
};

/// Function block instances are not assigned, passed by value or global.
bool holds_instance(const Type& type);

/// C statements that give `place` the initial value of its type.
std::string initialisation(const Type& type, const std::string& place);
/// The same for a variable: its own initial value counts more.
std::string initialisation(const Variable& variable, const std::string& place);

/// How strongly a printed expression holds together (IEC 61131-3:2013, table 71).
enum Power : int { kOr = 1, kXor, kAnd, kEqual, kRelation, kSum, kProduct, kPower, kUnary, kPrimary };

/// A value: `pre` are C statements that make it, in order, `c` then names it.
struct Expr {
  const Type* type = nullptr;
  std::string st;
  int power = kPrimary;
  std::string pre;
  std::string c;
  bool untyped = false;            ///< literal that takes its type from where it is
  bool constant = false;           ///< made of literals alone: the compiler knows its value
  const Type* subrange = nullptr;  ///< read from a variable of this subrange: within it already
};

/// A variable or part of one.
struct Place {
  const Type* type = nullptr;
  std::string st;
  std::string pre;
  std::string c;  ///< lvalue, or when `checked` a pointer that may be null
  bool checked = false;
  bool stable = true;  ///< lives as long as the program: may be referred to
};

struct Stmt;
struct Part {
  std::string st, c;
  std::vector<Stmt> block;  ///< not empty: replaces the texts
  bool is_block = false;
};
struct Stmt {
  std::vector<Part> parts;
  bool dropped = false;
};

enum class PouKind { kFunction, kBlock, kProgram };

struct Pou {
  PouKind kind = PouKind::kFunction;
  std::string name;
  const Type* result = nullptr;     ///< functions; null: none
  const Type* instance = nullptr;   ///< blocks
  std::vector<Variable> variables;  ///< parameters first, in the order of positional arguments
  std::vector<Stmt> body;
  bool uses_globals = false;
  double cost = 1;  ///< statements that a call executes, estimated
};

/// A variable that is compared, or set before a scan.
struct Leaf {
  std::string path;  ///< for runtime::Access
  std::string c;     ///< lvalue
  const Type* type = nullptr;
  bool input = false;
};

struct Program {
  std::uint64_t seed = 0;
  std::vector<std::unique_ptr<Type>> types;
  std::vector<std::unique_ptr<Pou>> pous;  ///< callees before callers; the last is the program
  std::vector<Variable> globals;
  std::vector<Leaf> leaves;

  [[nodiscard]] std::string st() const;
  /// Exports plc_init(), plc_scan(), plc_executed() and plc_leaf(i), the address of leaves[i].
  [[nodiscard]] std::string c(const std::string& prelude) const;
  /// Every statement, in printing order.
  [[nodiscard]] std::vector<Stmt*> statements();
};

/// A random program.
Program generate(std::uint64_t seed);

}  // namespace plc::programs
