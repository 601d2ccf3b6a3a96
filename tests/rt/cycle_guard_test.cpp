// The cycle allocates nothing and makes no system call but to sleep and to read the clock: every instruction runs on
// the scheduler's own thread with malloc watched and all other system calls forbidden by the kernel. Planted violations
// prove that the guards bite. Each case runs in a child process, since the kernel's answer to a violation is to kill
// it.
#include <gtest/gtest.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <sstream>
#include <thread>

#include "bytecode/image.h"
#include "io-drivers/modbus/server.h"
#include "runtime/record/recorder.h"
#include "runtime/resource.h"
#include "runtime/sched/realtime.h"
#include "tests/support/image_builder.h"
#include "tests/support/modbus_client.h"

namespace {
thread_local bool armed = false;
std::atomic<bool> allocated{false};
}  // namespace

// glibc's own entry points, so that every allocation of the process passes here.
extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* block, std::size_t size);
void __libc_free(void* block);
void* malloc(std::size_t size) {
  if (armed) allocated = true;
  return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) {
  if (armed) allocated = true;
  return __libc_calloc(count, size);
}
void* realloc(void* block, std::size_t size) {
  if (armed) allocated = true;
  return __libc_realloc(block, size);
}
void free(void* block) {
  if (armed && block != nullptr) allocated = true;
  __libc_free(block);
}
}

namespace plc::test {
namespace {

using bytecode::opcode_word;
using bytecode::OperandKind;
using core::Rep;

constexpr int kExitClean = 0;
constexpr int kExitAllocated = 3;
constexpr int kExitStuck = 4;
constexpr int kExitNoServer = 5;
constexpr int kExitNoPriority = 6;
constexpr int kExitNoFilter = 77;

/// Forbids the calling thread every system call but two and `other`; the kernel kills the process at the first one.
bool forbid_system_calls(unsigned other) {
  sock_filter program[] = {
      BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr)),
      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_clock_nanosleep, 3, 0),
      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_clock_gettime, 2, 0),
      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, other, 1, 0),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_KILL_PROCESS),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
  };
  const sock_fprog filter{static_cast<unsigned short>(std::size(program)), program};
  return prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 && prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &filter) == 0;
}

template <unsigned kOther = SYS_clock_gettime>
void guard_thread(std::uint32_t) {
  if (!forbid_system_calls(kOther)) _exit(kExitNoFilter);
  armed = true;
}

/// Watches allocation alone: a thread's first allocation may map memory, and the filter would kill before the counter
/// is read.
void watch_allocations(std::uint32_t) { armed = true; }

TypeId type_with(Rep rep) {
  constexpr TypeId kIds[] = {TypeId::kBool,  TypeId::kSint, TypeId::kUsint, TypeId::kInt,  TypeId::kUint, TypeId::kDint,
                             TypeId::kUdint, TypeId::kLint, TypeId::kUlint, TypeId::kReal, TypeId::kLreal};
  return kIds[static_cast<std::size_t>(rep)];
}

/// A program with every instruction of opcodes.def, in a fixed and in a relative body.
struct EveryInstruction {
  ImageBuilder b;

  explicit EveryInstruction(core::Coherence coherence) {
    b.image.options.coherence = coherence;
    const std::uint32_t dint = b.type(TypeId::kDint);
    b.global("shared", dint);
    PouBuilder leaf = b.pou("Leaf", PouKind::kFunctionBlock);
    const Word n = leaf.variable("n", dint);
    leaf.op(Opcode::kAdd32, {n, n, b.constant<std::int32_t>(TypeId::kDint, 1)});
    const std::uint32_t leaf_pou = leaf.finish();
    PouBuilder function = b.pou("Fn", PouKind::kFunction);
    const Word in = function.frame("in", dint, FieldRole::kInput);
    const Word out = function.frame("Fn", dint, FieldRole::kReturnValue);
    function.op(Opcode::kMove32, {out, in});
    const std::uint32_t function_pou = function.finish();

    PouBuilder all = b.pou("All", PouKind::kFunctionBlock);
    plain(all);
    references(all, leaf_pou);
    const Word value = all.variable("value", dint);
    all.list(Opcode::kCallFn, 2, {function_pou, 0, value, 1, value});
    all.call_std("LIMIT:DINT", value, {value, value, value});
    const Word text = all.variable("text", b.string(3));
    all.op(Opcode::kMoveStr, {text, b.text("longer")});
    const Word wide = all.variable("wide", b.string(3, TypeId::kWstring));
    all.op(Opcode::kMoveWstr, {wide, wide});
    const Word timer = all.variable("timer", b.block_type("TON"));
    all.op(Opcode::kRunTb, {b.block("TON"), timer});
    control(all);
    const std::uint32_t all_pou = all.finish();

    PouBuilder main = b.pou("Main", PouKind::kProgram);
    const Word first = main.instance_of("first", all_pou);
    const Word second = main.instance_of("second", all_pou);
    main.op(Opcode::kCallPou, {all_pou, first});
    main.op(Opcode::kCallPou, {all_pou, second});
    plain(main);
    const std::uint32_t main_pou = main.finish();
    PouBuilder other = b.pou("Other", PouKind::kProgram);
    plain(other);
    const std::uint32_t other_pou = other.finish();
    b.task("Cyclic", 1'000'000, {main_pou});
    b.task("Second", 1'000'000, {other_pou});
    bytecode::Image image = b.build();
    // One task exports everything, the other what it changed.
    for (bytecode::ImagePou& pou : image.pous) {
      if (pou.kind != PouKind::kTask || pou.name != "Second") continue;
      pou.code.insert(pou.code.end() - 1, {opcode_word(Opcode::kRaisePriority), 0, 1, opcode_word(Opcode::kReschedule),
                                           opcode_word(Opcode::kLock), opcode_word(Opcode::kUnlock)});
      for (std::uint32_t& word : pou.code) {
        if (word == opcode_word(Opcode::kWriteChangedN)) word = opcode_word(Opcode::kWriteN);
      }
    }
    b.image = image;
  }

  /// Every row whose operands are only leaves of numbers and BOOLs, and records in two shapes.
  void plain(PouBuilder& pou) {
    std::array<Word, 11> places{};
    for (std::size_t rep = 0; rep < places.size(); ++rep) {
      places[rep] = pou.variable("v" + std::to_string(rep), b.type(type_with(static_cast<Rep>(rep))));
    }
    for (std::size_t code = 0; code < bytecode::opcodes().size(); ++code) {
      const auto opcode = static_cast<Opcode>(code);
      const bytecode::Operands& operands = bytecode::info(opcode).operands;
      std::vector<Word> words;
      for (std::uint8_t i = 0; i < operands.count; ++i) {
        const bytecode::OperandSpec& spec = operands.specs[i];
        const bool leaf = spec.kind == OperandKind::kIn || spec.kind == OperandKind::kOut;
        for (std::size_t rep = 0; leaf && rep < places.size(); ++rep) {
          if ((spec.reps >> rep & 1u) == 0) continue;
          words.push_back(places[rep]);
          break;
        }
      }
      const bool complete = words.size() == operands.count;
      const bool of_tasks = opcode == Opcode::kReschedule || opcode == Opcode::kLock || opcode == Opcode::kUnlock;
      if (complete && opcode != Opcode::kReturn && !of_tasks) pou.list(opcode, 0, words);
    }
    pou.record(0x00010001u, places[0], {places[0]});
    pou.record(0x12345678u, places[0], {places[0]});
  }

  void references(PouBuilder& pou, std::uint32_t fb) {
    const std::uint32_t dint = b.type(TypeId::kDint);
    const std::uint32_t array = b.array(dint, 3);
    const std::uint32_t record = b.structure("R", {{"f", dint}});
    const std::uint32_t fb_type = b.image.pous[fb].instance_type;
    const std::uint32_t ton_type = b.block_type("TON");
    const Word a = pou.variable("a", array);
    const Word r = pou.variable("r", record);
    const Word x = pou.variable("x", dint);
    const Word i = pou.variable("i", b.type(TypeId::kLint));
    const Word instance = pou.instance_of("instance", fb);
    const Word ton = pou.variable("ton", ton_type);
    const Word to_array = pou.variable("to_array", b.ref(array));
    const Word to_record = pou.variable("to_record", b.ref(record));
    const Word to_dint = pou.variable("to_dint", b.ref(dint));
    const Word to_null = pou.variable("to_null", b.ref(dint));
    const Word to_fb = pou.variable("to_fb", b.ref(fb_type));
    const Word to_ton = pou.variable("to_ton", b.ref(ton_type));
    pou.path(Opcode::kRefAt, {to_array, a, array}, {});
    pou.path(Opcode::kRefVia, {to_dint, to_array, array}, {{PathStep::kIndex, i}});
    pou.path(Opcode::kLoadVia, {x, to_dint, dint}, {});
    pou.path(Opcode::kRefAt, {to_record, r, record}, {});
    pou.path(Opcode::kRefVia, {to_dint, to_record, record}, {{PathStep::kField, 0}});
    pou.op(Opcode::kMoveRef, {to_dint, to_dint});
    const Word same = pou.variable("same", b.boolean());
    pou.op(Opcode::kSameRef, {same, to_dint, to_null});
    pou.path(Opcode::kStoreVia, {to_dint, x, dint}, {});
    const Word pointer = pou.variable("pointer", b.type(TypeId::kPointer));
    const Word address = pou.variable("address", b.type(TypeId::kDword));
    pou.path(Opcode::kAdrAt, {pointer, r, record}, {});
    pou.path(Opcode::kAdrVia, {pointer, to_record, record}, {{PathStep::kField, 0}});
    pou.path(Opcode::kAdrPtr, {pointer, pointer, dint}, {});
    pou.path(Opcode::kLoadPtr, {x, pointer, dint}, {});
    pou.path(Opcode::kStorePtr, {pointer, x, dint}, {});
    pou.path(Opcode::kRefPtr, {to_dint, pointer, dint}, {});
    pou.op(Opcode::kPtrTo32, {address, pointer});
    pou.op(Opcode::kPtrFrom32, {pointer, address});
    pou.path(Opcode::kLoadVia, {x, to_null, dint}, {});
    pou.path(Opcode::kRefAt, {to_fb, instance, fb_type}, {});
    pou.path(Opcode::kCallVia, {fb, to_fb, fb_type}, {});
    pou.path(Opcode::kCallAt, {fb, instance, fb_type}, {});
    pou.path(Opcode::kRefAt, {to_ton, ton, ton_type}, {});
    pou.path(Opcode::kRunVia, {b.block("TON"), to_ton, ton_type}, {});
    pou.path(Opcode::kRunAt, {b.block("TON"), ton, ton_type}, {});
    pou.op(Opcode::kCopy, {a, a, array});
    elements(pou);
    // A queue that runs full and empty.
    b.image.queues.push_back({"queue", record, 2, {0}, 0});
    const Word count = pou.variable("count", b.type(TypeId::kUdint));
    for (const Opcode opcode : {Opcode::kQueuePut, Opcode::kQueueGet}) {
      for (int n = 0; n < 3; ++n) pou.op(opcode, {same, 0, r, record});
    }
    pou.op(Opcode::kQueueCount, {count, 0});
    pou.op(Opcode::kQueueSpace, {count, 0});
    const Word word = pou.variable("word", b.type(TypeId::kWord));
    const Word bit = pou.variable("bit", b.boolean());
    pou.op(Opcode::kExtract, {bit, word, 15});
    pou.op(Opcode::kInsert, {word, word, bit, 0});
  }

  /// Accesses in all the forms that the linker has for them; the last two indices are out of bounds.
  void elements(PouBuilder& pou) {
    for (const TypeId element : {TypeId::kUsint, TypeId::kInt, TypeId::kDint, TypeId::kLint}) {
      const std::uint32_t array = b.array(b.type(element), 3);
      const std::string name(core::name_of(element));
      const Word values = pou.variable("a" + name, array);
      const Word value = pou.variable("x" + name, b.type(element));
      const Word ref = pou.variable("r" + name, b.ref(array));
      pou.path(Opcode::kRefAt, {ref, values, array}, {});
      for (const TypeId index : {TypeId::kInt, TypeId::kDint, TypeId::kUsint}) {
        const Word i = pou.variable("i" + name + std::string(core::name_of(index)), b.type(index));
        pou.path(Opcode::kLoadAt, {value, values, array}, {{PathStep::kIndex, i}});
        pou.path(Opcode::kStoreAt, {values, value, array}, {{PathStep::kIndex, i}});
        pou.path(Opcode::kLoadVia, {value, ref, array}, {{PathStep::kIndex, i}});
        pou.path(Opcode::kStoreVia, {ref, value, array}, {{PathStep::kIndex, i}});
      }
      const Word bad = pou.variable("bad" + name, b.type(TypeId::kInt), FieldRole::kLocal, bytes_of<std::int16_t>(9));
      pou.path(Opcode::kLoadAt, {value, values, array}, {{PathStep::kIndex, bad}});
    }
    const std::uint32_t texts = b.array(b.string(4), 2);
    const std::uint32_t grid = b.array(texts, 2);
    const Word values = pou.variable("grid", grid);
    const Word text = pou.variable("line", b.string(9));
    const Word i = pou.variable("row", b.type(TypeId::kInt));
    pou.path(Opcode::kLoadAt, {text, values, grid}, {{PathStep::kIndex, i}, {PathStep::kIndex, i}});
    pou.path(Opcode::kStoreAt, {values, text, grid}, {{PathStep::kIndex, i}, {PathStep::kIndex, i}});
  }

  void control(PouBuilder& pou) {
    const std::uint32_t lint = b.type(TypeId::kLint);
    const Word i = pou.variable("loop", lint);
    const Word go = pou.variable("go", b.boolean());
    const Word three = b.constant<std::int64_t>(TypeId::kLint, 3);
    pou.op(Opcode::kMove64, {i, b.constant<std::int64_t>(TypeId::kLint, 0)});
    const std::uint32_t top = pou.here();
    pou.op(Opcode::kAdd64, {i, i, b.constant<std::int64_t>(TypeId::kLint, 1)});
    pou.op(Opcode::kLtI64, {go, i, three});
    const std::uint32_t out = pou.jump(Opcode::kCondJump, {go});
    pou.op(Opcode::kLoopJump, {top});
    pou.land(out);
    const std::uint32_t off = pou.jump(Opcode::kJumpIf, {go});
    pou.land(off);
    const std::uint32_t on = pou.jump(Opcode::kJump);
    pou.land(on);
  }
};

std::unique_ptr<runtime::Resource> load_every_instruction(core::Coherence coherence = core::Coherence::kWaitFree) {
  EveryInstruction every(coherence);
  core::Diagnostics diagnostics;
  auto verified = bytecode::verify(every.b.image, diagnostics);
  std::ostringstream text;
  diagnostics.render(text);
  EXPECT_TRUE(verified.has_value()) << text.str();
  if (!verified) return nullptr;
  auto resource = runtime::Resource::load(std::move(*verified));
  EXPECT_TRUE(resource.has_value());
  return resource ? std::move(*resource) : nullptr;
}

/// Two clients that read and write the global all tasks share, as fast as they can.
class HmiLoad {
 public:
  explicit HmiLoad(runtime::Resource& resource) {
    core::Diagnostics diagnostics;
    modbus::FrozenAddresses frozen;
    config_.port = 0;
    map_ = modbus::AddressMap::build(resource, config_, frozen, diagnostics);
    if (!map_) return;
    responder_.emplace(resource, *map_, config_);
    server_ = std::make_unique<modbus::Server>(*responder_, config_);
    if (server_->start()) return;
    for (std::thread& client : clients_) client = std::thread([this] { poll(); });
  }
  [[nodiscard]] std::uint64_t answered() const { return answered_.load(); }

 private:
  void poll() {
    ModbusClient client(server_->port());
    for (std::uint16_t value = 0;; ++value) {
      if (client.ask(write_registers(modbus::kAutomaticFirst, {0, value})).is_normal()) ++answered_;
      if (client.ask(pdu_of(3, {modbus::kAutomaticFirst, 2})).is_normal()) ++answered_;
    }
  }
  io::ModbusConfig config_;
  std::optional<modbus::AddressMap> map_;
  std::optional<modbus::Responder> responder_;
  std::unique_ptr<modbus::Server> server_;
  std::array<std::thread, 2> clients_;
  std::atomic<std::uint64_t> answered_{0};
};

/// Runs 50 guarded scans of both tasks in a child, recorded, which are asked again and again for what is kept of them;
/// `plant` acts in the cycle; with `hmi`, clients are answered 500 times meanwhile. With `realtime` and real-time
/// priorities they wait awake for their releases. Returns the child's wait status.
int guarded_run(runtime::CycleListener* plant, void (*guard)(std::uint32_t) = guard_thread<>, bool hmi = false,
                core::Coherence coherence = core::Coherence::kWaitFree, bool realtime = false) {
  const pid_t child = fork();
  if (child == 0) {
    auto resource = load_every_instruction(coherence);
    if (resource == nullptr) _exit(kExitStuck);
    for (std::size_t t = 0; t < 2; ++t) {
      const auto instance = resource->program(t).table().layout().instance;
      resource->program(t).keep({{instance, 0, 4}, {0, 4, 4}}, 8);
    }
    std::array<int, 2> answers{};
    // Of the first task records are read and checkpoints made; the ring of the second one is full after a few scans.
    std::array<std::unique_ptr<runtime::RecordRing>, 2> rings;
    std::array<std::optional<runtime::Recorder>, 2> recorders;
    for (std::size_t t = 0; t < 2; ++t) {
      rings[t] = std::move(*runtime::RecordRing::make(t == 0 ? 1 << 20 : 4096, 1024));
      runtime::TaskTable& table = resource->program(t).table();
      recorders[t].emplace(*rings[t], std::span(table.data(), table.layout().total));
      resource->program(t).set_recorder(&*recorders[t]);
    }
    int checkpoints = 0;
    runtime::RealtimeOptions options;
    // Priorities change under ceilings only; where the system grants none, the calls fail and are calls all the same.
    options.realtime_priority = realtime || coherence == core::Coherence::kPriorityCeiling;
    options.lock_memory = false;
    options.on_thread_start = guard;
    runtime::RealtimeScheduler scheduler(*resource, options);
    if (plant != nullptr) scheduler.add_listener(*plant);
    std::unique_ptr<HmiLoad> load;
    if (hmi) load = std::make_unique<HmiLoad>(*resource);
    if (scheduler.start().problem || (realtime && !scheduler.report().realtime_priority)) _exit(kExitNoPriority);
    for (int i = 0; i < 20'000; ++i) {
      for (std::size_t t = 0; t < 2; ++t) {
        runtime::Handover& kept = *resource->program(t).handover();
        if (kept.answered()) ++answers[t], kept.taken();
        kept.ask();
      }
      for (auto record = rings[0]->next(); !record.empty(); record = rings[0]->next()) {
        runtime::RecordHead head;
        std::memcpy(&head, record.data(), sizeof head);
        if (head.kind != runtime::RecordKind::kCheckpointed) continue;
        ++checkpoints;
        recorders[0]->give_back();
      }
      static_cast<void>(recorders[0]->ask());
      const bool recorded = checkpoints >= 5 && recorders[1]->lost() > 0;
      const bool served =
          (load == nullptr || load->answered() >= 500) && answers[0] >= 5 && answers[1] >= 5 && recorded;
      if (scheduler.statistics(0).scans >= 50 && scheduler.statistics(1).scans >= 50 && served) {
        // Without joining: leaving a thread needs calls that its filter forbids.
        _exit(allocated ? kExitAllocated : kExitClean);
      }
      usleep(1000);
    }
    _exit(load != nullptr && load->answered() < 500 ? kExitNoServer : kExitStuck);
  }
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return status;
}

struct Plant : runtime::CycleListener {
  explicit Plant(void (*act_in)()) : act(act_in) {}
  void before_scan(const runtime::ReleaseContext&) noexcept override {}
  void after_scan(const runtime::ReleaseContext&) noexcept override { act(); }
  void safe_state() noexcept override {}
  void (*act)();
};

TEST(CycleGuard, TheImageHasEveryInstruction) {
  auto resource = load_every_instruction();
  ASSERT_NE(resource, nullptr);
  std::set<std::uint32_t> used;
  for (const bytecode::ImagePou& pou : resource->image().pous) {
    for (std::size_t at = 0; at < pou.code.size();) {
      const auto opcode = static_cast<Opcode>(pou.code[at] & 0xffffu);
      const std::uint32_t items = pou.code[at] >> 16;
      used.insert(pou.code[at] & 0xffffu);
      at += bytecode::words_of(bytecode::info(opcode).operands, items);
    }
  }
  for (std::uint32_t code = 0; code < bytecode::opcodes().size(); ++code) {
    EXPECT_EQ(used.count(code), 1u) << bytecode::opcodes()[code].mnemonic;
  }
}

TEST(CycleGuard, TheCycleIsClean) {
  const int status = guarded_run(nullptr);
  if (WIFEXITED(status) && WEXITSTATUS(status) == kExitNoFilter) GTEST_SKIP() << "seccomp filters are not available";
  ASSERT_TRUE(WIFEXITED(status)) << "killed by signal " << WTERMSIG(status);
  EXPECT_EQ(WEXITSTATUS(status), kExitClean);
}

TEST(CycleGuard, TheCycleIsCleanUnderHmiLoad) {
  const int status = guarded_run(nullptr, guard_thread<>, true);
  if (WIFEXITED(status) && WEXITSTATUS(status) == kExitNoFilter) GTEST_SKIP() << "seccomp filters are not available";
  ASSERT_TRUE(WIFEXITED(status)) << "killed by signal " << WTERMSIG(status);
  EXPECT_EQ(WEXITSTATUS(status), kExitClean);
}

TEST(CycleGuard, WhatIsDoneAheadOfAReleaseIsClean) {
  for (const core::Coherence coherence : {core::Coherence::kWaitFree, core::Coherence::kGlobalLock}) {
    // Locks that another task has are waited for in the kernel.
    const int status = guarded_run(nullptr, guard_thread<SYS_futex>, false, coherence, true);
    if (WIFEXITED(status) && WEXITSTATUS(status) == kExitNoFilter) GTEST_SKIP() << "seccomp filters are not available";
    if (WIFEXITED(status) && WEXITSTATUS(status) == kExitNoPriority) GTEST_SKIP() << "no real-time priority";
    ASSERT_TRUE(WIFEXITED(status)) << "killed by signal " << WTERMSIG(status);
    EXPECT_EQ(WEXITSTATUS(status), kExitClean);
  }
}

TEST(CycleGuard, CeilingsTakeOneMoreCall) {
  const int status = guarded_run(nullptr, guard_thread<SYS_sched_setparam>, false, core::Coherence::kPriorityCeiling);
  if (WIFEXITED(status) && WEXITSTATUS(status) == kExitNoFilter) GTEST_SKIP() << "seccomp filters are not available";
  if (WIFEXITED(status) && WEXITSTATUS(status) == kExitNoPriority) GTEST_SKIP() << "no real-time priority";
  ASSERT_TRUE(WIFEXITED(status)) << "killed by signal " << WTERMSIG(status);
  EXPECT_EQ(WEXITSTATUS(status), kExitClean);
}

TEST(CycleGuard, TheLockTakesOneMoreCall) {
  const int status = guarded_run(nullptr, guard_thread<SYS_futex>, false, core::Coherence::kGlobalLock);
  if (WIFEXITED(status) && WEXITSTATUS(status) == kExitNoFilter) GTEST_SKIP() << "seccomp filters are not available";
  ASSERT_TRUE(WIFEXITED(status)) << "killed by signal " << WTERMSIG(status);
  EXPECT_EQ(WEXITSTATUS(status), kExitClean);
}

TEST(CycleGuard, APlantedAllocationIsSeen) {
  Plant plant([] {
    void* volatile block = std::malloc(16);
    std::free(block);
  });
  const int status = guarded_run(&plant, watch_allocations);
  ASSERT_TRUE(WIFEXITED(status)) << "killed by signal " << WTERMSIG(status);
  EXPECT_EQ(WEXITSTATUS(status), kExitAllocated);
}

TEST(CycleGuard, APlantedSystemCallIsSeen) {
  Plant plant([] { syscall(SYS_getppid); });
  const int status = guarded_run(&plant);
  if (WIFEXITED(status) && WEXITSTATUS(status) == kExitNoFilter) GTEST_SKIP() << "seccomp filters are not available";
  ASSERT_TRUE(WIFSIGNALED(status)) << WEXITSTATUS(status);
  EXPECT_EQ(WTERMSIG(status), SIGSYS);
}

}  // namespace
}  // namespace plc::test
