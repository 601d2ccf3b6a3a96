#include "bytecode/probes.h"

#include "bytecode/byte_io.h"

namespace plc::bytecode {

namespace {

// Beside the operation in the first byte of a step.
constexpr std::uint8_t kHasOrder = 8;
constexpr std::uint8_t kHasType = 16;
constexpr std::uint8_t kHasWhen = 32;
constexpr std::uint8_t kOpMask = 7;
static_assert(static_cast<std::uint8_t>(kLastProbeOp) <= kOpMask);

// Smallest sizes of records, bytes.
constexpr std::size_t kStepRecord = 2;
constexpr std::size_t kJumpRecord = 2;
constexpr std::size_t kPointRecord = 6;
constexpr std::size_t kPouRecord = 12;

/// Seven bits in a byte, the lowest first; the top bit says that more follow.
void put_number(ByteWriter& out, std::uint64_t value) {
  for (; value >= 0x80; value >>= 7) out.put(static_cast<std::uint8_t>(value | 0x80));
  out.put(static_cast<std::uint8_t>(value));
}
std::uint64_t get_number(ByteReader& in) {
  std::uint64_t value = 0;
  for (unsigned shift = 0; shift < 64; shift += 7) {
    const auto byte = in.get<std::uint8_t>();
    value |= std::uint64_t{byte & 0x7fu} << shift;
    if (byte < 0x80) return value;
  }
  in.fail();
  return 0;
}
std::uint32_t get_u32(ByteReader& in) {
  const std::uint64_t value = get_number(in);
  if (value > 0xffffffffu) in.fail();
  return static_cast<std::uint32_t>(value);
}
/// Small differences in either direction are small numbers.
std::uint64_t folded(std::int64_t value) {
  return (static_cast<std::uint64_t>(value) << 1) ^ static_cast<std::uint64_t>(value >> 63);
}
std::int64_t unfolded(std::uint64_t value) { return static_cast<std::int64_t>(value >> 1 ^ (~(value & 1) + 1)); }
void put_difference(ByteWriter& out, std::int64_t value, std::int64_t before) {
  put_number(out,
             folded(static_cast<std::int64_t>(static_cast<std::uint64_t>(value) - static_cast<std::uint64_t>(before))));
}
std::int64_t get_difference(ByteReader& in, std::int64_t before) {
  return static_cast<std::int64_t>(static_cast<std::uint64_t>(before) +
                                   static_cast<std::uint64_t>(unfolded(get_number(in))));
}
std::uint32_t get_near(ByteReader& in, std::uint32_t before) {
  const std::int64_t value = get_difference(in, before);
  if (value < 0 || value > 0xffffffff) in.fail();
  return static_cast<std::uint32_t>(value);
}

void put_step(ByteWriter& out, const ProbeStep& step, const ProbeStep& before, std::uint32_t number) {
  out.put(static_cast<std::uint8_t>(static_cast<std::uint8_t>(step.op) | (step.order != 0 ? kHasOrder : 0) |
                                    (step.type != kNoProbeType ? kHasType : 0) |
                                    (step.when != kNoStep ? kHasWhen : 0)));
  put_difference(out, step.word, before.word);
  if (step.order != 0) put_number(out, step.order);
  // Operations count back to their operands.
  const bool counts = step.op >= ProbeOp::kAnd && step.op <= ProbeOp::kNot;
  if (counts) {
    put_difference(out, number, step.a);
    if (step.op != ProbeOp::kNot) put_difference(out, number, step.b);
  } else if (step.op == ProbeOp::kCapture || step.op == ProbeOp::kConst) {
    put_number(out, step.a);
    if (step.op == ProbeOp::kConst) put_number(out, step.b);
  }
  if (step.type != kNoProbeType) put_number(out, step.type);
  if (step.when != kNoStep) put_difference(out, number, step.when);
}

ProbeStep get_step(ByteReader& in, const ProbeStep& before, std::uint32_t number) {
  ProbeStep step;
  const auto head = in.get<std::uint8_t>();
  if ((head & kOpMask) > static_cast<std::uint8_t>(kLastProbeOp) || head >= 2 * kHasWhen) in.fail();
  step.op = static_cast<ProbeOp>(head & kOpMask);
  step.word = get_near(in, before.word);
  if ((head & kHasOrder) != 0) step.order = get_u32(in);
  const auto back = [&] {
    const std::int64_t value = std::int64_t{number} - unfolded(get_number(in));
    if (value < 0 || value >= kNoStep) in.fail();
    return static_cast<std::uint32_t>(value);
  };
  if (step.op >= ProbeOp::kAnd && step.op <= ProbeOp::kNot) {
    step.a = back();
    if (step.op != ProbeOp::kNot) step.b = back();
  } else if (step.op == ProbeOp::kCapture || step.op == ProbeOp::kConst) {
    step.a = get_u32(in);
    if (step.op == ProbeOp::kConst) step.b = get_u32(in);
  }
  if ((head & kHasType) != 0) step.type = get_u32(in);
  if ((head & kHasWhen) != 0) step.when = back();
  return step;
}

void put_point(ByteWriter& out, const ProbePoint& point, const ProbePoint& before) {
  put_difference(out, point.key.local_id, before.key.local_id);
  put_difference(out, point.key.line, before.key.line);
  put_number(out, point.key.column);
  put_number(out, point.key.pin);
  out.put(static_cast<std::uint8_t>(point.key.side));
  put_difference(out, point.step, before.step);
}

ProbePoint get_point(ByteReader& in, const ProbePoint& before) {
  ProbePoint point;
  point.key.local_id = get_difference(in, before.key.local_id);
  point.key.line = get_near(in, before.key.line);
  point.key.column = get_u32(in);
  const std::uint32_t pin = get_u32(in);
  if (pin > 0xffffu) in.fail();
  point.key.pin = static_cast<std::uint16_t>(pin);
  const auto side = in.get<std::uint8_t>();
  if (side > static_cast<std::uint8_t>(DrawnSide::kOutput)) in.fail();
  point.key.side = static_cast<DrawnSide>(side);
  point.step = get_near(in, before.step);
  return point;
}

}  // namespace

std::vector<std::byte> pack_probes(const std::vector<PouProbes>& probes) {
  ByteWriter out;
  out.put(static_cast<std::uint32_t>(probes.size()));
  for (const PouProbes& pou : probes) {
    out.put(static_cast<std::uint32_t>(pou.steps.size()));
    out.put(static_cast<std::uint32_t>(pou.jumps.size()));
    out.put(static_cast<std::uint32_t>(pou.points.size()));
    ProbeStep before;
    for (std::uint32_t i = 0; i < pou.steps.size(); ++i) {
      put_step(out, pou.steps[i], before, i);
      before = pou.steps[i];
    }
    for (const ProbeJump& jump : pou.jumps) {
      put_number(out, jump.word);
      put_number(out, jump.order);
    }
    ProbePoint last;
    for (const ProbePoint& point : pou.points) {
      put_point(out, point, last);
      last = point;
    }
  }
  return std::move(out.bytes());
}

bool unpack_probes(std::span<const std::byte> bytes, std::vector<PouProbes>& probes) {
  ByteReader in(bytes);
  const std::uint32_t pous = in.count(kPouRecord);
  probes.reserve(pous);
  for (std::uint32_t p = 0; p < pous && !in.failed(); ++p) {
    PouProbes& pou = probes.emplace_back();
    const auto count = [&](std::size_t record) {
      const auto n = in.get<std::uint32_t>();
      if (n > in.left() / record) in.fail();
      return in.failed() ? 0 : n;
    };
    const std::uint32_t steps = count(kStepRecord), jumps = count(kJumpRecord), points = count(kPointRecord);
    pou.steps.reserve(steps);
    for (std::uint32_t i = 0; i < steps && !in.failed(); ++i)
      pou.steps.push_back(get_step(in, i == 0 ? ProbeStep{} : pou.steps.back(), i));
    pou.jumps.reserve(jumps);
    for (std::uint32_t i = 0; i < jumps && !in.failed(); ++i) {
      const std::uint32_t word = get_u32(in);
      pou.jumps.push_back({word, get_u32(in)});
    }
    pou.points.reserve(points);
    for (std::uint32_t i = 0; i < points && !in.failed(); ++i)
      pou.points.push_back(get_point(in, i == 0 ? ProbePoint{} : pou.points.back()));
  }
  return !in.failed() && in.at_end();
}

}  // namespace plc::bytecode
