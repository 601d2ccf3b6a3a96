#include <picard/testing.h>

#include <cmath>
#include <cstdio>

extern "C" const picard_library* picard_library_v1(void);

namespace {

int failures = 0;

void expect(bool good, const char* what) {
  if (good) return;
  std::printf("failed: %s\n", what);
  ++failures;
}

}  // namespace

int main() {
  picard::Instance thermostat(picard_library_v1(), "THERMOSTAT", std::chrono::milliseconds(100));
  thermostat.port<double>("BAND") = 2.0;
  thermostat.ready();
  const auto heats_at = [&thermostat](double temperature) {
    thermostat.port<double>("PV") = temperature;
    thermostat.fire();
    return thermostat.port<bool>("HEAT");
  };
  expect(thermostat.port<double>("SP") == 20.0, "SP has the initial value of its declaration");
  expect(!heats_at(19.5), "off within the band, as it was");
  expect(heats_at(18.9), "on below the band");
  expect(heats_at(20.5), "on within the band, as it was");
  expect(!heats_at(21.1), "off above the band");
  expect(heats_at(10.0), "on again");
  expect(!heats_at(std::nan("")), "off without a measurement");
  expect(thermostat.port<std::uint32_t>("STARTS") == 2, "switched on twice");
  return failures == 0 ? 0 : 1;
}
