// Random POUs and the whole program, and its two texts.
#include <fmt/format.h>

#include <algorithm>

#include "tests/programs/generator.h"

namespace plc::programs {
namespace {

/// Globals hold numbers: they are read as text (comparison.cpp), and a reference means nothing outside of its task.
bool is_plain_data(const Type& type) {
  if (type.kind == Kind::kArray) return is_plain_data(*type.base);
  return type.kind != Kind::kRef && type.kind != Kind::kPointer && type.kind != Kind::kString &&
         type.kind != Kind::kBlock && std::all_of(type.members.begin(), type.members.end(), [](const Variable& v) {
           return is_plain_data(*v.type);
         });
}

void print(const std::vector<Stmt>& body, bool st, int indent, std::string& out) {
  bool any = false;
  for (const Stmt& statement : body) {
    if (statement.dropped) continue;
    any = true;
    for (const Part& part : statement.parts) {
      if (part.is_block) {
        print(part.block, st, indent + 1, out);
      } else if (st) {
        out.append(static_cast<std::size_t>(indent) * 2, ' ');
        out += part.st;
      } else {
        out += part.c;
      }
    }
  }
  if (!any && st) out.append(static_cast<std::size_t>(indent) * 2, ' ').append(";\n");
}

void list(std::vector<Stmt>& body, std::vector<Stmt*>& out) {
  for (Stmt& statement : body) {
    if (statement.dropped) continue;
    out.push_back(&statement);
    for (Part& part : statement.parts) list(part.block, out);
  }
}

}  // namespace

void Generator::open_pou(PouKind kind, const std::string& prefix) {
  program_.pous.push_back(std::make_unique<Pou>());
  pou_ = program_.pous.back().get();
  pou_->kind = kind;
  pou_->name = fresh(prefix.c_str());
  pou_->cost = 1;
  scope_.clear();
  loops_.clear();
  factor_ = 1;
}

void Generator::use_globals() {
  pou_->uses_globals = true;
  for (const Variable& global : program_.globals) {
    scope_.push_back({global.name, "g_" + global.name, global.type, true, false, false});
  }
}

void Generator::add_variable(Variable variable) {
  const bool in_instance = pou_->kind != PouKind::kFunction && variable.role != Role::kTemp;
  const bool in_out = variable.role == Role::kInOut;
  scope_.push_back({variable.name, (in_instance ? "self->" : "") + variable.name, variable.type,
                    variable.role != Role::kInput, in_out, in_instance && !in_out});
  pou_->variables.push_back(std::move(variable));
}

void Generator::parameters(bool is_block) {
  const auto value_type = [&]() -> const Type& {
    for (;;) {
      const Type& type = random_type();
      if (!holds_instance(type)) return type;
    }
  };
  for (std::int64_t i = random_.between(0, 3); i > 0; --i) {
    Variable variable;
    variable.name = fresh("a");
    variable.type = &value_type();
    variable.role = Role::kInput;
    if (random_.chance(40)) initial_value(variable);
    add_variable(std::move(variable));
  }
  for (std::int64_t i = random_.between(0, 2); i > 0; --i) {
    Variable variable;
    variable.name = fresh("io");
    variable.type = &random_type();
    variable.role = Role::kInOut;
    add_variable(std::move(variable));
  }
  for (std::int64_t i = random_.between(is_block ? 1 : 0, 2); i > 0; --i) {
    Variable variable;
    variable.name = fresh("q");
    variable.type = &value_type();
    variable.role = Role::kOutput;
    if (random_.chance(30)) initial_value(variable);
    add_variable(std::move(variable));
  }
}

void Generator::locals(int count) {
  for (int i = 0; i < count; ++i) {
    Variable variable;
    variable.name = fresh("v");
    do {
      variable.type = &random_type();
    } while (pou_->kind == PouKind::kFunction && holds_instance(*variable.type));
    if (pou_->kind != PouKind::kFunction && !holds_instance(*variable.type) && random_.chance(20)) {
      variable.role = Role::kTemp;
    }
    if (random_.chance(50)) initial_value(variable);
    add_variable(std::move(variable));
  }
}

void Generator::make_function() {
  open_pou(PouKind::kFunction, "F");
  do {
    pou_->result = &random_type();
  } while (holds_instance(*pou_->result) || pou_->result->kind == Kind::kSubrange ||
           pou_->result->kind == Kind::kString);
  parameters(false);
  scope_.push_back({pou_->name, "result_", pou_->result, true, false, false});
  locals(static_cast<int>(random_.between(1, 4)));
  pou_->body = statements(2, static_cast<int>(random_.between(2, 6)));
}

void Generator::make_block() {
  open_pou(PouKind::kBlock, "FB");
  if (random_.chance(40)) use_globals();
  parameters(true);
  locals(static_cast<int>(random_.between(2, 5)));
  for (const auto& pou : program_.pous) {
    if (pou->kind != PouKind::kBlock || pou.get() == pou_ || !random_.chance(40)) continue;
    Variable variable;
    variable.name = fresh("fb");
    variable.type = pou->instance;
    add_variable(std::move(variable));
  }
  pou_->body = statements(2, static_cast<int>(random_.between(3, 8)));
  finish_block_type();
}

/// The instance as a C structure; the compiler lays it out itself.
void Generator::finish_block_type() {
  Type type;
  type.kind = Kind::kBlock;
  type.st = pou_->name;
  type.c = pou_->name + "_t";
  std::string init;
  type.declaration_c = "typedef struct {\n";
  for (const Variable& variable : pou_->variables) {
    if (variable.role == Role::kTemp) continue;
    const bool in_out = variable.role == Role::kInOut;
    type.declaration_c += fmt::format("{}{} {};\n", variable.type->c, in_out ? "*" : "", variable.name);
    init += in_out ? fmt::format("p->{} = 0;\n", variable.name) : initialisation(variable, "p->" + variable.name);
    type.members.push_back(variable);
  }
  type.declaration_c += fmt::format("char none;\n}} {0};\nstatic void init_{0}({0}* p) {{\n{1}}}\n", type.c, init);
  const Type* added = add(std::move(type));
  pou_->instance = added;
  if (pou_->kind == PouKind::kProgram) return;
  if (random_.chance(60)) array_of(*added, 1);
  if (random_.chance(50)) structure({added, &random_scalar()}, "Cell");
}

void Generator::make_program() {
  open_pou(PouKind::kProgram, "Main");
  use_globals();
  std::size_t first_input = pou_->variables.size();
  for (const Type* type : scalars_) {
    if (type->kind == Kind::kRef || !random_.chance(60)) continue;
    Variable variable;
    variable.name = fresh("in");
    variable.type = type;
    add_variable(std::move(variable));
  }
  const std::size_t inputs = pou_->variables.size();
  locals(12);
  for (const Type* type : aggregates_) {
    if (!random_.chance(60)) continue;
    Variable variable;
    variable.name = fresh("v");
    variable.type = type;
    if (random_.chance(50)) initial_value(variable);
    add_variable(std::move(variable));
  }
  for (const Type* type : scalars_) {
    if (type->kind != Kind::kRef) continue;
    Variable variable;
    variable.name = fresh("r");
    variable.type = type;
    add_variable(std::move(variable));
  }
  for (const auto& pou : program_.pous) {
    if (pou->kind != PouKind::kBlock) continue;
    Variable variable;
    variable.name = fresh("fb");
    variable.type = pou->instance;
    add_variable(std::move(variable));
  }
  pou_->body = statements(3, 25);
  for (std::size_t i = 0; i < pou_->variables.size(); ++i) {
    const Variable& variable = pou_->variables[i];
    if (variable.role == Role::kTemp) continue;
    collect_leaves("P." + variable.name, "main_." + variable.name, *variable.type, i >= first_input && i < inputs);
  }
  for (const Variable& global : program_.globals) {
    collect_leaves(global.name, "g_" + global.name, *global.type, false);
  }
  finish_block_type();
}

void Generator::collect_leaves(const std::string& path, const std::string& c, const Type& type, bool input) {
  switch (type.kind) {
    case Kind::kRef:
    case Kind::kPointer:
      return;
    case Kind::kArray: {
      std::vector<std::int64_t> at;
      for (const auto& bound : type.bounds) at.push_back(bound.first);
      for (;;) {
        std::string indices, element = c + ".e";
        for (std::size_t i = 0; i < at.size(); ++i) {
          indices += fmt::format("{}{}", i == 0 ? "" : ",", at[i]);
          element += fmt::format("[{}]", at[i] - type.bounds[i].first);
        }
        collect_leaves(fmt::format("{}[{}]", path, indices), element, *type.base, input);
        std::size_t i = at.size();
        while (i > 0 && ++at[i - 1] > type.bounds[i - 1].second) {
          at[i - 1] = type.bounds[i - 1].first;
          --i;
        }
        if (i == 0) return;
      }
    }
    case Kind::kStruct:
    case Kind::kBlock:
      for (const Variable& member : type.members) {
        if (member.role == Role::kInOut || member.role == Role::kTemp) continue;
        collect_leaves(path + "." + member.name, c + "." + member.name, *member.type, input);
      }
      return;
    default:
      program_.leaves.push_back({path, c, &type, input});
  }
}

Program Generator::make() {
  make_types();
  for (std::int64_t i = random_.between(1, 4); i > 0; --i) {
    Variable global;
    global.name = fresh("G");
    do {
      global.type = &random_type();
    } while (!is_plain_data(*global.type));
    if (random_.chance(50)) initial_value(global);
    program_.globals.push_back(std::move(global));
  }
  for (std::int64_t i = random_.between(2, 4); i > 0; --i) make_function();
  for (std::int64_t i = random_.between(1, 3); i > 0; --i) {
    make_block();
    if (random_.chance(40)) make_function();
  }
  make_program();
  return std::move(program_);
}

Program generate(std::uint64_t seed) { return Generator(seed).make(); }

std::vector<Stmt*> Program::statements() {
  std::vector<Stmt*> out;
  for (const auto& pou : pous) list(pou->body, out);
  return out;
}

// ---- texts --------------------------------------------------------------------------------------------------------

std::string Program::st() const {
  std::string out = fmt::format("(* seed {} *)\nTYPE\n", seed);
  for (const auto& type : types) out += type->declaration_st;
  out += "END_TYPE\n";
  for (const auto& pou : pous) {
    const char* word = pou->kind == PouKind::kFunction ? "FUNCTION"
                       : pou->kind == PouKind::kBlock  ? "FUNCTION_BLOCK"
                                                       : "PROGRAM";
    out += fmt::format("\n{} {}{}\n", word, pou->name, pou->result != nullptr ? " : " + pou->result->st : "");
    static constexpr std::pair<Role, const char*> kSections[] = {{Role::kInput, "VAR_INPUT"},
                                                                 {Role::kInOut, "VAR_IN_OUT"},
                                                                 {Role::kOutput, "VAR_OUTPUT"},
                                                                 {Role::kLocal, "VAR"},
                                                                 {Role::kTemp, "VAR_TEMP"}};
    for (const auto& [role, section] : kSections) {
      std::string variables;
      for (const Variable& v : pou->variables) {
        if (v.role != role) continue;
        variables +=
            fmt::format("  {} : {}{};\n", v.name, v.type->st, v.initial_st.empty() ? "" : " := " + v.initial_st);
      }
      if (!variables.empty()) out += fmt::format("{}\n{}END_VAR\n", section, variables);
    }
    if (pou->uses_globals && !globals.empty()) {
      out += "VAR_EXTERNAL\n";
      for (const Variable& v : globals) out += fmt::format("  {} : {};\n", v.name, v.type->st);
      out += "END_VAR\n";
    }
    print(pou->body, true, 0, out);
    out += fmt::format("END_{}\n", word);
  }
  out += "\nCONFIGURATION C\n";
  if (!globals.empty()) {
    out += "VAR_GLOBAL\n";
    for (const Variable& v : globals) {
      out += fmt::format("  {} : {}{};\n", v.name, v.type->st, v.initial_st.empty() ? "" : " := " + v.initial_st);
    }
    out += "END_VAR\n";
  }
  return out + fmt::format(
                   "RESOURCE R ON PLC\n  TASK T(INTERVAL := T#10ms, PRIORITY := 0);\n  PROGRAM P WITH T : {};\n"
                   "END_RESOURCE\nEND_CONFIGURATION\n",
                   pous.back()->name);
}

std::string Program::c(const std::string& prelude) const {
  std::string out = fmt::format("#include \"{}\"\n", prelude);
  for (const auto& type : types) out += type->declaration_c;
  for (const Variable& v : globals) out += fmt::format("static {} g_{};\n", v.type->c, v.name);
  for (const auto& pou : pous) {
    std::string head, locals, ends;
    if (pou->kind == PouKind::kFunction) {
      for (const Variable& v : pou->variables) {
        const char* comma = head.empty() ? "" : ", ";
        if (v.role == Role::kInput) head += fmt::format("{}{} {}", comma, v.type->c, v.name);
        if (v.role == Role::kInOut) head += fmt::format("{}{}* {}", comma, v.type->c, v.name);
        if (v.role == Role::kOutput) {
          head += fmt::format("{}{}* out_{}", comma, v.type->c, v.name);
          ends += fmt::format("*out_{} = {};\n", v.name, v.name);
        }
      }
      if (pou->result != nullptr) {
        locals = fmt::format("{} result_;\n", pou->result->c) + initialisation(*pou->result, "result_");
      }
      out += fmt::format("static {} {}({}) {{\n", pou->result != nullptr ? pou->result->c : "void", pou->name, head);
    } else {
      out += fmt::format("static void {}({}* self) {{\n", pou->name, pou->instance->c);
    }
    for (const Variable& v : pou->variables) {
      const bool is_function = pou->kind == PouKind::kFunction;
      if (v.role == Role::kTemp || (is_function && (v.role == Role::kOutput || v.role == Role::kLocal))) {
        locals += fmt::format("{} {};\n", v.type->c, v.name) + initialisation(v, v.name);
      }
    }
    out += locals;
    print(pou->body, false, 0, out);
    out += "done:;\n" + ends + (pou->result != nullptr ? "return result_;\n" : "") + "}\n";
  }
  const Pou& main = *pous.back();
  out += fmt::format("static {} main_;\nvoid plc_init(void) {{\n{}", main.instance->c,
                     initialisation(*main.instance, "main_"));
  for (const Variable& v : globals) out += initialisation(v, "g_" + v.name);
  out += fmt::format("}}\nvoid plc_scan(void) {{ {}(&main_); }}\n", main.name);
  out += "unsigned long long plc_executed(void) { return executed; }\nvoid* plc_leaf(unsigned i) {\n  switch (i) {\n";
  for (std::size_t i = 0; i < leaves.size(); ++i) out += fmt::format("    case {}: return &{};\n", i, leaves[i].c);
  out += "  }\n  return 0;\n}\n";
  return out;
}

}  // namespace plc::programs
