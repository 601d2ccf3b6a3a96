#include "bytecode/codegen/tasks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <tuple>
#include <unordered_set>
#include <utility>

#include "bytecode/codegen/writer.h"
#include "core/text.h"
#include "ir/queues.h"

namespace plc::bytecode {

GlobalPlan plan_globals(const ir::Module& module, core::Coherence coherence) {
  GlobalPlan plan;
  const std::size_t globals = module.globals.size();
  const ir::SharedReferences shared = ir::shared_references(module);
  for (const ir::Task& task : module.tasks) plan.use.push_back(ir::global_use(module, task, shared));

  // Two bit sets a global, most significant: how many write it, so that the ranges of single writers lie together.
  std::vector<std::tuple<std::uint32_t, std::string, std::int32_t, std::string>> key(globals);
  std::vector<std::optional<std::int32_t>> ceilings(globals);
  for (std::size_t g = 0; g < globals; ++g) {
    auto& [count, writers, ceiling, readers] = key[g];
    std::optional<std::int32_t> most_urgent;
    for (std::size_t t = 0; t < plan.use.size(); ++t) {
      const bool written = plan.use[t].written[g];
      count += written ? 1 : 0;
      // '0' before '1': the first task's exports come first.
      writers += written ? '0' : '1';
      readers += plan.use[t].read[g] ? '0' : '1';
      const std::int32_t priority = module.tasks[t].priority;
      if (written || plan.use[t].read[g]) most_urgent = std::min(most_urgent.value_or(priority), priority);
    }
    if (count == 1) ceilings[g] = most_urgent;
    // The least urgent ceiling first.
    if (coherence == core::Coherence::kPriorityCeiling && ceilings[g]) ceiling = -*ceilings[g];
  }
  for (std::uint32_t g = 0; g < globals; ++g) {
    // Queues are no variables.
    const bool left_out = module.globals[g].queue || (module.globals[g].mirror && !module.tests_run);
    if (!left_out) plan.order.push_back(g);
  }
  std::stable_sort(plan.order.begin(), plan.order.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return key[a] < key[b]; });
  for (const std::uint32_t g : plan.order) {
    plan.writers.push_back(std::get<0>(key[g]));
    plan.ceilings.push_back(ceilings[g]);
  }
  return plan;
}

namespace {

/// The global of a located variable begins with what the variable begins with in `whole`, an instance of type `type`.
void initialise_located(Shared& shared, const ir::LocatedPart& part, ir::TypeRef type, const std::byte* whole) {
  if (!part.begins) return;
  const std::uint32_t image_type = shared.layout.type(shared.module.globals[part.global].variable.type);
  std::memcpy(shared.image.global_initial.data() + shared.global_offset[part.global],
              whole + shared.layout.offset_of(type, part.path), shared.image.types[image_type].size);
}

/// Global variables at the address of another are names of its field; so are names with a list that need none.
void add_second_names(const Shared& shared, ImageType& globals) {
  std::unordered_set<std::string, core::NameHash, core::NameEqual> names;
  for (const ImageField& field : globals.fields) names.insert(field.name);
  const auto add = [&](std::uint32_t global, const std::string& list, const std::string& variable) {
    std::string name = list.empty() ? variable : list + "." + variable;
    const std::uint32_t field = shared.layout.global_field(global);
    if (field != kNoIndex && names.insert(name).second) globals.aliases.push_back({std::move(name), field});
  };
  for (const ir::GlobalAlias& alias : shared.module.global_aliases) add(alias.global, alias.list, alias.name);
  for (std::uint32_t g = 0; g < shared.module.globals.size(); ++g) {
    const ir::Global& global = shared.module.globals[g];
    if (!global.prefix.empty()) add(g, global.prefix, global.variable.name);
  }
}

}  // namespace

void lay_out_globals(Shared& shared, const GlobalPlan& plan) {
  Image& image = shared.image;
  StructBuilder fields;
  std::vector<std::uint32_t> field_of(shared.module.globals.size(), kNoIndex);
  for (std::uint32_t f = 0; f < plan.order.size(); ++f) field_of[plan.order[f]] = f;
  shared.layout.place_globals(std::move(field_of));
  shared.global_offset.assign(shared.module.globals.size(), 0);
  for (std::size_t f = 0; f < plan.order.size(); ++f) {
    const ir::Global& g = shared.module.globals[plan.order[f]];
    ImageField field;
    field.name = g.variable.name.empty() ? g.variable.address : g.variable.name;
    field.type = shared.layout.type(g.variable.type);
    field.constant = g.variable.constant;
    keep(g.variable, !g.variable.constant, field);
    shared.global_offset[plan.order[f]] = fields.offset(fields.add(image, std::move(field)));
    image.globals.push_back({g.list, g.variable.address, plan.writers[f]});
  }
  ImageType globals = fields.finish("#globals");
  add_second_names(shared, globals);
  image.types.push_back(std::move(globals));
  image.global_type = static_cast<std::uint32_t>(image.types.size() - 1);
  if (fields.too_large() || shared.layout.too_large()) return;
  image.global_initial.assign(image.types[image.global_type].size, std::byte{0});
  for (const std::uint32_t g : plan.order) {
    shared.layout.initialise(shared.module.globals[g].variable, image.global_initial.data() + shared.global_offset[g]);
  }
  for (const ir::LocatedInGlobal& located : shared.module.located) {
    initialise_located(shared, located.part, shared.module.globals[located.root].variable.type,
                       image.global_initial.data() + shared.global_offset[located.root]);
  }
}

namespace {

/// Some of `count` fields from `first` on that one instruction copies.
struct CopiedRange {
  Opcode opcode = Opcode::kReadN;
  std::uint32_t first = 0;
  std::uint32_t count = 0;
  std::int32_t level = 0;  ///< priority to copy it at
};

/// Adds the longest runs of fields that `wanted` holds for and whose `level` is the same.
template <class Wanted, class Level>
void add_ranges(std::vector<CopiedRange>& ranges, Opcode opcode, std::size_t fields, Wanted wanted, Level level) {
  bool open = false;
  for (std::uint32_t f = 0; f < fields; ++f) {
    const bool next = wanted(f);
    if (next && open && ranges.back().level == level(f)) {
      ++ranges.back().count;
    } else if (next) {
      ranges.push_back({opcode, f, 1, level(f)});
    }
    open = next;
  }
}

class TaskGenerator {
 public:
  TaskGenerator(Shared& shared, const GlobalPlan& plan, std::uint32_t task)
      : shared_(shared), plan_(plan), task_(shared.module.tasks[task]), use_(plan.use[task]) {}

  ImagePou run() {
    ImagePou out;
    out.name = task_.name;
    out.kind = PouKind::kTask;
    lay_out(out);
    CodeWriter writer(out.code, out.debug);
    writer.source(task_.at);
    const std::size_t fields = plan_.order.size();
    const auto level = [this](std::size_t f) { return level_of(f); };
    std::vector<CopiedRange> imports, exports;
    add_ranges(
        imports, Opcode::kReadN, fields, [&](std::size_t f) { return reads(f) || writes(f); }, level);
    add_ranges(
        exports, Opcode::kWriteN, fields, [&](std::size_t f) { return writes(f) && plan_.writers[f] == 1; }, level);
    add_ranges(
        exports, Opcode::kWriteChangedN, fields, [&](std::size_t f) { return writes(f) && plan_.writers[f] != 1; },
        level);
    exchange(writer, std::move(imports));
    connect_globals(writer, false);
    for (std::size_t p = 0; p < task_.programs.size(); ++p) {
      writer.source(task_.programs[p].at);
      connect(writer, p, false);
      writer.op(Opcode::kCallPou, {shared_.image_pou[task_.programs[p].pou], word_in(p, 0)});
      connect(writer, p, true);
    }
    writer.source(task_.at);
    connect_globals(writer, true);
    exchange(writer, std::move(exports));
    writer.op(Opcode::kReturn, {});
    return out;
  }

 private:
  [[nodiscard]] bool reads(std::size_t f) const { return use_.read[plan_.order[f]]; }
  [[nodiscard]] bool writes(std::size_t f) const { return use_.written[plan_.order[f]]; }
  /// Priority at which this task copies a field.
  [[nodiscard]] std::int32_t level_of(std::size_t f) const {
    const bool ceilings = shared_.image.options.coherence == core::Coherence::kPriorityCeiling;
    return ceilings ? plan_.ceilings[f].value_or(task_.priority) : task_.priority;
  }

  /// Whether another task may have to be held off while the range is copied.
  [[nodiscard]] bool guarded(const CopiedRange& range) const {
    if (shared_.image.options.coherence != core::Coherence::kPriorityCeiling) return false;
    const auto first = plan_.ceilings.begin() + range.first;
    return std::any_of(first, first + range.count, [](const auto& ceiling) { return ceiling.has_value(); });
  }

  /// Copies the ranges, as the protocol keeps other tasks off meanwhile (paper, 3.2.3).
  void exchange(CodeWriter& writer, std::vector<CopiedRange> ranges) {
    const bool lock = shared_.image.options.coherence == core::Coherence::kGlobalLock && !ranges.empty();
    std::stable_sort(ranges.begin(), ranges.end(),
                     [](const CopiedRange& a, const CopiedRange& b) { return a.level > b.level; });
    std::int32_t level = task_.priority;
    if (lock) writer.op(Opcode::kLock, {});
    for (const CopiedRange& range : ranges) {
      if (range.level < level) writer.op(Opcode::kRaisePriority, {range.first, range.count});
      level = range.level;
      writer.op(range.opcode, {range.first, range.count});
    }
    if (lock) writer.op(Opcode::kUnlock, {});
    // Also where nothing is raised: this machine may have other priorities than the project.
    if (std::any_of(ranges.begin(), ranges.end(), [this](const CopiedRange& range) { return guarded(range); })) {
      writer.op(Opcode::kReschedule, {});
    }
  }

  /// What begins `offset` bytes after the start of program `p`.
  [[nodiscard]] std::uint32_t word_in(std::size_t p, std::uint32_t offset) const {
    const std::uint32_t global = task_.programs[p].global;
    if (global == ir::Pou::kDeclared) return operand_word(Space::kInstance, offsets_[p] + offset);
    return operand_word(Space::kGlobal, shared_.global_offset[global] + offset);
  }

  /// Inputs take the values of their globals, or outputs give theirs.
  void connect(CodeWriter& writer, std::size_t p, bool outputs) {
    const ir::ProgramInstance& program = task_.programs[p];
    for (const ir::InstanceWire& wire : program.wires) {
      if (wire.output != outputs) continue;
      const std::uint32_t type = shared_.layout.type(shared_.module.globals[wire.global].variable.type);
      const std::uint32_t own = word_in(p, shared_.layout.pou(program.pou).offset[wire.variable]);
      const std::uint32_t other = operand_word(Space::kGlobal, shared_.global_offset[wire.global]);
      writer.op(Opcode::kCopy, {outputs ? other : own, outputs ? own : other, type});
    }
    const ir::TypeRef type = shared_.module.pous[program.pou].instance_type;
    for (const ir::LocatedPart& part : program.located) copy_located(writer, part, type, offsets_[p], outputs);
  }

  /// The same for located variables of instances that are globals.
  void connect_globals(CodeWriter& writer, bool outputs) {
    for (const ir::LocatedInGlobal& located : shared_.module.located) {
      if (!use_.written[located.root] && (outputs || !use_.read[located.root])) continue;
      const ir::TypeRef type = shared_.module.globals[located.root].variable.type;
      copy_located(writer, located.part, type, shared_.global_offset[located.root], outputs, Space::kGlobal);
    }
  }

  /// `whole` of type `type` holds the part.
  void copy_located(CodeWriter& writer, const ir::LocatedPart& part, ir::TypeRef type, std::uint32_t whole,
                    bool outputs, Space space = Space::kInstance) {
    if (outputs && !part.output) return;
    const std::uint32_t own = operand_word(space, whole + shared_.layout.offset_of(type, part.path));
    const std::uint32_t other = operand_word(Space::kGlobal, shared_.global_offset[part.global]);
    writer.op(Opcode::kCopy, {outputs ? other : own, outputs ? own : other,
                              shared_.layout.type(shared_.module.globals[part.global].variable.type)});
  }

  void lay_out(ImagePou& out) {
    StructBuilder fields;
    for (const ir::ProgramInstance& program : task_.programs) {
      if (program.global != ir::Pou::kDeclared) {
        offsets_.push_back(kNoIndex);
        continue;
      }
      ImageField field;
      field.name = program.name;
      field.retain = program.retain;
      field.type = shared_.layout.pou(program.pou).instance_type;
      offsets_.push_back(fields.offset(fields.add(shared_.image, std::move(field))));
    }
    out.frame_type = shared_.layout.empty_struct();
    const bool fits = !fields.too_large() && !shared_.layout.too_large();
    ImageType instance = fields.finish(task_.name);
    for (const ir::ProgramInstance& program : task_.programs) {
      for (const ir::LocatedPart& part : program.located) {
        instance.aliases.push_back({part.name, shared_.layout.global_field(part.global)});
      }
    }
    out.instance_initial.resize(fits ? instance.size : 0);
    shared_.image.types.push_back(std::move(instance));
    out.instance_type = static_cast<std::uint32_t>(shared_.image.types.size() - 1);
    for (std::size_t p = 0; p < task_.programs.size() && fits; ++p) {
      if (task_.programs[p].global != ir::Pou::kDeclared) continue;
      const std::vector<std::byte>& fresh = shared_.layout.instance_initial(task_.programs[p].pou);
      std::byte* const to = out.instance_initial.data() + offsets_[p];
      if (!fresh.empty()) std::memcpy(to, fresh.data(), fresh.size());
      const ir::TypeRef type = shared_.module.pous[task_.programs[p].pou].instance_type;
      shared_.layout.override_values(type, task_.programs[p].initial, to);
      for (const ir::LocatedPart& part : task_.programs[p].located) initialise_located(shared_, part, type, to);
    }
  }

  Shared& shared_;
  const GlobalPlan& plan_;
  const ir::Task& task_;
  const ir::GlobalUse& use_;
  std::vector<std::uint32_t> offsets_;
};

}  // namespace

bool lay_out_queues(Shared& shared) {
  const std::size_t globals = shared.module.globals.size();
  shared.queue_of.assign(globals, kNoIndex);
  std::vector<ImageQueue>& queues = shared.image.queues;
  std::vector<std::uint64_t> bytes;  // of one ring
  for (std::uint32_t g = 0; g < globals; ++g) {
    if (!shared.module.globals[g].queue) continue;
    const ir::Variable& v = shared.module.globals[g].variable;
    const ir::Type& array = shared.module.types[v.type];
    const std::uint64_t capacity =
        static_cast<std::uint64_t>(array.upper) - static_cast<std::uint64_t>(array.lower) + 1;
    shared.queue_of[g] = static_cast<std::uint32_t>(queues.size());
    ImageQueue& queue = queues.emplace_back();
    queue.name = v.name;
    queue.type = shared.layout.type(array.element);
    queue.capacity = static_cast<std::uint32_t>(std::min<std::uint64_t>(capacity, kMaxTableBytes));
    bytes.push_back(std::uint64_t{queue.capacity} * std::max(shared.image.types[queue.type].size, 1u));
  }
  for (std::uint32_t t = 0; t < shared.module.tasks.size() && !queues.empty(); ++t) {
    const std::vector<ir::QueueUse> use = ir::queue_use(shared.module, shared.module.tasks[t]);
    for (std::uint32_t g = 0; g < use.size(); ++g) {
      if (use[g].puts) queues[shared.queue_of[g]].puts.push_back(t);
      if (use[g].takes) queues[shared.queue_of[g]].takes = t;
    }
  }
  for (std::size_t q = 0; q < queues.size(); ++q) {
    if (bytes[q] > kMaxTableBytes / std::max<std::size_t>(queues[q].puts.size(), 1)) return false;
  }
  return true;
}

void generate_tasks(Shared& shared, const GlobalPlan& plan) {
  for (std::uint32_t t = 0; t < shared.module.tasks.size(); ++t) {
    const ir::Task& task = shared.module.tasks[t];
    ImagePou body = TaskGenerator(shared, plan, t).run();
    ImageTask out;
    out.name = task.name;
    out.period_ns = task.period_ns;
    out.priority = task.priority;
    out.single = task.single;
    out.body = static_cast<std::uint32_t>(shared.image.pous.size());
    shared.image.pous.push_back(std::move(body));
    shared.image.tasks.push_back(std::move(out));
  }
}

}  // namespace plc::bytecode
