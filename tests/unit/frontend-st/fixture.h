// Builds small projects in memory, lowers texts in them and runs the resulting IR on plain 64-bit cells. Enough to
// check what a text means; it is not the machine (scalars only, no instances).
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "core/text.h"
#include "declare/declare.h"
#include "frontend-st/literals.h"
#include "frontend-st/text.h"
#include "ir/builder.h"
#include "ir/check.h"
#include "plcopen/project.h"

namespace plc::st::test {

using plcopen::InitialValue;
using plcopen::Section;
using plcopen::TypeSpec;

inline core::SourceRef at_line(std::uint32_t line, std::uint32_t column = 1) {
  core::SourceRef at;
  at.line = line;
  at.column = column;
  return at;
}

inline TypeSpec named(std::string name) {
  TypeSpec spec;
  spec.kind = TypeSpec::Kind::kNamed;
  spec.name = std::move(name);
  return spec;
}
inline TypeSpec array_of(TypeSpec element, std::vector<plcopen::Dimension> dimensions) {
  TypeSpec spec;
  spec.kind = TypeSpec::Kind::kArray;
  spec.dimensions = std::move(dimensions);
  spec.base = std::make_shared<TypeSpec>(std::move(element));
  return spec;
}
inline TypeSpec pointer_to(TypeSpec target) {
  TypeSpec spec;
  spec.kind = TypeSpec::Kind::kPointer;
  spec.base = std::make_shared<TypeSpec>(std::move(target));
  return spec;
}
inline TypeSpec subrange(std::string base, std::string lower, std::string upper) {
  TypeSpec spec;
  spec.kind = TypeSpec::Kind::kSubrange;
  spec.base = std::make_shared<TypeSpec>(named(std::move(base)));
  spec.dimensions = {{std::move(lower), std::move(upper)}};
  return spec;
}
inline TypeSpec enumeration(std::vector<std::pair<std::string, std::string>> values) {
  TypeSpec spec;
  spec.kind = TypeSpec::Kind::kEnum;
  for (auto& [name, value] : values) spec.values.push_back({name, value, {}});
  return spec;
}
inline TypeSpec string_of(std::string length) {
  TypeSpec spec;
  spec.kind = TypeSpec::Kind::kString;
  spec.name = "STRING";
  spec.length = std::move(length);
  return spec;
}
inline InitialValue simple(std::string text) {
  InitialValue value;
  value.kind = InitialValue::Kind::kSimple;
  value.text = std::move(text);
  return value;
}
inline InitialValue repeated(std::string count, InitialValue value) {
  value.repetition = std::move(count);
  return value;
}
inline InitialValue list(std::vector<InitialValue> values) {
  InitialValue value;
  value.kind = InitialValue::Kind::kArray;
  value.values = std::move(values);
  return value;
}
inline InitialValue members(std::vector<std::pair<std::string, InitialValue>> values) {
  InitialValue value;
  value.kind = InitialValue::Kind::kStruct;
  for (auto& [name, one] : values) {
    one.member = name;
    value.values.push_back(one);
  }
  return value;
}
inline plcopen::Variable variable(std::string name, TypeSpec type, Section section = Section::kLocal,
                                  InitialValue initial = {}) {
  plcopen::Variable v;
  v.name = std::move(name);
  v.type = std::move(type);
  v.section = section;
  v.initial = std::move(initial);
  return v;
}
inline plcopen::Variable located(std::string name, TypeSpec type, std::string address) {
  plcopen::Variable v = variable(std::move(name), std::move(type));
  v.address = std::move(address);
  return v;
}
inline TypeSpec structure(std::vector<plcopen::Variable> fields) {
  TypeSpec spec;
  spec.kind = TypeSpec::Kind::kStruct;
  spec.members = std::move(fields);
  return spec;
}
inline plcopen::Pou pou(std::string name, plcopen::PouKind kind, std::vector<plcopen::Variable> variables) {
  plcopen::Pou p;
  p.name = std::move(name);
  p.kind = kind;
  p.variables = std::move(variables);
  return p;
}
inline plcopen::DataType data_type(std::string name, TypeSpec type, InitialValue initial = {}) {
  plcopen::DataType t;
  t.name = std::move(name);
  t.type = std::move(type);
  t.initial = std::move(initial);
  return t;
}

/// A project under construction with one configuration and one resource.
struct World {
  plcopen::Project project;
  core::CompileOptions options;
  core::Diagnostics diagnostics;
  std::unique_ptr<ir::Module> module;

  World() {
    diagnostics.add_file("test.xml");
    project.configurations.emplace_back();
    project.configurations[0].resources.emplace_back();
  }
  plcopen::Configuration& configuration() { return project.configurations[0]; }
  plcopen::Resource& resource() { return project.configurations[0].resources[0]; }
  World& program(std::string name, std::vector<plcopen::Variable> variables) {
    project.pous.push_back(pou(std::move(name), plcopen::PouKind::kProgram, std::move(variables)));
    return *this;
  }
  /// Declares; afterwards only what later texts report is in `diagnostics`, if `quiet`.
  ir::Module& declare_all() {
    module = declare(project, options, diagnostics);
    return *module;
  }
  ir::Module& declare_cleanly() {
    declare_all();
    EXPECT_EQ(diagnostics.error_count(), 0u) << rendered();
    return *module;
  }
  [[nodiscard]] std::string rendered() const {
    std::ostringstream out;
    diagnostics.render(out);
    return out.str();
  }
  [[nodiscard]] std::size_t count(core::Code code) const {
    std::size_t n = 0;
    for (const auto& d : diagnostics.all()) n += d.code == code ? 1u : 0u;
    return n;
  }
  [[nodiscard]] const core::Diagnostic* first(core::Code code) const {
    for (const auto& d : diagnostics.all()) {
      if (d.code == code) return &d;
    }
    return nullptr;
  }
};

/// Runs a body. Cells are named by path: "x", "a[0]", "p.1" (field number), "global:X".
class Machine {
 public:
  Machine(const ir::Module& module, const ir::Pou& pou) : module_(module), pou_(pou) {}
  std::map<std::string, std::uint64_t> cells;
  std::vector<std::string> runs;  ///< instances run, in order

  void run() {
    const ir::Body& body = pou_.body;
    values_.assign(body.insts.size(), {});
    bool event = false;
    for (std::size_t i = 0; i < body.insts.size(); ++i) {
      const ir::Inst& inst = body.insts[i];
      Value& out = values_[i];
      switch (inst.op) {
        case ir::Op::kConst:
          out.bits = body.constants[inst.a].bits;
          break;
        case ir::Op::kLoad: {
          const std::string path = path_of({inst.a});
          out.bits = cells[path];
          out.path = references_[path];
          break;
        }
        case ir::Op::kStore: {
          const std::string path = path_of({inst.a});
          cells[path] = values_[inst.b].bits;
          references_[path] = values_[inst.b].path;
          break;
        }
        case ir::Op::kAnd:
          out.bits = values_[inst.a].bits & values_[inst.b].bits;
          break;
        case ir::Op::kOr:
          out.bits = values_[inst.a].bits | values_[inst.b].bits;
          break;
        case ir::Op::kXor:
          out.bits = values_[inst.a].bits ^ values_[inst.b].bits;
          break;
        case ir::Op::kNot:
          out.bits = values_[inst.a].bits ^ 1u;
          break;
        case ir::Op::kCall: {
          const stdlib::Overload& overload = *body.functions[inst.a];
          std::vector<const void*> args;
          for (std::uint32_t k = 0; k < inst.count; ++k) args.push_back(&values_[body.args[inst.b + k].index].bits);
          std::uint64_t result = 0;
          event = overload.kernel(&result, args.data(), inst.count) != stdlib::Event::kNone || event;
          out.bits = truncate_bits(result, core::rep_of(overload.result_type()));
          break;
        }
        case ir::Op::kRun:
          runs.push_back(path_of({inst.a}));
          break;
        case ir::Op::kJump:
          i = label(inst.a);
          break;
        case ir::Op::kJumpIf:
          if (values_[inst.b].bits != 0) i = label(inst.a);
          break;
        case ir::Op::kJumpIfNot:
          if (values_[inst.b].bits == 0) i = label(inst.a);
          break;
        case ir::Op::kReturn:
          return;
        case ir::Op::kClearEvent:
          event = false;
          break;
        case ir::Op::kEno:
          out.bits = event ? 0 : 1;
          break;
        case ir::Op::kMakeRef:
          out.path = path_of({inst.a});
          break;
        case ir::Op::kSameRef:
          out.bits = values_[inst.a].path == values_[inst.b].path ? 1 : 0;
          break;
        case ir::Op::kExtract: {
          const unsigned width = width_of(inst.type);
          out.bits = (values_[inst.a].bits >> inst.b) & ((std::uint64_t{1} << width) - 1);
          break;
        }
        case ir::Op::kInsert: {
          const unsigned width = width_of(body.insts[inst.b].type);
          const std::uint64_t mask = ((std::uint64_t{1} << width) - 1) << inst.count;
          out.bits = (values_[inst.a].bits & ~mask) | (values_[inst.b].bits << inst.count & mask);
          break;
        }
        case ir::Op::kRange: {
          const ir::Type& limits = module_.types[inst.type];
          const auto rep = core::rep_of(limits.elementary);
          const std::int64_t value = signed_value(values_[inst.a].bits, rep);
          const std::int64_t held = std::clamp(value, limits.lower, limits.upper);
          event = event || held != value;
          out.bits = truncate_bits(static_cast<std::uint64_t>(held), rep);
          break;
        }
        case ir::Op::kLabel:
          break;
        case ir::Op::kCopy:
        case ir::Op::kCallPou:
        case ir::Op::kAddress:
        case ir::Op::kPointerRef:
        case ir::Op::kPointerTo32:
        case ir::Op::kPointerFrom32:
          ADD_FAILURE() << "not in this machine";
          return;
      }
    }
  }
  [[nodiscard]] std::uint64_t bits_of(ir::ValueId value) const { return values_[value.index].bits; }
  std::string path_of(ir::PlaceId id) const {
    const ir::Place& place = pou_.body.places[id.index];
    switch (place.kind) {
      case ir::Place::Kind::kGlobal:
        return "global:" + module_.globals[place.index].variable.name;
      case ir::Place::Kind::kInstance:
      case ir::Place::Kind::kFrame:
        return pou_.variables[place.index].name;
      case ir::Place::Kind::kDeref:
        return values_[place.index].path;
      case ir::Place::Kind::kField:
        return path_of(place.parent) + "." + std::to_string(place.index);
      case ir::Place::Kind::kElement:
        return path_of(place.parent) + "[" + std::to_string(place.index) + "]";
      case ir::Place::Kind::kSelf:
        return "self";
      case ir::Place::Kind::kPart:
      case ir::Place::Kind::kCharacter:
        break;
      case ir::Place::Kind::kElementAt: {
        const ir::Type& array = module_.types[pou_.body.places[place.parent.index].type];
        const auto rep = module_.types.rep_of(pou_.body.insts[place.index].type);
        const std::int64_t index = signed_value(values_[place.index].bits, *rep) - array.lower;
        return path_of(place.parent) + "[" + std::to_string(index) + "]";
      }
    }
    return {};
  }

 private:
  struct Value {
    std::uint64_t bits = 0;
    std::string path;
  };
  [[nodiscard]] unsigned width_of(ir::TypeRef type) const {
    const auto rep = *module_.types.rep_of(type);
    return rep == core::Rep::kBool ? 1 : core::rep_bytes(rep) * 8;
  }
  [[nodiscard]] std::size_t label(std::uint32_t wanted) const {
    for (std::size_t i = 0; i < pou_.body.insts.size(); ++i) {
      if (pou_.body.insts[i].op == ir::Op::kLabel && pou_.body.insts[i].a == wanted) return i;
    }
    ADD_FAILURE() << "label " << wanted << " is not bound";
    return pou_.body.insts.size();
  }
  const ir::Module& module_;
  const ir::Pou& pou_;
  std::vector<Value> values_;
  std::map<std::string, std::string> references_;
};

}  // namespace plc::st::test
