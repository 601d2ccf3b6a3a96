// Who writes and who reads each global, and what flows between tasks: from the exchange of the tasks' bodies.
#include "tools/plc/flow.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <limits>
#include <map>
#include <tuple>
#include <utility>

#include "bytecode/paths.h"
#include "core/text.h"
#include "runtime/link/decoded.h"
#include "runtime/link/link.h"
#include "tools/command_line.h"
#include "tools/open.h"

namespace plc::tools {
namespace {

using bytecode::Image;
using bytecode::ImageTask;
using bytecode::ImageType;
using bytecode::OperandKind;
using bytecode::TypeKind;

std::string type_text(const Image& image, std::uint32_t index) {
  const ImageType& type = image.types[index];
  if (!type.name.empty()) return type.name;
  switch (type.kind) {
    case TypeKind::kScalar:
      return std::string(core::name_of(type.elementary));
    case TypeKind::kString:
      return fmt::format("{}[{}]", core::name_of(type.elementary), type.capacity);
    case TypeKind::kArray:
      return fmt::format("ARRAY[{}..{}] OF {}", type.lower, type.lower + std::int64_t{type.count} - 1,
                         type_text(image, type.element));
    case TypeKind::kRef:
      // Its target may refer back to it.
      return image.types[type.element].name.empty() ? "REF_TO .." : "REF_TO " + image.types[type.element].name;
    case TypeKind::kStruct:
      return "STRUCT";
  }
  return {};
}

constexpr std::size_t kNoField = ~std::size_t{0};

/// The field that holds this byte of the global table.
std::size_t field_at(const std::vector<bytecode::ImageField>& fields, std::uint32_t offset) {
  const auto next =
      std::upper_bound(fields.begin(), fields.end(), offset,
                       [](std::uint32_t wanted, const bytecode::ImageField& field) { return wanted < field.offset; });
  return next == fields.begin() ? kNoField : static_cast<std::size_t>(next - fields.begin()) - 1;
}

/// What the code that one task reaches does with globals, by field.
class CodeUse {
 public:
  CodeUse(const Image& image, std::uint32_t body) : image_(image), fields_(image.types[image.global_type].fields) {
    read.resize(fields_.size());
    written.resize(fields_.size());
    for (const std::uint32_t pou : runtime::reached_pous(image, body)) {
      runtime::for_each_instruction(image.pous[pou], [&](const runtime::Decoded& d) { add(d); });
    }
  }
  std::vector<bool> read, written;

 private:
  void mark(std::uint32_t word, std::vector<bool>& used) {
    if (bytecode::space_of(word) != bytecode::Space::kGlobal) return;
    const std::size_t field = field_at(fields_, bytecode::offset_of(word));
    if (field != kNoField) used[field] = true;
  }

  void add(const runtime::Decoded& d) {
    const bytecode::Operands& operands = bytecode::info(d.opcode).operands;
    // Making a handle names a place as read; so does executing what lies there. Both may write it as well.
    for (std::uint8_t i = 0; i < operands.count; ++i) {
      switch (operands.specs[i].kind) {
        case OperandKind::kIn:
        case OperandKind::kPlaceIn:
        case OperandKind::kPlaceInOut:
        case OperandKind::kBaseIn:
        case OperandKind::kValueIn:
          mark(d.operands[i], read);
          break;
        case OperandKind::kOut:
        case OperandKind::kPlaceOut:
        case OperandKind::kValueOut:
          mark(d.operands[i], written);
          break;
        case OperandKind::kBaseOut:
          // RUN_AT and CALL_AT execute what lies at the end of their path.
          mark(d.operands[i], d.opcode == bytecode::Opcode::kStoreAt ? written : read);
          break;
        case OperandKind::kPath:
          for (std::uint32_t item = 0; item < d.items; ++item) {
            const std::uint32_t* const step = d.list + std::size_t{item} * bytecode::kPathWords;
            if (step[0] == static_cast<std::uint32_t>(bytecode::PathStep::kIndex)) mark(step[1], read);
          }
          break;
        case OperandKind::kRecords:
          for (std::uint32_t item = 0; item < d.items; ++item) {
            const std::uint32_t* const record = d.list + std::size_t{item} * bytecode::kRecordWords;
            mark(record[1], written);
            for (std::uint32_t in = 2; in < bytecode::kRecordWords; ++in) mark(record[in], read);
          }
          break;
        case OperandKind::kStdArgs:
          for (std::uint32_t item = 0; item < d.items; ++item) mark(d.list[item], item == 0 ? written : read);
          break;
        case OperandKind::kFnArgs: {
          const auto& parameters = image_.types[image_.pous[d.operands[0]].frame_type].fields;
          for (std::uint32_t item = 0; item < d.items; ++item) {
            const bytecode::FieldRole role = parameters[d.list[2 * item]].role;
            const bool out = role == bytecode::FieldRole::kOutput || role == bytecode::FieldRole::kReturnValue;
            mark(d.list[2 * item + 1], out ? written : read);
          }
          break;
        }
        default:
          break;
      }
    }
  }

  const Image& image_;
  const std::vector<bytecode::ImageField>& fields_;
};

/// Of one task, by field of the global table.
struct TaskUse {
  std::vector<bool> imports, exports;
  std::size_t event = kNoField;  ///< its rising edge releases the task
};

TaskUse use_of(const Image& image, const ImageTask& task) {
  const std::size_t fields = image.globals.size();
  TaskUse use{std::vector<bool>(fields), std::vector<bool>(fields)};
  runtime::for_each_instruction(image.pous[task.body], [&](const runtime::Decoded& d) {
    const bool exports = d.opcode == bytecode::Opcode::kWriteN || d.opcode == bytecode::Opcode::kWriteChangedN;
    if (!exports && d.opcode != bytecode::Opcode::kReadN) return;
    std::fill_n((exports ? use.exports : use.imports).begin() + d.operands[0], d.operands[1], true);
  });
  if (task.single.empty()) return use;
  const auto event = bytecode::find_global(image, task.single);
  if (event) use.event = field_at(image.types[image.global_type].fields, event->offset);
  return use;
}

bool is_at(const FlowGlobal& global, char area) { return global.address.size() > 1 && global.address[1] == area; }

class FlowFinder {
 public:
  explicit FlowFinder(const Image& image) : image_(image) {
    for (const ImageTask& task : image.tasks) use_.push_back(use_of(image, task));
  }

  DataFlow run() {
    DataFlow flow;
    for (std::uint32_t field = 0; field < image_.globals.size(); ++field) flow.globals.push_back(global(field));
    for (const bytecode::ImageQueue& queue : image_.queues) flow.globals.push_back(global_of(queue));
    std::stable_sort(flow.globals.begin(), flow.globals.end(), [](const FlowGlobal& a, const FlowGlobal& b) {
      const auto key = [](const FlowGlobal& g) {
        return std::pair(g.owner, g.owner == FlowOwner::kTask ? g.writers.front() : 0u);
      };
      return key(a) < key(b);
    });
    std::map<std::pair<FlowEnd, FlowEnd>, Flow> flows;
    for (std::uint32_t g = 0; g < flow.globals.size(); ++g) {
      for (const auto& ends : ends_of(flow.globals[g])) {
        Flow& one = flows[ends];
        one.globals.push_back(g);
        one.bytes += flow.globals[g].bytes;
      }
    }
    for (auto& [ends, one] : flows) {
      std::tie(one.from, one.to) = ends;
      one.age_ns = age(one);
      flow.flows.push_back(std::move(one));
    }
    return flow;
  }

 private:
  FlowGlobal global_of(const bytecode::ImageQueue& queue) const {
    FlowGlobal out;
    out.name = queue.name;
    out.type = fmt::format("queue [{}] of {}", queue.capacity, type_text(image_, queue.type));
    out.bytes = image_.types[queue.type].size;
    out.owner = FlowOwner::kQueue;
    out.writers = queue.puts;
    if (queue.takes != bytecode::ImageQueue::kNoTask) out.readers.push_back(queue.takes);
    return out;
  }

  FlowGlobal global(std::uint32_t field) {
    const bytecode::ImageField& f = image_.types[image_.global_type].fields[field];
    FlowGlobal out;
    out.name = image_.globals[field].list.empty() ? f.name : image_.globals[field].list + "." + f.name;
    out.type = type_text(image_, f.type);
    out.address = image_.globals[field].address;
    out.bytes = image_.types[f.type].size;
    for (std::uint32_t t = 0; t < use_.size(); ++t) {
      if (use_[t].exports[field]) out.writers.push_back(t);
    }
    for (std::uint32_t t = 0; t < use_.size(); ++t) {
      if (reads(t, field, out.writers.size())) out.readers.push_back(t);
      if (out.writers.size() != 1 || !use_[t].imports[field]) continue;
      const std::int32_t priority = image_.tasks[t].priority;
      out.ceiling = std::min(out.ceiling.value_or(priority), priority);
    }
    if (f.constant) {
      out.owner = FlowOwner::kConstant;
    } else if (out.writers.size() > 1) {
      out.owner = FlowOwner::kShared;
    } else if (out.writers.size() == 1) {
      out.owner = FlowOwner::kTask;
    } else if (image_.globals[field].address.starts_with("%I")) {
      out.owner = FlowOwner::kDevices;
    }
    return out;
  }

  /// Whether task `t` uses values of others. A task imports what it exports, too: where several write a variable, its
  /// code tells. What it reaches by reference alone counts as read.
  bool reads(std::uint32_t t, std::uint32_t field, std::size_t writers) {
    const bool is_event = use_[t].event == field;
    if (!use_[t].exports[field]) return is_event || use_[t].imports[field];
    if (writers < 2 || is_event) return writers > 1;
    auto code = code_.find(t);
    if (code == code_.end()) code = code_.try_emplace(t, image_, image_.tasks[t].body).first;
    return code->second.read[field] || !code->second.written[field];
  }

  static std::vector<std::pair<FlowEnd, FlowEnd>> ends_of(const FlowGlobal& global) {
    std::vector<FlowEnd> from;
    std::vector<FlowEnd> to;
    for (const std::uint32_t t : global.writers) from.push_back({FlowEnd::Kind::kTask, t});
    for (const std::uint32_t t : global.readers) to.push_back({FlowEnd::Kind::kTask, t});
    if (global.owner == FlowOwner::kConstant) from.clear();
    if (global.owner == FlowOwner::kDevices) from.push_back({FlowEnd::Kind::kDevices});
    if (global.owner == FlowOwner::kOutside) from.push_back({FlowEnd::Kind::kOutside});
    if (!global.writers.empty() && is_at(global, 'Q')) to.push_back({FlowEnd::Kind::kDevices});
    std::vector<std::pair<FlowEnd, FlowEnd>> ends;
    for (const FlowEnd& a : from) {
      for (const FlowEnd& b : to) {
        if (a != b) ends.emplace_back(a, b);
      }
    }
    return ends;
  }

  [[nodiscard]] std::optional<core::TimeNs> age(const Flow& flow) const {
    core::TimeNs sum = 0;
    for (const FlowEnd& end : {flow.from, flow.to}) {
      if (end.kind != FlowEnd::Kind::kTask) continue;
      const ImageTask& task = image_.tasks[end.task];
      const bool periodic = task.single.empty() && task.period_ns > 0;
      if (!periodic || task.period_ns > std::numeric_limits<core::TimeNs>::max() - sum) return std::nullopt;
      sum += task.period_ns;
    }
    return sum;
  }

  const Image& image_;
  std::vector<TaskUse> use_;
  std::map<std::uint32_t, CodeUse> code_;  ///< by task; of those that share a variable with another writer
};

/// "Fast, Slow, devices"
std::string users_text(const Image& image, const std::vector<std::uint32_t>& tasks, bool devices) {
  std::vector<std::string_view> names;
  for (const std::uint32_t t : tasks) names.push_back(image.tasks[t].name);
  if (devices) names.emplace_back("devices");
  return names.empty() ? "-" : fmt::format("{}", fmt::join(names, ", "));
}

std::string owner_text(const Image& image, const FlowGlobal& global) {
  switch (global.owner) {
    case FlowOwner::kTask:
      return image.tasks[global.writers.front()].name;
    case FlowOwner::kShared:
      return "shared";
    case FlowOwner::kDevices:
      return "devices";
    case FlowOwner::kOutside:
      return "outside";
    case FlowOwner::kConstant:
      return "constant";
    case FlowOwner::kQueue:
      return "queue";
  }
  return {};
}

}  // namespace

DataFlow data_flow(const Image& image) { return FlowFinder(image).run(); }

std::string release_text(const ImageTask& task) {
  if (!task.single.empty()) return "on " + task.single;
  if (task.period_ns <= 0) return "freewheeling";
  return "every " + duration_text(static_cast<double>(task.period_ns));
}

std::string end_text(const Image& image, const FlowEnd& end) {
  switch (end.kind) {
    case FlowEnd::Kind::kDevices:
      return "devices";
    case FlowEnd::Kind::kTask:
      return image.tasks[end.task].name;
    case FlowEnd::Kind::kOutside:
      return "outside";
  }
  return {};
}

std::string flow_tables(const Image& image, const DataFlow& flow) {
  const bool ceilings = image.options.coherence == core::Coherence::kPriorityCeiling;
  using Rows = std::vector<std::vector<std::string>>;
  Rows tasks = {{"task", "released", "priority"}};
  for (const ImageTask& task : image.tasks) {
    tasks.push_back({task.name, release_text(task), std::to_string(task.priority)});
  }
  Rows globals = {{"variable", "type", "address", "owner", "written by", "read by"}};
  if (ceilings) globals.front().emplace_back("ceiling");
  for (const FlowGlobal& global : flow.globals) {
    globals.push_back({global.name, global.type, global.address.empty() ? "-" : global.address,
                       owner_text(image, global),
                       users_text(image, global.writers, is_at(global, 'I') && global.writers.empty()),
                       users_text(image, global.readers, is_at(global, 'Q'))});
    if (ceilings) globals.back().push_back(global.ceiling ? std::to_string(*global.ceiling) : "-");
  }
  Rows flows = {{"from", "to", "variables", "bytes", "age at most"}};
  for (const Flow& one : flow.flows) {
    flows.push_back({end_text(image, one.from), end_text(image, one.to), std::to_string(one.globals.size()),
                     std::to_string(one.bytes), one.age_ns ? duration_text(static_cast<double>(*one.age_ns)) : "-"});
  }
  return fmt::format("{}\n\n{}\n{}\n{}", describe(image.options), columns_text(tasks), columns_text(globals),
                     columns_text(flows));
}

}  // namespace plc::tools
