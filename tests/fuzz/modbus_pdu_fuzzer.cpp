// Fuzzes the PDU handler over a small map: every answer fits its request, and no variable gets a value it must not
// have.
//
// Input: requests one after another, each a byte with its length and so many bytes; a length of 0 runs the task
// once.
#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include "tests/support/modbus_oracle.h"
#include "tests/unit/modbus/plant.h"

namespace {

using namespace plc;

void expect(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "%s\n", what);
  std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static test::PlantPdu pdu;
  pdu.plant.resource->globals().reset();
  test::Bytes input(data, size);
  while (!input.empty()) {
    const std::size_t length = std::min<std::size_t>(input[0], input.size() - 1);
    const test::Pdu request(input.begin() + 1, input.begin() + 1 + static_cast<std::ptrdiff_t>(length));
    input = input.subspan(1 + length);
    if (request.empty()) {
      pdu.plant.scan();
      continue;
    }
    const std::string complaint = test::complaint(request, pdu.ask(request));
    expect(complaint.empty(), complaint.c_str());
  }
  pdu.plant.scan();
  const auto percent = pdu.plant.value<std::int16_t>("Percent");
  const auto wide = pdu.plant.value<std::int32_t>("PercentWide");
  expect(percent >= 0 && percent <= 100 && wide >= 0 && wide <= 100, "a subrange has a value outside its limits");
  expect(pdu.plant.value<std::int16_t>("Fixed") == 77, "a constant has changed");
  expect(pdu.plant.value<std::uint8_t>("Coils[0]") <= 1, "a BOOL is neither 0 nor 1");
  return 0;
}
