// The programs that PLCs are compared with, in the interpreter and as C -O2: "math", 100,000 products of two REALs
// converted to DINT; "bubble", 1,000 DINTs sorted from reverse order, the worst case.
#include <dlfcn.h>
#include <fmt/format.h>

#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "bench/bench.h"
#include "core/clock.h"
#include "runtime/access.h"
#include "runtime/resource.h"
#include "tools/pipeline.h"

namespace plc::bench {
namespace {

struct Known {
  const char* name;
  const char* what;
  const char* st;     ///< body and variables of the program; its result is the array `out`
  const char* c;      ///< void plc_scan(void), and the array plc_out
  std::size_t bytes;  ///< of the array
  double limit;       ///< most that interpreter / C may be; 0 = none
};

// The inputs are made once, in the first scan: they are not what is measured.
constexpr Known kKnown[] = {
    {"math", "100,000 REAL products to DINT",
     R"(PROGRAM Main
VAR
  a, b : ARRAY[0..99999] OF REAL;
  out : ARRAY[0..99999] OF DINT;
  i : DINT;
  made : BOOL;
END_VAR
IF NOT made THEN
  FOR i := 0 TO 99999 DO
    a[i] := DINT_TO_REAL(i) / 7.0;
    b[i] := DINT_TO_REAL(i MOD 1000) - 499.5;
  END_FOR;
  made := TRUE;
END_IF;
FOR i := 0 TO 99999 DO
  out[i] := REAL_TO_DINT(a[i] * b[i]);
END_FOR;
END_PROGRAM
)",
     R"(#include <math.h>
int plc_out[100000];
static float a[100000], b[100000];
static unsigned char made;
void plc_scan(void) {
  if (!made) {
    for (int i = 0; i < 100000; ++i) {
      a[i] = (float)i / 7.0f;
      b[i] = (float)(i % 1000) - 499.5f;
    }
    made = 1;
  }
  for (int i = 0; i < 100000; ++i) plc_out[i] = (int)lrintf(a[i] * b[i]);
}
)",
     400'000, 0},
    {"bubble", "bubble sort of 1,000 DINTs in reverse order",
     R"(PROGRAM Main
VAR
  out : ARRAY[0..999] OF DINT;
  i, keep : DINT;
  swapped : BOOL;
END_VAR
FOR i := 0 TO 999 DO
  out[i] := 1000 - i;
END_FOR;
REPEAT
  swapped := FALSE;
  FOR i := 1 TO 999 DO
    IF out[i - 1] > out[i] THEN
      keep := out[i];
      out[i] := out[i - 1];
      out[i - 1] := keep;
      swapped := TRUE;
    END_IF;
  END_FOR;
UNTIL NOT swapped
END_REPEAT;
END_PROGRAM
)",
     R"(int plc_out[1000];
void plc_scan(void) {
  unsigned char swapped;
  for (int i = 0; i <= 999; ++i) plc_out[i] = 1000 - i;
  do {
    swapped = 0;
    for (int i = 1; i <= 999; ++i) {
      if (plc_out[i - 1] > plc_out[i]) {
        const int keep = plc_out[i];
        plc_out[i] = plc_out[i - 1];
        plc_out[i - 1] = keep;
        swapped = 1;
      }
    }
  } while (swapped);
}
)",
     4'000, 0},
};

constexpr const char* kConfiguration = R"(CONFIGURATION Plant
RESOURCE Cpu ON Plc
  TASK Cycle(INTERVAL := T#1s, PRIORITY := 0);
  PROGRAM P WITH Cycle : Main;
END_RESOURCE
END_CONFIGURATION
)";

class Compiled {
 public:
  Compiled(const Known& known, const Scratch& scratch) {
    const std::string path = scratch.file(std::string(known.name) + ".st");
    std::ofstream(path) << known.st << kConfiguration;
    tools::Compilation compilation;
    tools::compile({path, {}, tools::Goal::kRun}, compilation);
    if (!compilation.ok()) {
      compilation.diagnostics.render(std::cerr);
      return;
    }
    runtime::ProgramOptions options;
    options.loop_budget = 10'000'000;  // a thousand passes over a thousand elements
    auto loaded = runtime::Resource::load(std::move(*compilation.image), options);
    if (!loaded) {
      std::cerr << loaded.error().message << '\n';
      return;
    }
    const auto place = runtime::Access(**loaded).find("P.out[0]");
    if (!place || place->task == runtime::Place::kGlobal) return;
    resource_ = std::move(*loaded);
    out_ = resource_->program(place->task).table().data() + place->offset;
  }
  [[nodiscard]] bool ok() const { return resource_ != nullptr; }
  [[nodiscard]] bool scan() { return !resource_->program(0).execute({0}); }
  [[nodiscard]] const std::byte* out() const { return out_; }

 private:
  std::unique_ptr<runtime::Resource> resource_;
  const std::byte* out_ = nullptr;
};

class Native {
 public:
  Native(const Known& known, const Scratch& scratch) {
    const std::string source = scratch.file(std::string(known.name) + ".c");
    const std::string object = scratch.file(std::string(known.name) + ".so");
    std::ofstream(source) << known.c;
    const std::string command =
        fmt::format("{} -O2 -fno-math-errno -shared -fPIC -o {} {} -lm", PLC_C_COMPILER, object, source);
    if (std::system(command.c_str()) != 0) return;
    library_ = ::dlopen(object.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (library_ == nullptr) return;
    scan_ = reinterpret_cast<void (*)()>(::dlsym(library_, "plc_scan"));
    out_ = static_cast<const std::byte*>(::dlsym(library_, "plc_out"));
  }
  ~Native() {
    if (library_ != nullptr) ::dlclose(library_);
  }
  Native(const Native&) = delete;
  Native& operator=(const Native&) = delete;
  [[nodiscard]] bool ok() const { return scan_ != nullptr; }
  void scan() { scan_(); }
  [[nodiscard]] const std::byte* out() const { return out_; }

 private:
  void* library_ = nullptr;
  void (*scan_)() = nullptr;
  const std::byte* out_ = nullptr;
};

Verdict measure(const Known& known, const StPlan& plan) {
  Verdict verdict;
  const Scratch scratch;
  Compiled compiled(known, scratch);
  Native native(known, scratch);
  std::string line = fmt::format("{:<6} {}: ", known.name, known.what);
  if (!compiled.ok() || !native.ok()) {
    std::cout << line << "could not be built\n";
    verdict.correct = false;
    return verdict;
  }
  const auto same = [&] {
    native.scan();
    return compiled.scan() && std::memcmp(compiled.out(), native.out(), known.bytes) == 0;
  };
  verdict.correct = same() && same();
  line += verdict.correct ? "results equal" : "RESULTS DIFFER";
  if (verdict.correct && plan.batches != 0) {
    const core::MonotonicClock clock;
    std::vector<double> c, vm, ratios;
    for (std::uint32_t i = 0; i < plan.batches; ++i) {
      const core::TimeNs begin = clock.now_ns();
      native.scan();
      const core::TimeNs middle = clock.now_ns();
      verdict.correct = compiled.scan() && verdict.correct;
      c.push_back(static_cast<double>(middle - begin) / 1e6);
      vm.push_back(static_cast<double>(clock.now_ns() - middle) / 1e6);
      ratios.push_back(vm.back() / c.back());
    }
    verdict.correct = same() && verdict.correct;
    line += fmt::format("; C {:.3f}, interpreter {:.3f} ms, ratio {:.1f}", median(c), median(vm), median(ratios));
    if (known.limit != 0) line += ", " + limit_text(median(ratios), known.limit, verdict);
  }
  std::cout << line << std::endl;
  return verdict;
}

}  // namespace

Verdict measure_st(const StPlan& plan) {
  Verdict verdict;
  for (const Known& known : kKnown) verdict.merge(measure(known, plan));
  return verdict;
}

}  // namespace plc::bench
