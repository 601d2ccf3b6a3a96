// What a block of a drawn body is: an EXECUTE box, a function, an instance, or missing.
#include "frontend-fbd/block_lowering.h"
#include "frontend-st/foreign.h"
#include "frontend-st/suggestions.h"

namespace plc::fbd {

void BlockLowering::lower_execute() {
  if (!read_enable()) return poison();
  open(true);
  const bool good = st::lower_statements(e.code, e.code_at, b);
  close();
  if (!good) return poison();
  publish_eno();
  const ValueId value = d.has_reader(eno()) || !watch_events ? (watch_events ? b.load(eno_place)
                                                                : enable     ? *enable
                                                                             : b.constant_bool(true))
                                                             : b.constant_bool(true);
  for (std::uint16_t i = 0; i < e.outputs.size(); ++i) {
    if (d.has_reader({OutRef::Kind::kPin, i, node})) {
      d.publish({OutRef::Kind::kPin, i, node}, modified(e.outputs[i], value));
    }
  }
}

void BlockLowering::lower() {
  if (e.has_code) return lower_execute();
  if (d.is_missing(e)) return missing();
  if (const auto call = named_call(b, e)) return lower_named(*call);
  ir::Module& module = b.module();
  const auto pou = module.pou_by_name.find(e.text);
  const bool is_function = pou != module.pou_by_name.end() && module.pous[pou->second].kind == ir::PouKind::kFunction;
  const bool is_block = (pou != module.pou_by_name.end() && !is_function) || stdlib::block_named(e.text) != nullptr;
  if (is_function) return lower_function_pou(pou->second);
  if (is_block) return lower_block_instance();
  if (is_delay(e)) return lower_delay();
  if (const auto bound = ir::array_bound_named(e.text)) return lower_array_bound(*bound);
  if (const auto queue = ir::queue_function_named(e.text)) return lower_queue_function(*queue);
  if (const stdlib::BundleSpec* bundle = stdlib::bundle_named(e.text)) return lower_bundle(*bundle);
  lower_standard_function();
}

void BlockLowering::lower_block_instance() {
  if (e.instance_name.empty()) {
    b.report(Code::P3009, e.at, "function block " + e.text + " has no instance name",
             "declare a variable of type " + e.text + " and put its name above the block");
    return poison();
  }
  const auto instance = st::lower_place(e.instance_name, e.at, b, false);
  if (!instance) return poison();
  const auto wanted = b.module().types.find(e.text);
  const ir::TypeRef found = b.type_of(*instance);
  if (!wanted || *wanted != found) {
    if (b.module().types[found].stub) return poison();
    b.report(
        Code::P3024, e.at,
        "block is a " + e.text + ", but \"" + e.instance_name + "\" is declared as " + b.module().types.name_of(found),
        "declare the instance with the type of the block");
    return poison();
  }
  const ir::Type& type = b.module().types[found];
  if (type.kind == ir::TypeKind::kPou && !b.module().pous[type.pou].refused.empty()) return poison();
  lower_instance(*instance);
}

void BlockLowering::lower_named(const NamedCall& call) {
  const auto instance =
      call.instance.empty() ? std::optional(b.self()) : st::lower_place(call.instance, e.at, b, false);
  if (!instance) return poison();
  const ir::Type& type = b.module().types[b.type_of(*instance)];
  if (type.kind == ir::TypeKind::kPou && !b.module().pous[type.pou].refused.empty()) return poison();
  lower_instance(*instance, call.action);
}

void BlockLowering::missing() {
  if (e.text.empty()) return poison();  // the reader said so
  if (b.is_broken(e.text, e.at)) return poison();
  const std::string_view who = st::supplier_of(e.text);
  const std::string supply =
      (who.empty() ? "" : std::string(who) + " brings it: ") +
      "it is neither in this file nor in the standard library: export it with the project, or name the file (--lib) "
      "or, for a component, the configuration (--config plc.toml) that has it";
  if (d.options_.stub_missing) {
    b.pou().partial = true;
    b.report(Code::P3020, e.at, "block " + title() + " is missing and replaced by a stub that does nothing", supply);
  } else {
    const std::string meant = st::block_meant(b.module(), e.text);
    b.report(Code::P3008, e.at, "block " + title() + " is not known",
             (meant.empty() ? "" : meant + " ") + supply + "; --stub-missing runs the rest without it");
  }
  poison();
}

void Drawing::lower_block(NodeId node) { BlockLowering(*this, node).lower(); }

}  // namespace plc::fbd
