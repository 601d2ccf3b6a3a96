#include <dlfcn.h>
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <thread>

#include "bench/side.h"

namespace plc::bench {
namespace {

/// No value of C's differs from ours with these: no fused multiplication where the processor has one, no errno.
/// Hidden, as in a program: arrays are reached without a table of addresses.
constexpr const char* kFlags = "-O2 -fno-math-errno -ffp-contract=off -fPIC -fvisibility=hidden";
constexpr const char* kVisible = "__attribute__((visibility(\"default\"))) ";

/// plc_variables: where all that is compared lies. Since others can see it, the compiler keeps every store.
std::string table_of_variables(const Source& source) {
  std::string out = fmt::format("{}void *plc_variables[] = {{\n", kVisible);
  for (const Variable& variable : source.variables) out += fmt::format("  &{},\n", variable.c);
  return out + "};\n";
}

/// Runs all commands, as many at a time as there are processors. False when one failed.
bool run_all(const std::vector<std::string>& commands) {
  std::atomic<std::size_t> next = 0;
  std::atomic<bool> good = true;
  std::vector<std::jthread> workers;
  for (unsigned i = 0; i < std::max(1u, std::thread::hardware_concurrency()); ++i) {
    workers.emplace_back([&] {
      for (std::size_t c = next++; c < commands.size(); c = next++) {
        if (std::system(commands[c].c_str()) != 0) good = false;
      }
    });
  }
  workers.clear();
  return good;
}

class CSide final : public Side {
 public:
  explicit CSide(void* library) : library_(library) {}
  ~CSide() override { ::dlclose(library_); }
  CSide(const CSide&) = delete;
  CSide& operator=(const CSide&) = delete;

  bool find(std::size_t count) {
    scan_ = reinterpret_cast<void (*)(long long)>(::dlsym(library_, "plc_scan"));
    auto* const table = static_cast<unsigned char**>(::dlsym(library_, "plc_variables"));
    if (scan_ == nullptr || table == nullptr) {
      std::cerr << "the C defines no plc_scan\n";
      return false;
    }
    variables_.assign(table, table + count);
    return true;
  }
  bool scan(core::TimeNs now_ns) override {
    scan_(now_ns);
    return true;
  }

 private:
  void* library_;
  void (*scan_)(long long) = nullptr;
};

}  // namespace

std::unique_ptr<Side> make_c_side(const Source& source, bool barriers) {
  const Scratch scratch;
  const std::string object = scratch.file("scan.so");
  std::string link = fmt::format("{} -shared -o {}", PLC_C_COMPILER, object);
  std::vector<std::string> commands;
  for (std::size_t i = 0; i < source.c.size(); ++i) {
    const std::string name = scratch.file(std::to_string(i));
    std::ofstream(name + ".c") << kVisible << "void plc_scan(long long);\n"
                               << source.c[i] << (i + 1 == source.c.size() ? table_of_variables(source) : "");
    commands.push_back(
        fmt::format("{} {} {} -c -o {}.o {}.c", PLC_C_COMPILER, kFlags, barriers ? "" : "-DBARRIER=", name, name));
    link += fmt::format(" {}.o", name);
  }
  if (!run_all(commands) || !run_all({link + " -lm"})) return nullptr;
  void* const library = ::dlopen(object.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) {
    std::cerr << ::dlerror() << '\n';
    return nullptr;
  }
  auto side = std::make_unique<CSide>(library);
  return side->find(source.variables.size()) ? std::move(side) : nullptr;
}

}  // namespace plc::bench
