// THERMOSTAT: switches a heater, with a hysteresis so that it does not switch all the time.
#include <picard/taskblock.h>

#include <cmath>

class Thermostat final : public picard::Taskblock {
 public:
  static constexpr picard::Info info{
      .name = "THERMOSTAT",
      .group = "Heating",
      .summary = "Two-point controller with hysteresis.",
      .details =
          "HEAT becomes TRUE when PV is below SP - BAND / 2, FALSE when it is above SP + BAND / 2, and stays as it is "
          "between. A sensor that is broken (PV is no number) switches the heater off."};

  picard::Input<double> pv{this, "PV", "measured temperature", {.unit = "degC"}};
  picard::Input<double> sp{this, "SP", "wanted temperature", {.unit = "degC", .initial = "20.0"}};
  picard::Config<double> band{this, "BAND", "hysteresis", {.unit = "K", .lowest = 0, .initial = "1.0"}};
  picard::Output<bool> heat{this, "HEAT", "the heater is on"};
  picard::Output<std::uint32_t> starts{this, "STARTS", "how often it was switched on"};

  // Once, before the first cycle. Configuration ports have their values; files, threads and memory are taken here.
  void ready() override {
    if (std::isinf(band)) throw picard::Failure("BAND is not finite: the heater would stay as it is for ever");
  }

  // In every cycle: no allocation, no lock, nothing that waits.
  void fire() override {
    const bool was = heat;
    if (pv < sp - band / 2) heat = true;
    if (pv > sp + band / 2 || std::isnan(pv)) heat = false;
    if (heat && !was) starts = starts + 1;
  }
};

PICARD_LIBRARY("heating", "1.0.0", Thermostat)
