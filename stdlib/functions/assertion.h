// Row: ASSERT, which the fourth edition of IEC 61131-3 adds.
#pragma once

#include "stdlib/row.h"

namespace plc::stdlib::rows {

struct Assert {
  static constexpr Example examples[] = {{"", "ASSERT(TRUE)", "TRUE"}, {"", "ASSERT(FALSE)", "event:assertion FALSE"}};
  static constexpr FunctionSpec spec{
      .name = "ASSERT",
      .params = {{"IN", fixed(TypeId::kBool)}},
      .param_count = 1,
      .result = fixed(TypeId::kBool),
      .foldable = false,
      .events = events(Event::kAssertion),
      .clause = "IEC 61131-3:2025",
      .summary = "IN, which has to be TRUE: FALSE is an event that is counted with its place, and nothing else.",
      .examples = examples};
  template <class V>
  static V eval(V in, Event& event) noexcept {
    if (in == 0) event = Event::kAssertion;
    return in;
  }
  template <TypeId, TypeId>
  static constexpr Kernel kernel = &unary<Assert, std::uint8_t>;
};

using AssertionRows = Rows<Assert>;

}  // namespace plc::stdlib::rows
