// ir::Builder: appends instructions to the body of one POU. The only way front ends make IR.
//
// The builder keeps types right (stores and logic assert equal types; convert() widens or reports) and the current
// SourceRef; it does not decide order. All reporting goes to the Diagnostics given.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "core/diagnostics.h"
#include "ir/coverage.h"
#include "ir/ir.h"
#include "stdlib/idioms.h"

namespace plc::ir {

/// What a caller hands to a call or an assignment: a typed value, or a literal that still takes its type from its place
/// (IEC 61131-3, 6.3.2: "a literal without prefix takes the pin's type").
struct Operand {
  enum class Kind : std::uint8_t { kUnconnected, kValue, kIntLiteral, kRealLiteral } kind = Kind::kUnconnected;
  ValueId value{};             ///< kValue
  std::int64_t int_value = 0;  ///< kIntLiteral; bits of a value above 2^63-1 when int_is_unsigned
  bool int_is_unsigned = false;
  double real_value = 0;  ///< kRealLiteral
  SourceRef at;
  std::string text;  ///< as written, for messages

  static Operand of(ValueId value, const SourceRef& at = {}) {
    Operand o;
    o.kind = Kind::kValue;
    o.value = value;
    o.at = at;
    return o;
  }
};

class Builder {
 public:
  Builder(Module& module, std::uint32_t pou_index, core::Diagnostics& diagnostics);

  [[nodiscard]] Module& module() { return module_; }
  /// The POU whose names the body sees and whose instances it runs on: of an action its owner.
  [[nodiscard]] Pou& pou() { return module_.pous[owner_index_]; }
  /// The POU whose body is built: itself an action, if it is one.
  [[nodiscard]] std::uint32_t pou_index() const { return pou_index_; }
  /// Its name in messages: "Pump.Start" in an action.
  [[nodiscard]] const std::string& name() { return module_.pous[pou_index_].name; }
  [[nodiscard]] Body& body() { return module_.pous[pou_index_].body; }
  [[nodiscard]] core::Diagnostics& diagnostics() { return diagnostics_; }
  [[nodiscard]] TypeRef type_of(ValueId value) { return body().insts[value.index].type; }
  [[nodiscard]] TypeRef type_of(PlaceId place) { return body().places[place.index].type; }

  /// Instructions made from now on come from `at`.
  void set_source(const SourceRef& at);
  /// Instructions made from now on are this part of a statement; returns what they were before.
  Part set_part(Part part) { return std::exchange(part_, part); }
  /// Reports with the POU's name at `at`.
  void report(core::Code code, const SourceRef& at, std::string message, std::string help = {});

  /// Says that the function or block `used`, of a library perhaps, is used at `at`. False, and reported, when it is of
  /// a library and broken.
  bool use_pou(std::uint32_t used, const SourceRef& at);
  /// Whether `name`, which stands for nothing here, is that of something broken in a library; reports that it is used.
  bool is_broken(std::string_view name, const SourceRef& at);

  // ---- places (interned) ----
  PlaceId variable(
      std::uint32_t index);  ///< instance or frame variable; an external becomes its global, an in-out is dereferenced
  PlaceId global(std::uint32_t index);
  PlaceId self();  ///< the instance that the body runs on
  PlaceId field(PlaceId parent, std::uint32_t index);
  PlaceId element(PlaceId parent, std::uint32_t zero_based_index);
  /// Element at a value of any integer or bit string type, as declared (lower bound included).
  PlaceId element_at(PlaceId array, ValueId index);
  /// What a reference or pointer leads to. A pointer to what holds function block instances leads to exactly that type.
  PlaceId deref(ValueId reference);
  /// Bits of the integer or bit string `word` from `bit_offset` on, as for extract(). Loaded and stored like any place;
  /// it has no handle.
  PlaceId part(PlaceId word, TypeRef part, unsigned bit_offset);
  /// The character of a string at a position of any integer type, from 1 on, as CHAR or WCHAR. Loaded and stored like
  /// any place; it has no handle. Outside of the string it is 0 and is not written, each with an event.
  PlaceId character(PlaceId string, ValueId position);
  [[nodiscard]] bool is_part(PlaceId place) {
    const Place::Kind kind = body().places[place.index].kind;
    return kind == Place::Kind::kPart || kind == Place::Kind::kCharacter;
  }
  /// Field or port of `parent` by name (struct field; port of a standard block; input, output, in-out variable of a POU
  /// instance). Nothing when there is none.
  std::optional<PlaceId> member(PlaceId parent, std::string_view name);
  /// Text for messages: "Tank.Level[3]".
  [[nodiscard]] std::string describe(PlaceId place);

  /// Notes that the text at `at` writes `global` under `name`. Globals without an address are left out.
  void note_written_name(std::uint32_t global, std::string_view name, const SourceRef& at);
  /// The names under which this body writes `global` were reported: only the first of them is left for the lint.
  void drop_written_names(std::uint32_t global);

  /// Adds a variable that no source can name: edge memory, feedback wire, value kept while EN is FALSE. It lives in the
  /// instance, or in functions in the frame. `hint` goes into its name ("#edge.12").
  std::uint32_t hidden(std::string_view hint, TypeRef type);

  // ---- values ----
  ValueId constant(const Constant& constant);
  ValueId constant_bool(bool value);
  ValueId load(PlaceId place);
  ValueId logic(Op and_or_xor, ValueId a, ValueId b);
  ValueId not_(ValueId a);
  void store(PlaceId place, ValueId value);  ///< types equal, or both STRING, or both WSTRING
  void copy(PlaceId to, PlaceId from);       ///< aggregates of one type
  /// place := what a variable of its type begins with, or where one is declared so, with these initial values.
  void store_default(PlaceId place, std::vector<InitItem> initial = {});
  void run(PlaceId instance);  ///< standard block or POU
  void run_action(PlaceId instance, std::uint32_t action);
  ValueId make_ref(PlaceId place);
  ValueId same_ref(ValueId a, ValueId b);  ///< references of one type
  /// ADR of a place, as POINTER TO `target`: its type, or what shall be read there instead.
  ValueId address(PlaceId place, TypeRef target);
  /// A pointer as an address of 32 bits of type `to` (UDINT, DWORD), and back as a value of pointer type `to`.
  ValueId pointer_to_32(ValueId pointer, TypeRef to);
  ValueId pointer_from_32(ValueId address, TypeRef to);
  /// Bits of `word` (an integer or bit string) from `bit_offset` on, as `part`: BOOL is one bit; BYTE, WORD and DWORD
  /// are narrower than the word and are at multiples of their width.
  ValueId extract(ValueId word, TypeRef part, unsigned bit_offset);
  /// `word` with the bits from `bit_offset` on replaced by `part`.
  ValueId insert(ValueId word, ValueId part, unsigned bit_offset);
  /// `value` (of the base type) held inside `subrange`; outside it is an event.
  ValueId range(ValueId value, TypeRef subrange);
  void clear_event();
  ValueId eno();

  /// A call of a standard function whose arguments have the exact types of the overload.
  ValueId call_overload(const stdlib::Overload& overload, std::span<const ValueId> args, TypeRef result_type);
  /// A call of a function POU. The value is the result; invalid for functions without one.
  ValueId call_pou(std::uint32_t pou, std::span<const CallArg> args);

  // ---- control ----
  LabelId new_label();
  void bind(LabelId label);
  void jump(LabelId label);
  void jump_if(ValueId condition, LabelId label);
  void jump_if_not(ValueId condition, LabelId label);
  void ret();

  // ---- typed helpers: they report and return nothing on a mismatch ----

  /// `operand` as a value of `to`: a literal takes the type, a typed value is widened where the third edition allows.
  /// `what` names the receiver in messages: "input \"PT\" of TON", "variable \"X\"".
  std::optional<ValueId> convert(const Operand& operand, TypeRef to, std::string_view what);
  /// store(place, convert(operand)): also copies aggregates, fits strings, checks constants against subranges.
  bool assign(PlaceId place, const Operand& operand, std::string_view what);
  /// What a call gives input `index` of the instance: assign(), but for configuration ports of taskblocks, which get
  /// their constant before anything runs.
  bool assign_input(PlaceId instance, std::uint32_t index, const Operand& operand, std::string_view what);
  /// Resolves and calls the standard function `name`; BOOL AND/OR/XOR/NOT become logic ops, constants are folded where
  /// the row allows. Messages list candidates. `pins` name the arguments when the drawing does (else empty).
  std::optional<ValueId> call(std::string_view name, std::span<const Operand> args, const SourceRef& at,
                              std::optional<TypeRef> expected = std::nullopt, std::span<const std::string> pins = {});
  /// The operand as a value of the type it has by itself (an untyped integer is DINT or LINT, a real is LREAL or
  /// `expected`).
  std::optional<ValueId> settle(const Operand& operand, std::optional<TypeRef> expected = std::nullopt);

  // ---- coverage: nothing without Module::coverage, in tests and in libraries ----

  /// The site of this kind at `at`, which is added where it is new. Nothing where nothing is covered.
  std::optional<std::uint32_t> cover_site(CoverKind kind, const SourceRef& at, std::string_view text,
                                          std::uint32_t rung = 0);
  /// Notes that outcome 0 or 1 of the site happened, or that it did when `when` is TRUE.
  void cover(std::optional<std::uint32_t> site, std::uint32_t outcome, std::optional<ValueId> when = std::nullopt);

  // ---- probes: nothing without Module::probes, and in tests ----

  [[nodiscard]] bool notes_probes() { return module_.probes && !pou().test; }
  /// The value is what is to be seen at `key`.
  void probe(const ProbeKey& key, ValueId value);
  /// The same; literals stand in the drawing anyway.
  void probe(const ProbeKey& key, const Operand& operand);
  /// What is in the variable here.
  void probe(const ProbeKey& key, PlaceId place);
  /// That control comes here.
  void probe_reached(const ProbeKey& key);

  /// What a value stands for that was computed in a wider type: BYTE + BYTE is a LINT that goes where a BYTE may go
  /// (stdlib/idioms.h).
  struct Narrow {
    TypeId type = TypeId::kBool;
    stdlib::Idiom idiom = stdlib::Idiom::kNone;  ///< of taking it for its type
    bool noted = false;                          ///< an idiom was noted where it was computed
  };
  void set_narrow(ValueId value, const Narrow& narrow) { narrow_[value.index] = narrow; }
  /// Null for a value that is of its type.
  [[nodiscard]] const Narrow* narrow_of(ValueId value) const {
    const auto found = narrow_.find(value.index);
    return found == narrow_.end() ? nullptr : &found->second;
  }

 private:
  /// Whether the place is a TIME of a standard block that takes LTIME, too.
  [[nodiscard]] bool takes_ltime(PlaceId place);
  /// An LTIME as the TIME of as many nanoseconds; anything else as it is.
  Operand as_time(const Operand& operand);
  bool use_part(const SourceRef& declared, const SourceRef& at);
  bool configure(PlaceId instance, std::uint32_t index, const Operand& operand, std::string_view what);
  /// What loads and stores of a character become.
  ValueId character_of(ValueId string, ValueId position);
  ValueId with_character(ValueId string, ValueId character, ValueId position);
  std::uint32_t emit(Op op, TypeRef type, std::uint32_t a = 0, std::uint32_t b = 0, std::uint16_t count = 0);
  PlaceId intern(const Place& place);
  [[nodiscard]] bool part_fits(TypeRef word, TypeRef part, unsigned bit_offset) const;

  Module& module_;
  std::uint32_t pou_index_;
  std::uint32_t owner_index_;
  core::Diagnostics& diagnostics_;
  std::uint32_t source_ = 0;
  Part part_ = Part::kPlain;
  struct PlaceHash {
    std::size_t operator()(const Place& p) const {
      return (static_cast<std::size_t>(p.kind) * 1000003u + p.index) * 1000003u + p.parent.index;
    }
  };
  struct PlaceEqual {
    bool operator()(const Place& a, const Place& b) const {
      return a.kind == b.kind && a.index == b.index && a.parent == b.parent && a.type == b.type;
    }
  };
  std::unordered_map<Place, PlaceId, PlaceHash, PlaceEqual> interned_;
  std::unordered_map<std::uint32_t, Narrow> narrow_;         ///< by value
  std::unordered_map<std::uint32_t, Narrow> narrow_hidden_;  ///< by place: what hidden variables keep for later
  std::vector<PlaceId> variable_places_;  ///< by variable index, in-outs left out: most places need no hash
};

/// Instructions made while it lives belong to `part`.
class PartScope {
 public:
  PartScope(Builder& builder, Part part) : builder_(builder), before_(builder.set_part(part)) {}
  ~PartScope() { builder_.set_part(before_); }
  PartScope(const PartScope&) = delete;
  PartScope& operator=(const PartScope&) = delete;

 private:
  Builder& builder_;
  Part before_;
};

}  // namespace plc::ir
