#include <dlfcn.h>
#include <fmt/format.h>
#include <link.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <map>
#include <span>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "bench/scratch.h"
#include "bench/side.h"
#include "bench/taskblock_types.h"
#include "picard/taskblock.h"

namespace plc::bench {
namespace {

/// No value of C's differs from ours with these: no fused multiplication where the processor has one, no errno.
/// Hidden, as in a program: arrays are reached without a table of addresses.
constexpr const char* kFlags = "-O2 -fno-math-errno -ffp-contract=off -fPIC -fvisibility=hidden";

constexpr const char* kShown = "__attribute__((visibility(\"default\"))) ";

/// plc_variables: where all that is compared lies. Since others can see it, the compiler keeps every store.
std::string table_of_variables(const Source& source) {
  std::string out = fmt::format("{}void *plc_variables[] = {{\n", kShown);
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

  /// `image`: of taskblocks, whose objects need ports to be bound to.
  bool find(const bytecode::VerifiedImage& image, const Source& source) {
    scan_ = reinterpret_cast<void (*)(long long)>(symbol("plc_scan"));
    if (scan_ == nullptr) return false;
    footprint_ = footprint();
    if (source.taskblocks == 0) {
      auto* const table = static_cast<unsigned char**>(symbol("plc_variables"));
      if (table != nullptr) variables_.assign(table, table + source.variables.size());
      return table != nullptr;
    }
    made_taskblocks().clear();
    owner_ = make_plc_side(image, source, Engine::kInterpreter);
    struct Call {
      int (*fire)(void* object, picard_failure* failure);
      void* object;
    };
    auto* const calls = static_cast<Call*>(symbol("plc_calls"));
    auto* const failure = static_cast<picard_failure**>(symbol("plc_failure"));
    if (owner_ == nullptr || calls == nullptr || failure == nullptr) return false;
    const std::vector<void*>& made = made_taskblocks();
    if (made.size() != source.taskblocks) return false;
    for (std::size_t i = 0; i < made.size(); ++i) {
      calls[i] = {bench_taskblocks().find("ONE_WORKING")->block->fire, made[i]};
    }
    *failure = &failure_;
    variables_ = owner_->variables();
    return true;
  }
  bool scan(core::TimeNs now_ns) override {
    scan_(now_ns);
    return true;
  }

 private:
  void* symbol(const char* name) {
    void* const found = ::dlsym(library_, name);
    if (found == nullptr) std::cerr << "the C does not show " << name << '\n';
    return found;
  }

  /// Of what the loader maps: what may be executed, and what may be written, less the little that it adds itself.
  Footprint footprint() const {
    struct Search {
      ElfW(Addr) base = 0;
      Footprint found;
    } search;
    const link_map* map = nullptr;
    if (::dlinfo(library_, RTLD_DI_LINKMAP, &map) != 0) return {};
    search.base = map->l_addr;
    ::dl_iterate_phdr(
        [](dl_phdr_info* object, std::size_t, void* into) {
          Search& s = *static_cast<Search*>(into);
          if (object->dlpi_addr != s.base) return 0;
          for (const ElfW(Phdr) & part : std::span(object->dlpi_phdr, object->dlpi_phnum)) {
            if (part.p_type != PT_LOAD) continue;
            if ((part.p_flags & PF_X) != 0) s.found.code += part.p_memsz;
            // Without the table of what is compared, which the file holds and no scan reads.
            if ((part.p_flags & PF_W) != 0) s.found.data += part.p_memsz - part.p_filesz;
          }
          return 1;
        },
        &search);
    return search.found;
  }

  void* library_;
  std::unique_ptr<Side> owner_;  ///< of the taskblocks; never runs
  picard_failure failure_{};
  void (*scan_)(long long) = nullptr;
};

/// The shared object of the C, made once: several workloads may have the same. Empty when that fails. It must not be
/// opened twice at a time, since its variables are then the same.
std::string shared_object(const Source& source, bool barriers) {
  static const Scratch kept;
  static std::map<std::string, std::string> made;  ///< by all that decides what it is
  std::vector<std::string> texts;
  std::string key = barriers ? "with" : "without";
  for (const std::string& c : source.c) texts.push_back(std::string(kShown) + "void plc_scan(long long);\n" + c);
  if (source.taskblocks == 0) texts.back() += table_of_variables(source);
  for (const std::string& text : texts) key += text;
  const auto [place, added] = made.try_emplace(std::move(key));
  if (!added) return place->second;

  const Scratch scratch;
  const std::string object = kept.file(fmt::format("scan{}.so", made.size()));
  std::string link = fmt::format("{} -shared -o {}", PLC_C_COMPILER, object);
  std::vector<std::string> commands;
  for (std::size_t i = 0; i < texts.size(); ++i) {
    const std::string name = scratch.file(std::to_string(i));
    std::ofstream(name + ".c") << texts[i];
    commands.push_back(
        fmt::format("{} {} {} -c -o {}.o {}.c", PLC_C_COMPILER, kFlags, barriers ? "" : "-DBARRIER=", name, name));
    link += fmt::format(" {}.o", name);
  }
  if (run_all(commands) && run_all({link + " -lm"})) place->second = object;
  return place->second;
}

}  // namespace

std::unique_ptr<Side> make_c_side(const bytecode::VerifiedImage& image, const Source& source, bool barriers) {
  const std::string object = shared_object(source, barriers);
  if (object.empty()) return nullptr;
  void* const library = ::dlopen(object.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) {
    std::cerr << ::dlerror() << '\n';
    return nullptr;
  }
  auto side = std::make_unique<CSide>(library);
  return side->find(image, source) ? std::move(side) : nullptr;
}

}  // namespace plc::bench
