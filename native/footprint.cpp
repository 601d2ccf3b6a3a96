#include "native/footprint.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>
#include <string_view>

#include "core/types.h"
#include "runtime/operations.h"
#include "stdlib/library.h"

namespace plc::native {
namespace {

using runtime::GeneralRecord;
using runtime::LinkedInstruction;
using stdlib::BlockSpec;

/// Blocks whose step looks at its ports alone, and at the time only while STATE says that a timer runs.
constexpr std::array<std::string_view, 4> kTimeless = {"R_TRIG", "F_TRIG", "SR", "RS"};
constexpr std::array<std::string_view, 3> kCounters = {"CTU", "CTD", "CTUD"};
constexpr std::array<std::string_view, 3> kTimers = {"TON", "TOF", "TP"};

template <std::size_t N>
bool is_one_of(std::string_view name, const std::array<std::string_view, N>& bases) {
  return std::any_of(bases.begin(), bases.end(), [name](std::string_view base) {
    return name == base || (name.starts_with(base) && name[base.size()] == '_');
  });
}

std::uint32_t text_bytes(std::uint32_t capacity, std::uint32_t width) {
  return static_cast<std::uint32_t>(sizeof(core::StringHeader)) + capacity * width;
}

/// The parts that indices may choose: `index` as in runtime/operations.h, `bytes` of each part.
Range elements(std::uint32_t place, const std::uint32_t* index, std::uint32_t indices, unsigned bytes) {
  std::uint64_t all = bytes;
  for (std::uint32_t n = 0; n < indices; ++n, index += runtime::kIndexWords) {
    if (index[1] == 0) return {place, 0};
    all += std::uint64_t{index[1] - 1} * index[2];
  }
  return {place, static_cast<std::uint32_t>(std::min<std::uint64_t>(all, runtime::kRelativeBit))};
}

}  // namespace

Footprints::Footprints(const runtime::LinkedCode& linked) : linked_(linked) {
  for (std::size_t b = 0; b < linked.bodies.size(); ++b) body_at_.emplace(linked.bodies[b].entry, b);
}

std::vector<GeneralRecord> Footprints::records_of(const LinkedInstruction& instruction) const {
  const std::uint32_t* const w = linked_.data() + instruction.position;
  std::vector<GeneralRecord> records(w[1]);
  if (operation_of(instruction.op).form == Form::kGeneralRecords) {
    std::memcpy(static_cast<void*>(records.data()), w + 2, records.size() * sizeof(GeneralRecord));
    return records;
  }
  const auto* at = reinterpret_cast<const unsigned char*>(linked_.data() + w[3]);
  for (GeneralRecord& record : records) {
    const auto r = runtime::load_field<runtime::ShortRecord>(at);
    record.truth = r.truth;
    record.out = w[2] + r.out;
    for (std::size_t k = 0; k < std::size(r.in); ++k) record.in[k] = w[2] + r.in[k];
    at += sizeof(runtime::ShortRecord);
  }
  return records;
}

Footprint Footprints::of(const LinkedInstruction& instruction) {
  const std::uint32_t* const w = linked_.data() + instruction.position;
  const Operation operation = operation_of(instruction.op);
  const unsigned bytes = bytes_of(operation.type);
  Footprint f;
  // Most instructions: w[1] := .. of the operands behind it.
  const auto computes = [&](unsigned result, std::uint32_t operands) {
    f.pure = f.writes_known = f.always_writes = true;
    f.writes.push_back({w[1], result});
    for (std::uint32_t i = 0; i < operands; ++i) f.reads.push_back({w[2 + i], bytes});
  };
  switch (operation.form) {
    case Form::kMove:
      computes(bytes, 1);
      break;
    case Form::kCopy:
      f.pure = f.writes_known = f.always_writes = true;
      f.writes.push_back({w[1], w[3]});
      f.reads.push_back({w[2], w[3]});
      break;
    case Form::kDiv:
      f.raises = !is_real(operation.type);
      computes(bytes, 2);
      break;
    case Form::kAdd:
    case Form::kSub:
    case Form::kMul:
    case Form::kMod:
    case Form::kAnd:
    case Form::kOr:
    case Form::kXor:
      computes(bytes, 2);
      break;
    case Form::kCompareJumpUnless:
    case Form::kCompareJumpIf:
      f.target = w[4];
      [[fallthrough]];
    case Form::kCompare:
      computes(1, 2);
      break;
    case Form::kExtract:
      computes(1, 1);
      break;
    case Form::kInsert:
      computes(1, 1);
      f.reads.push_back({w[1], 1});
      break;
    case Form::kRange:
      f.raises = true;
      computes(bytes, 3);
      break;
    case Form::kLoadElement:
    case Form::kStoreElement: {
      const std::uint32_t* const index = w + 3;
      const Range array = elements(w[2], index, 1, bytes);
      const bool load = operation.form == Form::kLoadElement;
      f.raises = f.pure = f.writes_known = true;
      f.always_writes = load;
      f.reads.push_back({index[0], core::rep_bytes(static_cast<core::Rep>(index[5]))});
      f.reads.push_back(load ? array : Range{w[1], bytes});
      f.writes.push_back(load ? Range{w[1], bytes} : array);
      break;
    }
    case Form::kLoadPath:
    case Form::kStorePath: {
      const std::uint32_t* index = w + 5;
      const Range array = elements(w[2] + w[3], index, w[4], bytes);
      const bool load = operation.form == Form::kLoadPath;
      f.raises = f.pure = f.writes_known = true;
      f.always_writes = load;
      for (std::uint32_t n = 0; n < w[4]; ++n, index += runtime::kIndexWords) {
        f.reads.push_back({index[0], core::rep_bytes(static_cast<core::Rep>(index[5]))});
      }
      f.reads.push_back(load ? array : Range{w[1], bytes});
      f.writes.push_back(load ? Range{w[1], bytes} : array);
      break;
    }
    case Form::kClearEvent:
      f.pure = f.writes_known = true;
      break;
    case Form::kEno:
      // Depends on events since CLEAR_EVENT.
      f.writes_known = true;
      f.writes.push_back({w[1], 1});
      break;
    case Form::kJump:
      f.pure = f.writes_known = true;
      f.target = w[1];
      break;
    case Form::kJumpUnless:
    case Form::kJumpIf:
      f.pure = f.writes_known = true;
      f.reads.push_back({w[1], 1});
      f.target = w[2];
      break;
    case Form::kLoopJump:
      f.writes_known = true;
      f.target = w[1];
      break;
    case Form::kStretch:
    case Form::kArranged:
      f.pure = f.writes_known = true;
      break;
    case Form::kReturn:
      f.writes_known = true;
      break;
    case Form::kRunBlock:
      add_block(f, w);
      break;
    case Form::kCallLibrary:
      add_library(f, w);
      break;
    case Form::kCallFixed:
      add_call(f, w[1], 0);
      break;
    case Form::kCallRelative:
      add_call(f, w[1], w[2]);
      break;
    case Form::kCallFunction:
      add_function(f, w);
      break;
    case Form::kInterpreted:
      switch (instruction.op) {
        case runtime::ResolvedOp::kMoveStr:
        case runtime::ResolvedOp::kMoveWstr: {
          const std::uint32_t width = instruction.op == runtime::ResolvedOp::kMoveStr ? 1 : 2;
          f.writes_known = true;
          f.writes.push_back({w[1], text_bytes(w[3] & 0xffffu, width)});
          break;
        }
        case runtime::ResolvedOp::kWriteN:
        case runtime::ResolvedOp::kWriteChangedN:
          f.writes_known = true;
          break;
        default:
          break;
      }
      break;
    case Form::kRunTaskblock:
    case Form::kShortRecords4:
    case Form::kShortRecords5:
    case Form::kGeneralRecords:
      break;
  }
  const auto large = [](const Range& range) { return range.bytes > kMostPureBytes; };
  if (std::any_of(f.reads.begin(), f.reads.end(), large) || std::any_of(f.writes.begin(), f.writes.end(), large)) {
    f.pure = false;
  }
  return f;
}

void Footprints::add_block(Footprint& f, const std::uint32_t* w) {
  const auto step = runtime::load_pointer<stdlib::Step>(w + 1);
  const auto blocks = stdlib::blocks();
  const auto spec = std::find_if(blocks.begin(), blocks.end(), [step](const BlockSpec& b) { return b.step == step; });
  if (spec == blocks.end()) return;
  f.writes_known = true;
  f.reads.push_back({w[3], spec->size});
  f.writes.push_back({w[3], spec->size});
  f.pure = is_one_of(spec->name, kTimeless) || is_one_of(spec->name, kCounters);
  if (is_one_of(spec->name, kTimers)) {
    f.pure = true;
    f.timer = w[3] + stdlib::field_named(*spec, "STATE")->offset;
  }
}

void Footprints::add_library(Footprint& f, const std::uint32_t* w) {
  // Overloads that share a kernel have types of the same sizes.
  static const std::unordered_map<std::uint64_t, const stdlib::Overload*> kByKernel = [] {
    std::unordered_map<std::uint64_t, const stdlib::Overload*> all;
    for (const stdlib::Overload& overload : stdlib::overloads()) {
      all.emplace(reinterpret_cast<std::uint64_t>(overload.kernel), &overload);
    }
    return all;
  }();
  const auto found = kByKernel.find(runtime::load<std::uint64_t>(w + 1));
  if (found == kByKernel.end()) return;
  const stdlib::Overload& overload = *found->second;
  const std::uint32_t result = core::rep_bytes(core::rep_of(overload.result_type()));
  if (result == 0) return;  // a text: how long it may be is not in the code
  f.raises = f.writes_known = f.pure = f.always_writes = true;
  f.writes.push_back({w[4], result});
  for (std::uint32_t i = 0; i < w[3]; ++i) {
    const std::uint32_t bytes = core::rep_bytes(core::rep_of(overload.param_type(i)));
    if (bytes == 0) f.pure = false;
    f.reads.push_back({w[5 + i], bytes});
  }
}

void Footprints::add_call(Footprint& f, std::uint32_t entry, std::uint32_t instance) {
  const Writes& writes = writes_of_body(entry);
  if (!writes) return;
  f.writes_known = true;
  for (Range range : *writes) {
    if ((range.begin & runtime::kRelativeBit) != 0) range.begin = (range.begin & ~runtime::kRelativeBit) + instance;
    f.writes.push_back(range);
  }
}

/// Words as in native/compile.cpp: frame, frame bytes, initial bytes (2), entry, inputs, outputs, arguments.
void Footprints::add_function(Footprint& f, const std::uint32_t* w) {
  const Writes& writes = writes_of_body(w[5]);
  if (!writes) return;
  f.writes_known = true;
  f.writes = *writes;
  f.writes.push_back({w[1], w[2]});
  const std::uint32_t* argument = w + 8;
  for (const std::uint32_t* const end = argument + (std::size_t{w[6]} + w[7]) * 4; argument != end; argument += 4) {
    const std::uint32_t capacity = argument[3] & 0xffffu;
    const std::uint32_t bytes = argument[2] == runtime::kPassStr    ? text_bytes(capacity, 1)
                                : argument[2] == runtime::kPassWstr ? text_bytes(capacity, 2)
                                                                    : argument[2];
    f.writes.push_back({argument[0], bytes});
  }
}

const Footprints::Writes& Footprints::writes_of_body(std::uint32_t entry) {
  if (const auto known = writes_.find(entry); known != writes_.end()) return known->second;
  Writes writes = std::vector<Range>();
  for (const LinkedInstruction& instruction : linked_.instructions_of(body_at_.at(entry))) {
    if (!writes) break;
    if (is_boolean_run(operation_of(instruction.op).form)) {
      for (const GeneralRecord& record : records_of(instruction)) writes->push_back({record.out, 1});
      continue;
    }
    const Footprint f = of(instruction);
    if (f.writes_known) {
      writes->insert(writes->end(), f.writes.begin(), f.writes.end());
    } else {
      writes.reset();
    }
  }
  if (writes) {
    std::sort(writes->begin(), writes->end(), [](const Range& x, const Range& y) {
      return x.begin != y.begin ? x.begin < y.begin : x.bytes > y.bytes;
    });
    // Those that touch become one.
    std::vector<Range> joined;
    for (const Range& range : *writes) {
      if (!joined.empty() && range.begin <= joined.back().begin + joined.back().bytes) {
        joined.back().bytes = std::max(joined.back().bytes, range.begin + range.bytes - joined.back().begin);
      } else {
        joined.push_back(range);
      }
    }
    *writes = std::move(joined);
  }
  return writes_.emplace(entry, std::move(writes)).first->second;
}

}  // namespace plc::native
