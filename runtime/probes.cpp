#include "runtime/probes.h"

#include <algorithm>
#include <cstring>

#include "runtime/interpreter/operations.h"
#include "runtime/link/bindings.h"

namespace plc::runtime {

using bytecode::ProbeOp;
using bytecode::ProbeStep;

std::span<const std::byte> ProbeValues::value(std::uint32_t step) const {
  const Step& s = (*steps_)[step];
  if (s.bytes == 0 || (s.is_bool && values_[s.at] == kUnknown)) return {};
  return std::span(values_).subspan(s.at, s.bytes);
}

bool ProbeValues::is_true(std::uint32_t step) const {
  const Step& s = (*steps_)[step];
  return s.is_bool && values_[s.at] == std::byte{1};
}

void ProbeValues::clear() { std::fill(bits_.begin(), bits_.end(), std::uint8_t{0}); }

Probes::Probes(const bytecode::Image& image, std::uint32_t body, const std::vector<std::uint32_t>& pous,
               const TaskLayout& layout, std::span<const ProbedPou> views)
    : number_of_(image.pous.size(), kNobody) {
  if (image.probes.empty()) return;
  const Bindings bindings(image, body, pous, layout);
  std::vector<ProbedPou> sorted(views.begin(), views.end());
  std::sort(sorted.begin(), sorted.end());
  for (const ProbedPou& view : sorted) {
    const bool reached = std::find(pous.begin(), pous.end(), view.pou) != pous.end();
    if (!reached || image.probes[view.pou].empty()) continue;
    std::uint32_t& number = number_of_[view.pou];
    if (number == kNobody) {
      number = static_cast<std::uint32_t>(pous_.size());
      Pou& pou = *pous_.emplace_back(std::make_unique<Pou>());
      pou.pou = view.pou;
      // A function has none: its operands are nowhere in an instance.
      pou.only = bindings.absolute(view.pou, bytecode::operand_word(bytecode::Space::kInstance, 0));
      for (const ProbeStep& from : image.probes[view.pou].steps) {
        ProbeValues::Step step;
        step.op = from.op;
        step.type = from.type;
        step.at = pou.value_bytes;
        const bytecode::ImageType* const type = from.type == bytecode::kNoProbeType ? nullptr : &image.types[from.type];
        const bool text = type != nullptr && type->kind == bytecode::TypeKind::kString;
        step.is_bool =
            type == nullptr ? from.op != ProbeOp::kReached : !text && bytecode::rep_of(*type) == core::Rep::kBool;
        step.bytes = static_cast<std::uint16_t>(type == nullptr ? (step.is_bool ? 1u : 0u) : type->size);
        if (text) {
          constexpr std::uint32_t kMost = sizeof(core::StringHeader) + bytecode::kProbedTextBytes;
          step.character = bytecode::rep_of(*type) == core::Rep::kStr ? 1 : 2;
          step.bytes = static_cast<std::uint16_t>(std::min(type->size, kMost));
        }
        const auto place_of = [&](std::uint32_t operand) { return pou.steps[operand].at; };
        if (from.when != bytecode::kNoStep) step.when = place_of(from.when);
        if (from.op == ProbeOp::kCapture) step.a = bindings.resolve(view.pou, from.a);
        if (from.op == ProbeOp::kConst) step.a = from.a, step.b = from.b;
        if (from.op >= ProbeOp::kAnd && from.op <= ProbeOp::kNot) step.a = place_of(from.a);
        if (from.op >= ProbeOp::kAnd && from.op <= ProbeOp::kXor) step.b = place_of(from.b);
        pou.value_bytes += step.bytes;
        pou.steps.push_back(step);
      }
    }
    Pou& pou = *pous_[number];
    if (!pou.seen.empty() && pou.seen.back().instance_ == view.instance) continue;
    ProbeValues& seen = pou.seen.emplace_back();
    seen.instance_ = view.instance;
    seen.steps_ = &pou.steps;
    seen.values_.assign(pou.value_bytes, std::byte{});
    seen.bits_.assign(pou.steps.size(), 0);
    for (const ProbeValues::Step& step : pou.steps) {
      if (step.is_bool) seen.values_[step.at] = ProbeValues::kUnknown;
    }
  }
}

ProbeValues* Probes::find(const ProbedPou& view) {
  const std::uint32_t number = number_of_[view.pou];
  if (number == kNobody) return nullptr;
  Pou& pou = *pous_[number];
  const auto found = std::lower_bound(pou.seen.begin(), pou.seen.end(), view.instance,
                                      [](const ProbeValues& s, std::uint32_t at) { return s.instance_ < at; });
  return found == pou.seen.end() || found->instance_ != view.instance ? nullptr : &*found;
}

void Probes::run(std::uint32_t number, std::uint32_t first, std::uint32_t end, std::byte* table,
                 std::uint32_t instance) noexcept {
  const Pou& pou = *pous_[number];
  ProbeValues* const seen = find({pou.pou, pou.only.value_or(instance)});
  if (seen == nullptr) return;
  std::byte* const values = seen->values_.data();
  std::uint8_t* const bits = seen->bits_.data();
  const ProbeValues::Step* step = pou.steps.data() + first;
  constexpr std::byte kUnknown = ProbeValues::kUnknown;
  for (std::uint32_t i = first; i != end; ++i, ++step) {
    if (step->when != bytecode::kNoStep && values[step->when] != std::byte{1}) continue;
    std::byte* const to = values + step->at;
    switch (step->op) {
      case ProbeOp::kCapture: {
        const std::byte* const from = place<Addressing::kRelative>(table, instance, step->a);
        std::memcpy(to, from, step->bytes);
        if (step->character != 0) {
          // A text that goes on behind what is taken ends there.
          const auto most = static_cast<std::uint16_t>((step->bytes - sizeof(core::StringHeader)) / step->character);
          const auto head = load<core::StringHeader>(to);
          store(to, core::StringHeader{std::min(head.capacity, most), std::min(head.length, most)});
        }
        break;
      }
      case ProbeOp::kConst: {
        const std::uint64_t value = std::uint64_t{step->b} << 32 | step->a;
        std::memcpy(to, &value, step->bytes);
        break;
      }
      case ProbeOp::kAnd:
      case ProbeOp::kOr: {
        // FALSE AND what is not known is FALSE.
        const std::byte a = values[step->a], b = values[step->b];
        const std::byte decides{static_cast<unsigned char>(step->op == ProbeOp::kOr ? 1 : 0)};
        *to = a == decides || b == decides ? decides : a == kUnknown || b == kUnknown ? kUnknown : a;
        break;
      }
      case ProbeOp::kXor: {
        const std::byte a = values[step->a], b = values[step->b];
        *to = a == kUnknown || b == kUnknown ? kUnknown : a ^ b;
        break;
      }
      case ProbeOp::kNot:
        *to = values[step->a] == kUnknown ? kUnknown : values[step->a] ^ std::byte{1};
        break;
      case ProbeOp::kReached:
        break;
      case ProbeOp::kNotComputed:
        *to = kUnknown;
        break;
    }
    std::uint8_t happened = ProbeValues::kRan;
    if (step->is_bool) {
      happened |= *to == kUnknown       ? ProbeValues::kWasUnknown
                  : *to == std::byte{0} ? ProbeValues::kWasFalse
                                        : ProbeValues::kWasTrue;
    }
    bits[i] |= happened;
  }
}

}  // namespace plc::runtime
