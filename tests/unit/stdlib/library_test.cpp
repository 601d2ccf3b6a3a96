// The table itself: order, look-up, keys, and the examples of every row executed.
#include "stdlib/library.h"

#include <set>

#include "core/text.h"
#include "tests/unit/stdlib/values.h"

namespace plc::test {
namespace {

using stdlib::Event;
using stdlib::Overload;

TEST(Library, IsSortedByFoldedNameWithOverloadsOfOneNameAdjacent) {
  std::set<std::string> seen;
  std::string last;
  for (const Overload& o : stdlib::overloads()) {
    const std::string name = core::folded(o.name);
    ASSERT_NE(o.kernel, nullptr) << o.name;
    if (name == last) continue;
    EXPECT_LT(last, name);
    EXPECT_TRUE(seen.insert(name).second) << name;
    last = name;
  }
}

TEST(Library, FindsEveryNameInAnyCase) {
  for (const Overload& o : stdlib::overloads()) {
    const auto found = stdlib::overloads_named(core::folded(o.name));
    ASSERT_FALSE(found.empty()) << o.name;
    EXPECT_TRUE(&o >= found.data() && &o < found.data() + found.size()) << o.name;
  }
  EXPECT_TRUE(stdlib::overloads_named("").empty());
  EXPECT_TRUE(stdlib::overloads_named("AD").empty());
  EXPECT_TRUE(stdlib::overloads_named("ADDD").empty());
  EXPECT_TRUE(stdlib::overloads_named("ZZZ").empty());
}

TEST(Library, EveryKeyIsUniqueAndFindsItsOverload) {
  std::set<std::string> keys;
  for (const Overload& o : stdlib::overloads()) {
    const std::string key = stdlib::key_of(o);
    EXPECT_TRUE(keys.insert(key).second) << key;
    EXPECT_EQ(stdlib::overload_with_key(key), &o) << key;
  }
  for (const char* bad : {"", ":", "ADD", "ADD:", "ADD:DINT,DINT", "ADD:NOTYPE", "NOPE:DINT", "ADD:DINT,", "ADD:BOOL",
                          "ADD:DINT,DINT,DINT,DINT,DINT,DINT"}) {
    EXPECT_EQ(stdlib::overload_with_key(bad), nullptr) << bad;
  }
  EXPECT_EQ(stdlib::key_of(overload("shl:word,int")), "SHL:WORD,INT");
  EXPECT_EQ(stdlib::key_of(overload("SEL:REAL")), "SEL:REAL");
}

TEST(Library, HasTheNamesOfTheStandard) {
  for (const char* name : {"ADD",
                           "SUB",
                           "MUL",
                           "DIV",
                           "MOD",
                           "EXPT",
                           "ABS",
                           "SQRT",
                           "LN",
                           "LOG",
                           "EXP",
                           "SIN",
                           "COS",
                           "TAN",
                           "ASIN",
                           "ACOS",
                           "ATAN",
                           "ATAN2",
                           "NEG",
                           "MOVE",
                           "GT",
                           "GE",
                           "EQ",
                           "LE",
                           "LT",
                           "NE",
                           "AND",
                           "OR",
                           "XOR",
                           "NOT",
                           "SHL",
                           "SHR",
                           "ROL",
                           "ROR",
                           "SEL",
                           "MAX",
                           "MIN",
                           "LIMIT",
                           "MUX",
                           "LEN",
                           "LEFT",
                           "RIGHT",
                           "MID",
                           "CONCAT",
                           "INSERT",
                           "DELETE",
                           "REPLACE",
                           "FIND",
                           "TRUNC",
                           "DINT_TO_REAL",
                           "BOOL_TO_BYTE",
                           "TIME_TO_DINT",
                           "TO_INT",
                           "STRING_TO_REAL",
                           "DT_TO_TOD",
                           "DATE_AND_TIME_TO_DATE",
                           "REAL_TRUNC_DINT",
                           "TRUNC_LINT",
                           "ADD_TIME",
                           "MULTIME",
                           "MUL_TIME",
                           "SUB_DT_DT",
                           "CHAR_TO_STRING"}) {
    EXPECT_FALSE(stdlib::overloads_named(name).empty()) << name;
  }
  for (const char* name : {"INT_TO_INT", "DATE_TO_REAL", "TOD_TO_DATE", "BOOL_TO_CHAR"}) {
    EXPECT_TRUE(stdlib::overloads_named(name).empty()) << name;
  }
}

TEST(Library, PinsAreCountedOnAfterTheDeclaredOnes) {
  const auto& add = *overload("ADD:DINT").spec;
  EXPECT_EQ(stdlib::pin_name(add, 0), "IN1");
  EXPECT_EQ(stdlib::pin_name(add, 11), "IN12");
  const auto& mux = *overload("MUX:DINT,INT").spec;
  EXPECT_EQ(stdlib::pin_name(mux, 0), "K");
  EXPECT_EQ(stdlib::pin_name(mux, 1), "IN0");
  EXPECT_EQ(stdlib::pin_name(mux, 10), "IN9");
  EXPECT_EQ(stdlib::pin_name(*overload("LIMIT:INT").spec, 2), "MX");
  EXPECT_EQ(stdlib::pin_name(mux, 3), "IN2");
}

TEST(Library, EveryRowIsDescribed) {
  for (const stdlib::FunctionSpec* spec : stdlib::function_specs()) {
    EXPECT_FALSE(spec->name.empty());
    EXPECT_FALSE(spec->clause.empty()) << spec->name;
    EXPECT_TRUE(spec->summary.ends_with(".") || spec->summary.ends_with(").")) << spec->name;
    EXPECT_FALSE(spec->examples.empty()) << spec->name;
    EXPECT_GE(spec->param_count, 1) << spec->name;
    for (std::size_t i = 0; i < spec->param_count; ++i) EXPECT_FALSE(spec->params[i].name.empty()) << spec->name;
  }
}

/// Splits "A, 'b, c', D" at the commas outside quotes.
std::vector<std::string> split(const std::string& list, char separator) {
  std::vector<std::string> out;
  std::string item;
  char quote = 0;
  for (const char c : list) {
    if (quote == 0 && c == separator) {
      out.emplace_back(quote == 0 && item.find('\'') == std::string::npos && item.find('"') == std::string::npos
                           ? std::string(core::trimmed(item))
                           : item.substr(item.find_first_of("'\"")));
      item.clear();
      continue;
    }
    if (quote != 0 && c == quote) {
      quote = 0;
    } else if (quote == 0 && (c == '\'' || c == '"')) {
      quote = c;
    }
    item += c;
  }
  const std::size_t at = item.find_first_of("'\"");
  out.emplace_back(at == std::string::npos ? std::string(core::trimmed(item)) : item.substr(at));
  return out;
}

const Overload* overload_of_example(const stdlib::FunctionSpec& spec, const std::string& name,
                                    const std::string& types) {
  const auto ids = types.empty() ? std::vector<std::string>{} : split(types, ',');
  for (const Overload& o : stdlib::overloads_named(name)) {
    if (o.spec != &spec) continue;
    std::size_t n = 0;
    bool same = true;
    const auto expect = [&](std::uint16_t categories, TypeId id) {
      if (categories == 0) return;
      same = same && n < ids.size() && core::type_named(ids[n]) == id;
      ++n;
    };
    expect(spec.t_categories, o.t);
    expect(spec.u_categories, o.u);
    if (same && n == ids.size()) return &o;
  }
  return nullptr;
}

TEST(Library, EveryExampleGivesItsResult) {
  for (const stdlib::FunctionSpec* spec : stdlib::function_specs()) {
    for (const stdlib::Example& example : spec->examples) {
      const std::string call_text(example.call);
      SCOPED_TRACE(call_text);
      const std::size_t open = call_text.find('(');
      const Overload* o = overload_of_example(*spec, call_text.substr(0, open), std::string(example.types));
      ASSERT_NE(o, nullptr);
      const auto literals = split(call_text.substr(open + 1, call_text.size() - open - 2), ',');
      std::vector<Value> args;
      for (std::size_t i = 0; i < literals.size(); ++i) args.emplace_back(o->param_type(i), literals[i]);

      std::string expected_text(example.result);
      std::string expected_event = "none";
      if (expected_text.starts_with("event:")) {
        const std::size_t blank = expected_text.find(' ');
        expected_event = expected_text.substr(6, blank - 6);
        expected_text = expected_text.substr(blank + 1);
      }
      const Value expected(o->result_type(), expected_text);
      Value result(o->result_type());
      const Event event = call(*o, result, args);
      EXPECT_EQ(stdlib::event_name(event), expected_event);
      EXPECT_TRUE(spec->events.contains(event));
      EXPECT_TRUE(result.same_as(expected)) << (result.is_string() ? result.text() : std::to_string(result.bits()));
    }
  }
}

/// Every overload of every row runs on any bits of the right type: no crash, events only where announced.
TEST(Library, EveryOverloadRunsOnExtremeValues) {
  const std::uint64_t kPatterns[] = {0,
                                     1,
                                     0x7f,
                                     0x80,
                                     0xff,
                                     0x8000,
                                     0xffff,
                                     0x80000000u,
                                     0x7fc00001,
                                     0xffffffffu,
                                     0x7fffffffffffffffull,
                                     0x8000000000000000ull,
                                     0x7ff0000000000001ull,
                                     ~0ull};
  for (const Overload& o : stdlib::overloads()) {
    const std::size_t n = o.spec->param_count;
    for (std::size_t shift = 0; shift < std::size(kPatterns); ++shift) {
      std::vector<Value> args;
      for (std::size_t i = 0; i < n; ++i) {
        args.emplace_back(o.param_type(i));
        if (args.back().is_string()) {
          args.back().assign(args.back().type == TypeId::kString ? "'12'" : "\"12\"");
        } else if (args.back().type == TypeId::kBool) {
          args.back().set_bits(kPatterns[(shift + i) % std::size(kPatterns)] & 1);
        } else {
          args.back().set_bits(kPatterns[(shift + i * 3) % std::size(kPatterns)]);
        }
      }
      Value result(o.result_type());
      const Event event = call(o, result, args);
      EXPECT_TRUE(o.spec->events.contains(event)) << stdlib::key_of(o) << ": " << stdlib::event_name(event);
      if (o.result_type() == TypeId::kBool) {
        EXPECT_LE(result.bits(), 1u) << stdlib::key_of(o);
      }
    }
  }
}

/// Results may overwrite an argument: the result is what it is in separate memory.
TEST(Library, ResultMayBeAnyArgument) {
  for (const Overload& o : stdlib::overloads()) {
    const std::size_t n = o.spec->param_count;
    const auto fresh = [&] {
      std::vector<Value> args;
      for (std::size_t i = 0; i < n; ++i) {
        args.emplace_back(o.param_type(i));
        if (args.back().is_string()) {
          args.back().assign(i == 0 ? "'abcdef'" : "'XY'");
        } else {
          args.back().set_bits(args.back().type == TypeId::kBool ? 1 : i + 2);
        }
      }
      return args;
    };
    Value expected(o.result_type());
    const Event event = call(o, expected, fresh());
    for (std::size_t i = 0; i < n; ++i) {
      if (o.param_type(i) != o.result_type()) continue;
      auto args = fresh();
      std::vector<const void*> places;
      for (const Value& arg : args) places.push_back(arg.bytes);
      EXPECT_EQ(o.kernel(args[i].bytes, places.data(), static_cast<std::uint32_t>(n)), event) << stdlib::key_of(o);
      EXPECT_TRUE(args[i].same_as(expected)) << stdlib::key_of(o) << " argument " << i;
    }
  }
}

}  // namespace
}  // namespace plc::test
