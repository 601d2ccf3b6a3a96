#include "bytecode/codegen/generate.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "bytecode/codegen/body.h"
#include "bytecode/codegen/tasks.h"

namespace plc::bytecode {
namespace {

using core::Code;

constexpr const char* kProduct = "PICARD 0.1.0";

/// POUs that any task reaches, callees before callers.
std::vector<std::uint32_t> reached(const ir::Module& module) {
  std::vector<std::uint32_t> order;
  std::vector<bool> seen(module.pous.size());
  for (const ir::Task& task : module.tasks) {
    for (const std::uint32_t pou : ir::reached_pous(module, task)) {
      if (!seen[pou] && module.pous[pou].taskblock == 0) order.push_back(pou);
      seen[pou] = true;
    }
  }
  return order;
}

/// Reports POUs whose calls nest deeper than an image may. `order` has callees first.
bool check_depth(const ir::Module& module, const std::vector<std::uint32_t>& order, core::Diagnostics& diagnostics) {
  std::vector<std::uint32_t> depth(module.pous.size());
  for (const std::uint32_t pou : order) {
    for (const std::uint32_t callee : ir::callees(module, pou)) depth[pou] = std::max(depth[pou], depth[callee]);
    ++depth[pou];
    // The task's own body is the first level.
    if (depth[pou] < kMaxCallDepth) continue;
    diagnostics.report(Code::P5002, module.pous[pou].at, module.pous[pou].name,
                       fmt::format("calls from {} nest deeper than {}", module.pous[pou].name, kMaxCallDepth),
                       "flatten the chain of calls");
    return false;
  }
  return true;
}

PouKind kind_of(ir::PouKind kind) {
  switch (kind) {
    case ir::PouKind::kProgram:
      return PouKind::kProgram;
    case ir::PouKind::kFunctionBlock:
      return PouKind::kFunctionBlock;
    case ir::PouKind::kFunction:
      break;
  }
  return PouKind::kFunction;
}

/// One map for each POU; texts that are among the constants have the types that those got.
void complete_probes(Image& image) {
  image.probes.resize(image.pous.size());
  for (PouProbes& probes : image.probes) {
    for (ProbeStep& step : probes.steps) {
      if (step.op != ProbeOp::kCapture || space_of(step.a) != Space::kConst) continue;
      step.type = leaf_at(image, image.const_type, offset_of(step.a)).value_or(kNoProbeType);
    }
  }
}

void name_files(Image& image, const core::Diagnostics& diagnostics) {
  std::size_t files = 0;
  for (const ImagePou& pou : image.pous) {
    for (const DebugEntry& entry : pou.debug) files = std::max<std::size_t>(files, std::size_t{entry.at.file} + 1);
  }
  for (std::size_t f = 0; f < files; ++f) {
    image.files.push_back(f < diagnostics.file_count() ? diagnostics.file_name(static_cast<std::uint16_t>(f)) : "");
  }
}

}  // namespace

std::optional<Image> generate(const ir::Module& module, core::Diagnostics& diagnostics) {
  const std::vector<std::uint32_t> order = reached(module);
  if (!check_depth(module, order, diagnostics)) return std::nullopt;
  const auto too_large = [&](std::string what) {
    diagnostics.report(Code::P5001, {}, "", fmt::format("{} takes more than {} bytes", what, kMaxTableBytes),
                       "make arrays and strings shorter");
    return std::nullopt;
  };

  Image image;
  image.options = module.options;
  image.project = module.name;
  image.product = kProduct;
  Layout layout(module, image);
  ConstantPool constants(image, layout);
  Shared shared{module, image, layout, constants, {}, {}, {}, {}, {}, {}};
  shared.image_pou.assign(module.pous.size(), kNoIndex);
  for (std::uint32_t i = 0; i < order.size(); ++i) shared.image_pou[order[i]] = i;

  const GlobalPlan plan = plan_globals(module, module.options.coherence);
  lay_out_globals(shared, plan);
  if (image.types[image.global_type].size >= kMaxTableBytes || layout.too_large()) return too_large("the global table");

  if (!lay_out_queues(shared)) return too_large("a queue");

  image.pous.resize(order.size());
  if (module.probes) image.probes.resize(order.size());
  PouProbes unused;
  for (std::size_t i = 0; i < order.size(); ++i) {
    const ir::Pou& pou = module.pous[order[i]];
    ImagePou& out = image.pous[i];
    out.name = pou.name;
    // An action is called like a function block, on an instance of its owner.
    out.kind = pou.owner == ir::Pou::kDeclared ? kind_of(pou.kind) : PouKind::kFunctionBlock;
    out.instance_type = layout.pou(order[i]).instance_type;
    if (layout.too_large()) return too_large("an instance of " + pou.name);
    out.instance_initial = layout.instance_initial(order[i]);
    if (!generate_body(shared, order[i], out, module.probes ? image.probes[i] : unused) || layout.too_large())
      return too_large("the frame of " + pou.name);
  }
  generate_tasks(shared, plan);
  for (const ImageTask& task : image.tasks) {
    const ImagePou& body = image.pous[task.body];
    if (body.instance_initial.size() != image.types[body.instance_type].size) return too_large("task " + task.name);
  }
  layout.finish();
  if (layout.too_large()) return too_large("a variable");
  if (!constants.finish()) return too_large("the table of constants");
  if (module.probes) complete_probes(image);
  name_files(image, diagnostics);
  return image;
}

}  // namespace plc::bytecode
