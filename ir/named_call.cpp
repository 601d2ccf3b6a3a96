// Standard functions called by name: arguments classified, overload resolved, problems named by pin.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "ir/convert.h"

namespace plc::ir {
namespace {

using core::Code;
using stdlib::Idiom;
using stdlib::Overload;

/// One call by name: arguments classified, overload resolved, problems named by pin.
class NamedCall {
 public:
  NamedCall(Builder& builder, std::string_view name, std::span<const Operand> args, const SourceRef& at,
            std::optional<TypeRef> expected, std::span<const std::string> pins)
      : builder_(builder), name_(core::uppered(name)), args_(args), at_(at), expected_(expected), pins_(pins) {}

  std::optional<ValueId> make() {
    if (const auto type = whole_type()) return choose(*type);
    if (!classify()) return std::nullopt;
    std::optional<TypeId> expected_id;
    if (expected_) expected_id = types().elementary_of(*expected_);
    if (asks_for_integer_power(expected_id)) return integer_power();
    // What holds an idiom already goes on as such: BYTE + BYTE is no LINT for what follows.
    const bool noted = std::any_of(loose_.begin(), loose_.end(), [](const stdlib::LooseArg& one) { return one.noted; });
    if (noted) {
      if (const auto loose = stdlib::resolve_loosely(name_, loose_, expected_id)) return call_loosely(*loose);
    }
    const stdlib::Resolution found = stdlib::resolve(name_, known_, expected_id);
    if (found.status == stdlib::Resolution::Status::kNoMatch && !noted) {
      if (const auto loose = stdlib::resolve_loosely(name_, loose_, expected_id)) return call_loosely(*loose);
    }
    if (found.status != stdlib::Resolution::Status::kFound) {
      explain(found);
      return std::nullopt;
    }
    const Overload& overload = *found.overload;
    std::vector<ValueId> values;
    values.reserve(args_.size());
    for (std::size_t i = 0; i < args_.size(); ++i) {
      const auto value = argument(i, overload.param_type(i));
      if (!value) return std::nullopt;
      values.push_back(*value);
    }
    if (const auto logic = boolean(overload, values)) return logic;
    const ValueId result = call_or_fold(builder_, overload, values, result_type(overload, values));
    const TypeId narrow = stdlib::narrow_result(overload, loose_);
    if (narrow != overload.result_type()) {
      const bool real = core::in_category(narrow, core::kAnyReal);
      builder_.set_narrow(result, {narrow, real ? Idiom::kIntoReal : Idiom::kMixedSigns, false});
    }
    return result;
  }

 private:
  TypeTable& types() { return builder_.module().types; }
  std::string quoted_pin(std::size_t i) const {
    if (i < pins_.size() && !pins_[i].empty()) return '"' + pins_[i] + '"';
    const auto named = stdlib::overloads_named(name_);
    return '"' + (named.empty() ? fmt::format("IN{}", i + 1) : stdlib::pin_name(*named.front().spec, i)) + '"';
  }
  std::string input(std::size_t i) const { return fmt::format("input {} of {}", quoted_pin(i), name_); }
  /// The first of the inputs that the result is one of.
  std::size_t first_choice() const { return name_ == "MOVE" ? 0 : 1; }
  /// The type of structures, arrays or references among what stands to choose: no row has them, and moving them is the
  /// same for all. Nothing when there are none.
  std::optional<TypeRef> whole_type() {
    if (name_ != "MOVE" && name_ != "SEL" && name_ != "MUX") return std::nullopt;
    for (std::size_t i = first_choice(); i < args_.size(); ++i) {
      if (args_[i].kind != Operand::Kind::kValue) continue;
      const TypeRef type = builder_.type_of(args_[i].value);
      if (!types().elementary_of(type)) return type;
    }
    return std::nullopt;
  }
  /// MOVE, SEL and MUX are of ANY (IEC 61131-3:2013, table 32).
  std::optional<ValueId> choose(TypeRef type) {
    const std::size_t first = first_choice();
    const stdlib::FunctionSpec& spec = *stdlib::overloads_named(name_).front().spec;
    if (spec.extensible ? args_.size() < spec.param_count : args_.size() != spec.param_count) {
      explain({stdlib::Resolution::Status::kWrongCount});
      return std::nullopt;
    }
    for (std::size_t i = first; i < args_.size(); ++i) {
      if (!builder_.convert(args_[i], type, input(i))) return std::nullopt;
    }
    if (types().holds_instance(type)) {
      builder_.report(
          Code::P4109, at_,
          fmt::format("{} has type {}, which holds a function block instance", input(first), types().name_of(type)),
          "assign its members, or pass the instance to a VAR_IN_OUT");
      return std::nullopt;
    }
    if (name_ == "MOVE") return args_[0].value;
    const PlaceId chosen = builder_.variable(builder_.hidden("chosen", type));
    builder_.store(chosen, args_[first].value);
    return name_ == "SEL" ? choose_by_condition(chosen) : choose_by_number(chosen);
  }
  std::optional<ValueId> choose_by_condition(PlaceId chosen) {
    const auto condition = builder_.convert(args_[0], kBoolType, input(0));
    if (!condition) return std::nullopt;
    const LabelId end = builder_.new_label();
    builder_.jump_if_not(*condition, end);
    builder_.store(chosen, args_[2].value);
    builder_.bind(end);
    return builder_.load(chosen);
  }
  /// The MUX of the numbers 0, 1, .. knows what a number outside does.
  std::optional<ValueId> choose_by_number(PlaceId chosen) {
    std::vector<Operand> numbers{args_[0]};
    for (std::size_t i = 1; i < args_.size(); ++i) numbers.push_back(number(i - 1));
    const auto index = builder_.call("MUX", numbers, at_, ref_of(TypeId::kDint));
    if (!index) return std::nullopt;
    for (std::size_t i = 2; i < args_.size(); ++i) {
      const std::array<Operand, 2> pair{Operand::of(*index, at_), number(i - 1)};
      const LabelId next = builder_.new_label();
      builder_.jump_if_not(*builder_.call("EQ", pair, at_), next);
      builder_.store(chosen, args_[i].value);
      builder_.bind(next);
    }
    return builder_.load(chosen);
  }
  Operand number(std::size_t value) const {
    Operand operand;
    operand.kind = Operand::Kind::kIntLiteral;
    operand.int_value = static_cast<std::int64_t>(value);
    operand.at = at_;
    return operand;
  }
  SourceRef place_of(std::size_t i) const { return args_[i].at.line != 0 ? args_[i].at : at_; }

  bool classify() {
    bool fine = true;
    if (stdlib::overloads_named(name_).empty()) {
      builder_.report(Code::P9001, at_, fmt::format("no front end looked for the function {}", name_));
      return false;
    }
    known_.reserve(args_.size());
    for (std::size_t i = 0; i < args_.size(); ++i) {
      stdlib::Arg arg;
      switch (args_[i].kind) {
        case Operand::Kind::kUnconnected:
          builder_.report(Code::P4106, place_of(i), fmt::format("{} is not connected", input(i)),
                          "wire it or give it a value");
          fine = false;
          break;
        case Operand::Kind::kIntLiteral:
          arg = literal_arg(args_[i]);
          break;
        case Operand::Kind::kRealLiteral:
          arg.kind = stdlib::Arg::Kind::kRealLiteral;
          break;
        case Operand::Kind::kValue: {
          const TypeRef type = builder_.type_of(args_[i].value);
          const auto id = types().elementary_of(type);
          if (id) {
            arg.type = *id;
            break;
          }
          builder_.report(
              Code::P4103, place_of(i), fmt::format("{} has type {}", input(i), types().name_of(type)),
              types()[type].kind == TypeKind::kReference
                  ? "references are not computed with: use an array and an index, or read what it refers to: ^"
                  : "give it one element or member");
          fine = false;
          break;
        }
      }
      known_.push_back(arg);
      stdlib::LooseArg loose{arg, arg.type, false};
      if (args_[i].kind == Operand::Kind::kValue) {
        if (const Builder::Narrow* const narrow = builder_.narrow_of(args_[i].value)) {
          loose.narrow = narrow->type;
          loose.noted = narrow->noted;
        }
      }
      loose_.push_back(loose);
    }
    return fine;
  }

  // ---- what the standard does not know ----

  std::optional<ValueId> call_loosely(const stdlib::LooseCall& call) {
    note(call);
    std::vector<ValueId> values;
    for (std::size_t i = 0; i < args_.size(); ++i) {
      const auto value = loose_argument(i, call.overload->param_type(i));
      if (!value) return std::nullopt;
      values.push_back(*value);
    }
    ValueId result = call.keeps_sign
                         ? shifted_with_sign(*call.overload, values)
                         : call_or_fold(builder_, *call.overload, values, result_type(*call.overload, values));
    if (call.result != call.overload->result_type()) {
      result = call_or_fold(builder_, *conversion(call.overload->result_type(), call.result), std::span(&result, 1),
                            ref_of(call.result));
    }
    if (call.narrow != call.result) builder_.set_narrow(result, {call.narrow, call.idiom, true});
    return result;
  }

  /// The argument as a value of `type`, without a note of its own.
  std::optional<ValueId> loose_argument(std::size_t i, TypeId type) {
    const Operand& operand = args_[i];
    if (operand.kind == Operand::Kind::kIntLiteral && stdlib::literal_fits_by_bits(known_[i], type)) {
      Constant constant;
      constant.type = ref_of(type);
      constant.bits = static_cast<std::uint64_t>(operand.int_value);
      const std::uint32_t bytes = core::rep_bytes(core::rep_of(type));
      if (bytes < 8) constant.bits &= (std::uint64_t{1} << (bytes * 8)) - 1;
      return builder_.constant(constant);
    }
    const bool typed = operand.kind == Operand::Kind::kValue;
    if (!typed || known_[i].type == type || stdlib::widens(known_[i].type, type)) return argument(i, type);
    const Overload* const to = conversion(known_[i].type, type);
    if (to == nullptr) return argument(i, type);
    return call_or_fold(builder_, *to, std::span(&operand.value, 1), ref_of(type));
  }

  /// SHR of a signed integer fills with its sign: what is below 0 is shifted inverted.
  ValueId shifted_with_sign(const Overload& shift, std::span<const ValueId> values) {
    const TypeId bits = shift.t;
    const std::string type(core::name_of(bits));
    const auto constant = [&](std::uint64_t value) { return builder_.constant({ref_of(bits), value, {}}); };
    const auto apply = [&](std::string_view function, std::initializer_list<ValueId> args, TypeId result) {
      const Overload* const overload = stdlib::overload_with_key(fmt::format("{}:{}", function, type));
      return call_or_fold(builder_, *overload, std::span(args.begin(), args.size()), ref_of(result));
    };
    const unsigned width = core::rep_bytes(core::rep_of(bits)) * 8;
    const std::uint64_t ones = width == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << width) - 1;
    const ValueId negative = apply("GE", {values[0], constant(std::uint64_t{1} << (width - 1))}, TypeId::kBool);
    const ValueId mask = apply("SEL", {negative, constant(0), constant(ones)}, bits);
    const ValueId shown = apply("XOR", {values[0], mask}, bits);
    const ValueId moved = call_or_fold(builder_, shift, std::array{shown, values[1]}, ref_of(bits));
    return apply("XOR", {moved, mask}, bits);
  }

  /// Whether a power of integers goes where an integer is needed, which no power of reals may.
  bool asks_for_integer_power(std::optional<TypeId> expected) const {
    if (name_ != "EXPT" || args_.size() != 2 || !expected || *expected == TypeId::kBool) return false;
    const auto is_whole = [](TypeId id) {
      return core::in_category(id, core::kAnyInt | core::kAnyBit) && id != TypeId::kBool;
    };
    return is_whole(*expected) && std::all_of(known_.begin(), known_.end(), [&](const stdlib::Arg& arg) {
             return arg.kind == stdlib::Arg::Kind::kIntLiteral ||
                    (arg.kind == stdlib::Arg::Kind::kTyped && is_whole(arg.type));
           });
  }

  std::optional<ValueId> integer_power() {
    builder_.report(Code::P4336, at_, fmt::format("power of {} is computed as an integer", shown(0)),
                    "EXPT is of reals: LREAL_TO_LINT(EXPT(INT_TO_LREAL(..), ..)) says so everywhere");
    const Operand& base = args_[0];
    TypeId narrow = loose_[0].narrow;
    if (base.kind == Operand::Kind::kIntLiteral) {
      // The literal alone says nothing about how large its powers are.
      narrow = TypeId::kSint;
    }
    const bool long_bits = known_[0].kind == stdlib::Arg::Kind::kTyped && known_[0].type == TypeId::kUlint;
    const bool huge = base.kind == Operand::Kind::kIntLiteral && base.int_is_unsigned;
    const TypeId computed = long_bits || huge || narrow == TypeId::kLword ? TypeId::kUlint : TypeId::kLint;
    const auto value = loose_argument(0, computed);
    if (!value) return std::nullopt;
    ValueId exponent = builder_.settle(args_[1]).value_or(ValueId{});
    if (!exponent.valid()) return std::nullopt;
    TypeId count = *types().elementary_of(builder_.type_of(exponent));
    if (core::in_category(count, core::kAnyBit)) {
      const TypeId number = stdlib::unsigned_of(count);
      exponent = call_or_fold(builder_, *conversion(count, number), std::span(&exponent, 1), ref_of(number));
      count = number;
    }
    const Overload* const power =
        stdlib::overload_with_key(fmt::format("INTEGER_POWER:{},{}", core::name_of(computed), core::name_of(count)));
    const ValueId result = call_or_fold(builder_, *power, std::array{*value, exponent}, ref_of(computed));
    builder_.set_narrow(result, {narrow, Idiom::kIntegerPower, true});
    return result;
  }

  /// An argument for messages: "x" where the text is known, the input else.
  std::string shown(std::size_t i) const {
    return args_[i].text.empty() ? "input " + quoted_pin(i) : '"' + args_[i].text + '"';
  }

  void note(const stdlib::LooseCall& call) {
    if (call.idiom == Idiom::kNone) return;
    const std::size_t i = call.because;
    const std::string type = types().name_of(builder_.type_of(args_[i].value));
    const TypeId made = call.overload->param_type(i);
    std::string message;
    switch (call.idiom) {
      case Idiom::kBitArithmetic:
        message = fmt::format("{} computes with {} of type {}", name_, shown(i), type);
        break;
      case Idiom::kIntegerBits:
        message = fmt::format("{} takes the bits of {} of type {}", name_, shown(i), type);
        break;
      case Idiom::kShiftCount:
        message = fmt::format("{} counts by {} of type {}", name_, shown(i), type);
        break;
      default:
        message = fmt::format("{} takes {} of type {} for {}", name_, shown(i), type, core::name_of(made));
    }
    std::string help;
    if (conversion(known_[i].type, made) != nullptr) {
      help = fmt::format("{}_TO_{} says so everywhere", core::name_of(known_[i].type), core::name_of(made));
    }
    builder_.report(code_of(call.idiom), place_of(i), std::move(message), std::move(help));
  }

  std::optional<ValueId> argument(std::size_t i, TypeId type) {
    const Operand& operand = args_[i];
    // Strings of any capacity are passed as they are.
    if (operand.kind == Operand::Kind::kValue && known_[i].type == type) return operand.value;
    return convert_with(builder_, operand, ref_of(type), [&] { return input(i); });
  }

  /// BOOL functions that look-up tables can hold.
  std::optional<ValueId> boolean(const Overload& overload, std::span<const ValueId> v) {
    if (v.empty()) return std::nullopt;
    const std::string_view function = overload.name;  // "AND" where AND_BOOL is called
    if (function == "MOVE" && v.size() == 1) return v[0];
    if (overload.spec->t_categories == 0 || overload.t != TypeId::kBool) return std::nullopt;
    if (function == "NOT") return builder_.not_(v[0]);
    const bool pair = v.size() == 2;
    if (function == "EQ" && pair) return builder_.not_(builder_.logic(Op::kXor, v[0], v[1]));
    if (function == "NE" && pair) return builder_.logic(Op::kXor, v[0], v[1]);
    if (function == "SEL" && v.size() == 3) {
      const ValueId low = builder_.logic(Op::kAnd, builder_.not_(v[0]), v[1]);
      return builder_.logic(Op::kOr, low, builder_.logic(Op::kAnd, v[0], v[2]));
    }
    Op op = Op::kAnd;
    if (function == "OR") {
      op = Op::kOr;
    } else if (function == "XOR") {
      op = Op::kXor;
    } else if (function != "AND") {
      return std::nullopt;
    }
    ValueId value = v[0];
    for (std::size_t i = 1; i < v.size(); ++i) value = builder_.logic(op, value, v[i]);
    return value;
  }

  TypeRef result_type(const Overload& overload, std::span<const ValueId> values) {
    const TypeId id = overload.result_type();
    if (id == TypeId::kString || id == TypeId::kWstring) {
      return types().string(id, result_capacity(overload, values));
    }
    // Choosing among values of one enumeration or subrange gives one of them.
    static constexpr std::array<std::string_view, 5> kChoices{"SEL", "MUX", "MIN", "MAX", "LIMIT"};
    if (overload.spec->result.kind == stdlib::ParamType::Kind::kT &&
        std::find(kChoices.begin(), kChoices.end(), overload.name) != kChoices.end()) {
      const TypeRef last = builder_.type_of(values.back());
      bool same = true;
      for (std::size_t i = 0; i < values.size(); ++i) {
        const std::size_t declared = std::min<std::size_t>(i, overload.spec->param_count - 1u);
        const bool chosen = overload.spec->params[declared].type.kind == stdlib::ParamType::Kind::kT;
        same = same && (!chosen || builder_.type_of(values[i]) == last);
      }
      if (same) return last;
    }
    return ref_of(id);
  }

  /// Large enough for what the arguments can hold: cutting belongs to the assignment that asks for less.
  std::uint16_t result_capacity(const Overload& overload, std::span<const ValueId> values) {
    const TypeId id = overload.result_type();
    const bool joins = overload.name == "CONCAT" || overload.name == "INSERT" || overload.name == "REPLACE";
    std::uint32_t sum = 0;
    std::uint32_t most = core::kDefaultStringCapacity;
    for (const ValueId value : values) {
      const Type& type = types()[builder_.type_of(value)];
      if (type.kind != TypeKind::kString || type.elementary != id) continue;
      sum += type.capacity;
      most = std::max<std::uint32_t>(most, type.capacity);
    }
    if (joins) most = std::max(most, sum);
    return static_cast<std::uint16_t>(std::min<std::uint32_t>(most, core::kMaxStringCapacity));
  }

  std::string type_text(std::size_t i) {
    const stdlib::Arg& arg = known_[i];
    if (arg.kind == stdlib::Arg::Kind::kIntLiteral) return "literal " + text_of(args_[i]);
    if (arg.kind == stdlib::Arg::Kind::kRealLiteral) return "literal " + text_of(args_[i]);
    return types().name_of(builder_.type_of(args_[i].value));
  }

  void explain(const stdlib::Resolution& found) {
    const stdlib::FunctionSpec& spec = *stdlib::overloads_named(name_).front().spec;
    switch (found.status) {
      case stdlib::Resolution::Status::kWrongCount: {
        if (spec.extensible && args_.size() > stdlib::kMaxArguments) {
          builder_.report(
              Code::P4105, at_,
              fmt::format("{} takes at most {} inputs, {} given", name_, stdlib::kMaxArguments, args_.size()),
              "put some of them together in calls of their own");
          return;
        }
        std::string inputs;
        for (std::size_t i = 0; i < spec.param_count; ++i) inputs += (i ? ", " : "") + stdlib::pin_name(spec, i);
        builder_.report(
            Code::P4105, at_,
            fmt::format("{} takes {} input{} ({}{}), {} given", name_, spec.param_count,
                        spec.param_count == 1 ? "" : "s", inputs, spec.extensible ? ", .." : "", args_.size()));
        return;
      }
      case stdlib::Resolution::Status::kAmbiguous:
        builder_.report(Code::P9001, at_,
                        fmt::format("call of {} fits {} and {}", name_, stdlib::key_of(*found.overload),
                                    stdlib::key_of(*found.rival)),
                        "give each literal its type, for example INT#1");
        return;
      default:
        explain_mismatch();
    }
  }

  /// Names the first input that no overload takes, or else the one that differs from what the others agree on.
  void explain_mismatch() {
    const auto candidates = stdlib::overloads_named(name_);
    for (std::size_t i = 0; i < args_.size(); ++i) {
      const bool taken = std::any_of(candidates.begin(), candidates.end(), [&](const Overload& o) {
        const TypeId want = o.param_type(i);
        if (known_[i].kind == stdlib::Arg::Kind::kTyped) {
          // What a shift moves may be an integer: its count does not fit then.
          const bool moved = o.spec->u_categories != 0 && i == 0;
          return stdlib::widens(known_[i].type, want) ||
                 (moved && stdlib::implicit_conversion(loose_[i].narrow, want) != Idiom::kNone);
        }
        if (known_[i].kind == stdlib::Arg::Kind::kRealLiteral) return core::in_category(want, core::kAnyReal);
        return stdlib::literal_fits(known_[i], want);
      });
      if (taken) continue;
      builder_.report(Code::P4103, place_of(i),
                      fmt::format("{} has type {}, which {} does not take", input(i), type_text(i), name_),
                      is_literal_text(args_[i]) ? quotes_help(args_[i]) : "candidates: " + candidate_list());
      return;
    }
    const std::optional<std::size_t> reference = commonest();
    std::size_t odd = args_.size();
    for (std::size_t i = 0; reference && i < args_.size() && odd == args_.size(); ++i) {
      if (!agrees(known_[i], known_[*reference].type)) odd = i;
    }
    if (odd == args_.size()) {
      builder_.report(Code::P4103, at_, fmt::format("{} does not take these inputs", name_),
                      "candidates: " + candidate_list());
      return;
    }
    std::string help = "candidates: " + candidate_list();
    if (is_literal_text(args_[odd])) {
      help = quotes_help(args_[odd]);
    } else if (known_[odd].kind == stdlib::Arg::Kind::kTyped &&
               conversion(known_[odd].type, known_[*reference].type) != nullptr) {
      help = fmt::format("convert it with {}_TO_{}", core::name_of(known_[odd].type),
                         core::name_of(known_[*reference].type));
    } else if (known_[odd].kind == stdlib::Arg::Kind::kIntLiteral &&
               core::in_category(known_[*reference].type, core::kAnyDuration)) {
      help = fmt::format("write a duration: T#{}ms", text_of(args_[odd]));
    }
    const bool several = args_.size() > 2;
    builder_.report(
        Code::P4103, place_of(odd),
        fmt::format("{} has type {}, {} {}", input(odd), type_text(odd),
                    several ? std::string("other inputs are") : fmt::format("input {} is", quoted_pin(*reference)),
                    type_text(*reference)),
        std::move(help));
  }

  /// The first input whose type most inputs share.
  std::optional<std::size_t> commonest() const {
    std::optional<std::size_t> best;
    std::size_t most = 0;
    for (std::size_t i = 0; i < known_.size(); ++i) {
      if (known_[i].kind != stdlib::Arg::Kind::kTyped) continue;
      const auto alike =
          static_cast<std::size_t>(std::count_if(known_.begin(), known_.end(), [&](const stdlib::Arg& o) {
            return o.kind == stdlib::Arg::Kind::kTyped && o.type == known_[i].type;
          }));
      if (alike > most) {
        most = alike;
        best = i;
      }
    }
    return best;
  }

  static bool agrees(const stdlib::Arg& arg, TypeId type) {
    if (arg.kind == stdlib::Arg::Kind::kTyped) return arg.type == type;
    if (arg.kind == stdlib::Arg::Kind::kRealLiteral) return core::in_category(type, core::kAnyReal);
    return stdlib::literal_fits(arg, type);
  }

  bool takes_an_input(const Overload& o) const {
    for (std::size_t i = 0; i < known_.size(); ++i) {
      if (known_[i].kind == stdlib::Arg::Kind::kTyped && o.param_type(i) == known_[i].type) return true;
    }
    return false;
  }

  /// The overloads, those first that take an input as it is.
  std::string candidate_list() const {
    constexpr std::size_t kShown = 6;
    std::string list;
    std::size_t shown = 0;
    const auto candidates = stdlib::overloads_named(name_);
    for (const bool taking : {true, false}) {
      for (const Overload& o : candidates) {
        if (takes_an_input(o) != taking) continue;
        if (shown++ == kShown) return list + ", ..";
        list += (list.empty() ? "" : ", ") + name_ + "(";
        for (std::size_t i = 0; i < o.spec->param_count; ++i) {
          list += (i ? ", " : "") + std::string(core::name_of(o.param_type(i)));
        }
        list += ")";
      }
    }
    return list;
  }

  Builder& builder_;
  std::string name_;
  std::span<const Operand> args_;
  const SourceRef& at_;
  std::optional<TypeRef> expected_;
  std::span<const std::string> pins_;
  std::vector<stdlib::Arg> known_;
  std::vector<stdlib::LooseArg> loose_;  ///< the same, and what they stand for
};

}  // namespace

std::optional<ValueId> Builder::call(std::string_view name, std::span<const Operand> args, const SourceRef& at,
                                     std::optional<TypeRef> expected, std::span<const std::string> pins) {
  return NamedCall(*this, name, args, at, expected, pins).make();
}

}  // namespace plc::ir
