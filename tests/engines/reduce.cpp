#include "tests/engines/reduce.h"

#include <algorithm>
#include <cstdint>
#include <vector>

namespace plc::test {
namespace {

using bytecode::Image;
using bytecode::ImagePou;
using bytecode::Opcode;
using bytecode::OperandKind;

const bytecode::Operands& operands_at(const ImagePou& pou, std::size_t word) {
  return bytecode::info(static_cast<Opcode>(pou.code[word] & 0xffffu)).operands;
}
/// Where instructions begin, and the end.
std::vector<std::size_t> instructions(const ImagePou& pou) {
  std::vector<std::size_t> starts;
  std::size_t at = 0;
  for (; at < pou.code.size(); at += bytecode::words_of(operands_at(pou, at), pou.code[at] >> 16)) starts.push_back(at);
  starts.push_back(at);
  return starts;
}

/// The words from `first` to `last` out of the code; jumps to them go to what follows.
void cut(ImagePou& pou, std::size_t first, std::size_t last) {
  const std::vector<std::size_t> starts = instructions(pou);
  for (std::size_t i = 0; i + 1 < starts.size(); ++i) {
    const bytecode::Operands& operands = operands_at(pou, starts[i]);
    for (std::uint8_t n = 0; n < operands.count; ++n) {
      if (operands.specs[n].kind != OperandKind::kTarget) continue;
      std::uint32_t& target = pou.code[starts[i] + 1 + n];
      if (target >= last) {
        target -= static_cast<std::uint32_t>(last - first);
      } else if (target > first) {
        target = static_cast<std::uint32_t>(first);
      }
    }
  }
  pou.code.erase(pou.code.begin() + static_cast<std::ptrdiff_t>(first),
                 pou.code.begin() + static_cast<std::ptrdiff_t>(last));
  pou.debug.clear();
}

using Fails = std::function<bool(const Image&)>;

/// Drops runs of instructions of a body, long ones first. The RETURN at its end stays.
bool drop_instructions(Image& image, std::size_t pou, const Fails& fails) {
  bool dropped = false;
  for (std::size_t size = instructions(image.pous[pou]).size() / 2; size > 0; size /= 2) {
    for (std::size_t i = 0;;) {
      const std::vector<std::size_t> starts = instructions(image.pous[pou]);
      if (i + 2 >= starts.size()) break;
      Image smaller = image;
      cut(smaller.pous[pou], starts[i], starts[std::min(i + size, starts.size() - 2)]);
      if (fails(smaller)) {
        image = std::move(smaller);
        dropped = true;
      } else {
        i += size;
      }
    }
  }
  return dropped;
}

/// Drops records of boolean runs.
bool drop_records(Image& image, std::size_t pou, const Fails& fails) {
  bool dropped = false;
  for (std::size_t i = 0; i + 1 < instructions(image.pous[pou]).size(); ++i) {
    const std::size_t at = instructions(image.pous[pou])[i];
    if (static_cast<Opcode>(image.pous[pou].code[at] & 0xffffu) != Opcode::kBoolRun) continue;
    for (std::uint32_t count = image.pous[pou].code[at] >> 16, record = 0; count > 1 && record < count;) {
      Image smaller = image;
      const std::size_t first = at + 1 + std::size_t{record} * bytecode::kRecordWords;
      cut(smaller.pous[pou], first, first + bytecode::kRecordWords);
      smaller.pous[pou].code[at] = bytecode::opcode_word(Opcode::kBoolRun, count - 1);
      if (fails(smaller)) {
        image = std::move(smaller);
        dropped = true;
        --count;
      } else {
        ++record;
      }
    }
  }
  return dropped;
}

}  // namespace

Image reduce(Image image, const Fails& fails) {
  for (bool again = true; again;) {
    again = false;
    for (std::size_t pou = 0; pou < image.pous.size(); ++pou) {
      again |= drop_instructions(image, pou, fails);
      again |= drop_records(image, pou, fails);
    }
  }
  return image;
}

}  // namespace plc::test
