// Calls of functions, on any processor: what is passed in and out.
#include <cstring>

#include "native/helpers.h"
#include "native/translate.h"
#include "runtime/interpreter/operations.h"

namespace plc::native {
namespace {

/// Initial values of a function's frame that are written by instructions of their own; more is copied.
constexpr std::uint32_t kInlineFrameBytes = 64;

}  // namespace

void reset_frame(Emitter& s, std::uint32_t frame, const std::byte* initial, std::uint32_t bytes) {
  if (bytes > kInlineFrameBytes) {
    s.pass(2, bytes);
    s.pass(1, reinterpret_cast<std::uint64_t>(initial));
    s.pass_address(0, frame);
    return s.call_address(reinterpret_cast<std::uint64_t>(&std::memcpy));
  }
  for (std::uint32_t at = 0; at < bytes;) {
    const unsigned step = bytes - at >= 8 ? 8 : bytes - at >= 4 ? 4 : bytes - at >= 2 ? 2 : 1;
    std::uint64_t value = 0;
    std::memcpy(&value, initial + at, step);
    s.store_constant(frame + at, step, value);
    at += step;
  }
}

void pass_argument(Emitter& s, std::uint32_t position, const std::uint32_t* argument) {
  switch (argument[2]) {
    case 1:
    case 2:
    case 4:
    case 8:
      return s.move(argument[0], argument[1], argument[2]);
    case runtime::kPassStr:
    case runtime::kPassWstr:
      break;
    default:
      s.pass(2, argument[2]);
      s.pass_address(1, argument[1]);
      s.pass_address(0, argument[0]);
      return s.call_address(reinterpret_cast<std::uint64_t>(&std::memmove));
  }
  s.pass(3, argument[2] == runtime::kPassStr ? 1 : 2);
  s.pass(2, argument[3]);
  s.pass_address(1, argument[1]);
  s.pass_address(0, argument[0]);
  s.call(&copy_text);
  const asmjit::Label cut = s.label();
  const asmjit::Label done = s.label();
  s.jump_if_result(false, cut);
  s.bind(done);
  s.cold_path([&s, cut, done, position] {
    s.land(cut);
    s.raise(position, static_cast<int>(stdlib::Event::kTruncated));
    s.jump(done);
  });
}

}  // namespace plc::native
