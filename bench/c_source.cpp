// Plain arrays, blocks as structures and inline functions.
#include "bench/c_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

namespace plc::bench {
namespace {

constexpr std::size_t kFunctionsPerFile = 4;
constexpr const char* kArrays[kTypes] = {"m", "d", "r"};
constexpr const char* kCTypes[kTypes] = {"unsigned char", "int", "float"};
constexpr const char* kBoxArrays[kBoxes] = {"", "ton", "tof", "tp", "ctu", "ctd", "rtrig"};
constexpr const char* kFunctions[] = {"add", "sub", "mul", "min", "max", "limit", "sel"};

constexpr const char* kPrelude = R"(#ifndef PLC_PRELUDE
#define PLC_PRELUDE
#ifndef BARRIER
#define BARRIER __asm__ volatile("" ::: "memory");
#endif
typedef unsigned char boolean;

enum { IDLE, ARMED, RUNNING, DONE };
struct timer { long long start, et; boolean q, state, last; };
struct counter { short cv; boolean q, last; };
struct edge { boolean q, last; };

static inline boolean ton_step(struct timer *t, boolean in, long long pt, long long now) {
  if (!in) {
    t->state = IDLE;
    t->et = 0;
    return t->q = 0;
  }
  if (t->state == IDLE) {
    t->state = RUNNING;
    t->start = now;
  }
  if (t->state == RUNNING) {
    t->et = now - t->start;
    if (t->et >= pt) {
      t->et = pt;
      t->state = DONE;
      t->q = 1;
    }
  }
  return t->q;
}
static inline boolean tof_step(struct timer *t, boolean in, long long pt, long long now) {
  if (in) {
    t->state = ARMED;
    t->et = 0;
    return t->q = 1;
  }
  if (t->state == ARMED) {
    t->state = RUNNING;
    t->start = now;
  }
  if (t->state == RUNNING) {
    t->et = now - t->start;
    if (t->et >= pt) {
      t->et = pt;
      t->state = DONE;
      t->q = 0;
    }
  }
  return t->q;
}
static inline boolean tp_step(struct timer *t, boolean in, long long pt, long long now) {
  if (in && !t->last && t->state != RUNNING) {
    t->state = RUNNING;
    t->start = now;
    t->q = 1;
  }
  t->last = in;
  if (t->state == RUNNING) {
    t->et = now - t->start;
    if (t->et >= pt) {
      t->et = pt;
      t->state = DONE;
      t->q = 0;
    }
  }
  if (t->state == DONE && !in) {
    t->state = IDLE;
    t->et = 0;
  }
  return t->q;
}
static inline boolean ctu_step(struct counter *c, boolean cu, boolean r, short pv) {
  if (r) c->cv = 0;
  else if (cu && !c->last && c->cv < 32767) ++c->cv;
  c->last = cu;
  return c->q = c->cv >= pv;
}
static inline boolean ctd_step(struct counter *c, boolean cd, boolean ld, short pv) {
  if (ld) c->cv = pv;
  else if (cd && !c->last && c->cv > -32768) --c->cv;
  c->last = cd;
  return c->q = c->cv <= 0;
}
static inline boolean rtrig_step(struct edge *e, boolean clk) {
  e->q = clk & (e->last ^ 1);
  e->last = clk;
  return e->q;
}

static inline int add_int(int a, int b) { return (int)((unsigned)a + (unsigned)b); }
static inline int sub_int(int a, int b) { return (int)((unsigned)a - (unsigned)b); }
static inline int mul_int(int a, int b) { return (int)((unsigned)a * (unsigned)b); }
static inline int min_int(int a, int b) { return b < a ? b : a; }
static inline int max_int(int a, int b) { return a < b ? b : a; }
static inline int limit_int(int mn, int in, int mx) { return min_int(max_int(in, mn), mx); }
static inline int sel_int(boolean g, int a, int b) { return g ? b : a; }
static inline float add_float(float a, float b) { return a + b; }
static inline float sub_float(float a, float b) { return a - b; }
static inline float mul_float(float a, float b) { return a * b; }
static inline float min_float(float a, float b) { return b < a ? b : a; }
static inline float max_float(float a, float b) { return a < b ? b : a; }
static inline float limit_float(float mn, float in, float mx) { return min_float(max_float(in, mn), mx); }
static inline float sel_float(boolean g, float a, float b) { return g ? b : a; }
#endif
)";

/// WHY fewer with blocks: without barriers gcc takes eight times as long for functions of 500, for as much code.
std::size_t rungs_per_function(const Program& program) {
  const bool boxes =
      std::any_of(std::begin(program.instances), std::end(program.instances), [](auto n) { return n != 0; });
  return boxes ? 100 : 500;
}

const char* box_type(Box box) {
  return is_timer(box) ? "struct timer" : is_counter(box) ? "struct counter" : "struct edge";
}

/// Declares every array that the program has; defines them when `prefix` is empty.
std::string arrays(const Program& program, const char* prefix) {
  std::string out;
  for (std::size_t t = 0; t < kTypes; ++t) {
    const std::uint32_t count = program.variables[t].count;
    if (count != 0) out += fmt::format("{}{} {}[{}];\n", prefix, kCTypes[t], kArrays[t], count);
  }
  for (std::size_t b = 1; b < kBoxes; ++b) {
    const std::uint32_t count = program.instances[b];
    if (count != 0) out += fmt::format("{}{} {}[{}];\n", prefix, box_type(static_cast<Box>(b)), kBoxArrays[b], count);
  }
  return out;
}

void write_net(const Net& net, std::string& out) {
  if (net.kind == Net::Kind::kContact) {
    out += c_variable(Type::kBool, net.variable) + (net.negated ? "^1" : "");
    return;
  }
  for (std::size_t i = 0; i < net.children.size(); ++i) {
    if (i != 0) out += net.kind == Net::Kind::kSeries ? " & " : " | ";
    out += '(';
    write_net(net.children[i], out);
    out += ')';
  }
}

void write_rung(const Rung& rung, std::string& out) {
  out += "boolean p = (boolean)(";
  write_net(rung.net, out);
  out += ");";
  if (rung.box != Box::kNone) {
    out += fmt::format(" p = {}_step(&{}, p", kBoxArrays[static_cast<std::size_t>(rung.box)],
                       c_instance(rung.box, rung.instance));
    if (is_timer(rung.box)) out += fmt::format(", {}000000LL, now", rung.preset);
    if (is_counter(rung.box)) out += fmt::format(", {}, {}", c_variable(Type::kBool, rung.reset), rung.preset);
    out += ");";
  }
  constexpr const char* kAssignments[] = {" = p", " = p ^ 1", " |= p", " &= p ^ 1"};
  out += fmt::format(" {}{};", c_variable(Type::kBool, rung.target), kAssignments[static_cast<std::size_t>(rung.coil)]);
}

std::string operand(Type type, const Operand& operand) {
  if (operand.constant.empty()) return c_variable(type, operand.variable);
  return type == Type::kReal ? operand.constant + 'f' : operand.constant;
}

void write_chain(const Chain& chain, std::string& out) {
  const char* type = kCTypes[static_cast<std::size_t>(chain.type)];
  out += fmt::format("{} x = {};", type, operand(chain.type, chain.start));
  for (std::size_t i = 0; i < chain.links.size(); ++i) {
    const Link& link = chain.links[i];
    const std::string function = fmt::format("{}_{}", kFunctions[static_cast<std::size_t>(link.function)], type);
    const std::string second = operand(chain.type, link.operand);
    if (link.function == Function::kLimit) {
      out += fmt::format(" x = {}({}, x, {});", function, second, operand(chain.type, link.maximum));
    } else if (link.function == Function::kSel) {
      out += fmt::format(" x = {}({}, x, {});", function, c_variable(Type::kBool, link.gate), second);
    } else {
      out += fmt::format(" x = {}(x, {});", function, second);
    }
    if (i == chain.kept_at) out += fmt::format(" {} = x;", c_variable(chain.type, chain.kept));
  }
  out += fmt::format(" {} = x;", c_variable(chain.type, chain.target));
}

}  // namespace

std::string c_variable(Type type, std::uint32_t variable) {
  return fmt::format("{}[{}]", kArrays[static_cast<std::size_t>(type)], variable);
}

std::string c_instance(Box box, std::uint32_t instance) {
  return fmt::format("{}[{}]", kBoxArrays[static_cast<std::size_t>(box)], instance);
}

std::vector<std::string> write_c(const Program& program) {
  const std::string head = kPrelude + arrays(program, "extern ");
  std::vector<std::string> files;
  std::string calls;
  const std::size_t many = rungs_per_function(program);
  for (std::size_t first = 0; first < program.rungs.size(); first += many) {
    const std::size_t function = first / many;
    if (function % kFunctionsPerFile == 0) files.push_back(head);
    std::string& out = files.back();
    out += fmt::format("void rungs_{}(long long now) {{\n  (void)now;\n", function);
    for (std::size_t i = first; i < std::min(first + many, program.rungs.size()); ++i) {
      out += "  { ";
      if (const auto* rung = std::get_if<Rung>(&program.rungs[i])) write_rung(*rung, out);
      if (const auto* chain = std::get_if<Chain>(&program.rungs[i])) write_chain(*chain, out);
      out += " } BARRIER\n";
    }
    out += "}\n";
    calls += fmt::format("  rungs_{}(now);\n", function);
  }
  std::string out = head + arrays(program, "");
  for (std::size_t i = 0; i < (program.rungs.size() + many - 1) / many; ++i) {
    out += fmt::format("void rungs_{}(long long now);\n", i);
  }
  files.push_back(out + "void plc_scan(long long now) {\n" + calls + "}\n");
  return files;
}

}  // namespace plc::bench
