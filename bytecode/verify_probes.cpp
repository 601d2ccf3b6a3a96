#include <fmt/format.h>

#include <array>

#include "bytecode/verifier.h"

namespace plc::bytecode {

namespace {

class ProbeVerifier {
 public:
  ProbeVerifier(const Image& image, Report& report, const ImagePou& pou, const PouProbes& probes)
      : image_(image),
        report_(report),
        pou_(pou),
        probes_(probes),
        types_{image.global_type, pou.instance_type, pou.frame_type, image.const_type} {}

  void run() {
    find_places();
    const ProbeStep* before = nullptr;
    for (std::uint32_t i = 0; i < probes_.steps.size() && !report_.full(); ++i) {
      check_step(i, before);
      before = &probes_.steps[i];
    }
    check_jumps();
    check_points();
  }

 private:
  enum Place : std::uint8_t { kNone, kRecord, kInstruction, kJump };

  void broken(Rule rule, std::size_t word, const std::string& what) { report_.broken(rule, pou_, word, what); }

  void find_places() {
    places_.assign(pou_.code.size(), kNone);
    for (std::size_t at = 0; at < pou_.code.size();) {
      const auto opcode = static_cast<Opcode>(pou_.code[at] & 0xffffu);
      const std::uint32_t items = pou_.code[at] >> 16;
      const Operands& operands = info(opcode).operands;
      bool jump = false;
      for (std::uint8_t i = 0; i < operands.count; ++i) jump = jump || operands.specs[i].kind == OperandKind::kTarget;
      places_[at] = jump ? kJump : kInstruction;
      for (std::uint32_t r = 1; opcode == Opcode::kBoolRun && r < items; ++r) {
        places_[at + 1 + std::size_t{r} * kRecordWords] = kRecord;
      }
      at += words_of(operands, items);
    }
  }
  [[nodiscard]] Place place(std::uint32_t word) const { return word < places_.size() ? places_[word] : kNone; }

  void check_step(std::uint32_t number, const ProbeStep* before) {
    const ProbeStep& step = probes_.steps[number];
    const bool ascends =
        before == nullptr || before->word < step.word || (before->word == step.word && before->order <= step.order);
    if (!ascends || place(step.word) == kNone) {
      broken(Rule::kV320, step.word, fmt::format("step {} of its probe map", number));
    }
    if (step.when != kNoStep) check_bool(number, step.when);
    const bool no_type = step.op != ProbeOp::kCapture && step.op != ProbeOp::kConst;
    if (no_type && step.type != kNoProbeType) {
      broken(Rule::kV321, step.word, fmt::format("step {} of its probe map has a type", number));
    }
    switch (step.op) {
      case ProbeOp::kCapture:
        return check_capture(number, step);
      case ProbeOp::kConst:
        return check_constant(number, step);
      case ProbeOp::kAnd:
      case ProbeOp::kOr:
      case ProbeOp::kXor:
        check_bool(number, step.b);
        return check_bool(number, step.a);
      case ProbeOp::kNot:
        return check_bool(number, step.a);
      case ProbeOp::kReached:
      case ProbeOp::kNotComputed:
        return;
    }
  }

  void check_capture(std::uint32_t number, const ProbeStep& step) {
    const Space space = space_of(step.a);
    const bool none = space == Space::kInstance && pou_.kind == PouKind::kFunction;
    const auto leaf = none ? std::nullopt : leaf_at(image_, types_[static_cast<std::size_t>(space)], offset_of(step.a));
    if (!leaf || *leaf != step.type || image_.types[*leaf].kind == TypeKind::kRef) {
      broken(Rule::kV321, step.word,
             fmt::format("step {} of its probe map captures byte {}", number, offset_of(step.a)));
    }
  }

  void check_constant(std::uint32_t number, const ProbeStep& step) {
    const bool scalar = step.type == kNoProbeType ||
                        (step.type < image_.types.size() && image_.types[step.type].kind == TypeKind::kScalar);
    if (!scalar) broken(Rule::kV321, step.word, fmt::format("step {} of its probe map is a constant", number));
  }

  void check_bool(std::uint32_t number, std::uint32_t operand) {
    const bool fits = operand < number && is_bool(probes_.steps[operand]);
    if (!fits) {
      broken(Rule::kV322, probes_.steps[number].word,
             fmt::format("step {} of its probe map takes step {}", number, operand));
    }
  }
  /// The types of steps before the one that is checked are sound.
  [[nodiscard]] bool is_bool(const ProbeStep& step) const {
    if (step.op == ProbeOp::kReached) return false;
    if (step.type == kNoProbeType) return true;
    return step.type < image_.types.size() && image_.types[step.type].kind == TypeKind::kScalar &&
           rep_of(image_.types[step.type]) == core::Rep::kBool;
  }

  void check_jumps() {
    const ProbeJump* before = nullptr;
    for (const ProbeJump& jump : probes_.jumps) {
      if (report_.full()) return;
      if (place(jump.word) != kJump || (before != nullptr && before->word >= jump.word)) {
        broken(Rule::kV323, jump.word, "jump of its probe map");
      }
      before = &jump;
    }
  }

  void check_points() {
    const ProbePoint* before = nullptr;
    for (const ProbePoint& point : probes_.points) {
      if (report_.full()) return;
      const bool ascends = before == nullptr || before->key < point.key;
      if (!ascends || point.key.pou != 0 || point.step >= probes_.steps.size()) {
        broken(Rule::kV323, 0, fmt::format("point at line {} of its probe map", point.key.line));
      }
      before = &point;
    }
  }

  const Image& image_;
  Report& report_;
  const ImagePou& pou_;
  const PouProbes& probes_;
  std::array<std::uint32_t, 4> types_;  // structure of each Space
  std::vector<Place> places_;           // by code word
};

}  // namespace

void verify_probes(const Image& image, Report& report) {
  if (image.probes.empty()) return;
  if (image.probes.size() != image.pous.size()) {
    return report.broken(Rule::kV319, fmt::format("{} probe maps for {} POUs", image.probes.size(), image.pous.size()));
  }
  for (std::size_t i = 0; i < image.pous.size() && !report.full(); ++i) {
    ProbeVerifier(image, report, image.pous[i], image.probes[i]).run();
  }
}

}  // namespace plc::bytecode
