// The exchange between tasks, the outside and drivers: who sees what when, and that nobody ever sees half of it.
#include "runtime/memory/exchange.h"

#include <gtest/gtest.h>
#include <pthread.h>
#include <sched.h>
#include <time.h>

#include <array>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <random>
#include <thread>

#include "runtime/link.h"
#include "runtime/memory/global_ports.h"
#include "runtime/memory/process_image.h"
#include "runtime/sched/priority.h"
#include "runtime/sched/thread_settings.h"
#include "tests/unit/runtime/run_support.h"

namespace plc::test {
namespace {

using runtime::bind_to_cpu;
using runtime::Exchange;
using runtime::fifo_priority;
using runtime::GlobalInputs;
using runtime::GlobalReader;
using runtime::GlobalTable;
using runtime::GlobalWrite;
using runtime::set_fifo;
using runtime::set_own_priority;
using runtime::WriteResult;

/// A task without code: its local copy of the table is in the hands of the test.
class HandTask {
 public:
  HandTask(GlobalTable& globals, std::uint32_t task, runtime::SetPriority set = nullptr)
      : memory_(globals.size() + 64),
        exchange_(runtime::make_exchange(globals.image().options.coherence, globals, task, memory_.data())) {
    const bytecode::Image& image = globals.image();
    std::memcpy(memory_.data(), image.global_initial.data(), globals.size());
    const auto all = static_cast<std::uint32_t>(image.globals.size());
    in_ = exchange_->add_range(0, all, Exchange::Use::kImport);
    all_ = exchange_->add_range(0, all, Exchange::Use::kRaise);
    for (const runtime::FieldRange& range : runtime::exchanged_ranges(image, image.tasks[task].body)) {
      if (range.exported) out_.push_back(exchange_->add_range(range.first, range.count, Exchange::Use::kExport));
    }
    exchange_->prepare();
    exchange_->set_priority_change(set);
  }
  void begin() {
    exchange_->begin();
    hold_others_off();
    exchange_->import(in_);
    let_others_on();
  }
  void end() {
    export_only();
    finish();
  }
  /// The two halves of end().
  void export_only() {
    hold_others_off();
    for (const std::uint32_t range : out_) exchange_->export_range(range);
    let_others_on();
  }
  bool finish() { return exchange_->end(); }
  Exchange& exchange() { return *exchange_; }
  template <class T>
  T get(std::uint32_t offset) const {
    T value;
    std::memcpy(&value, memory_.data() + offset, sizeof value);
    return value;
  }
  template <class T>
  void put(std::uint32_t offset, T value) {
    std::memcpy(memory_.data() + offset, &value, sizeof value);
  }

 private:
  runtime::TableMemory memory_;
  void hold_others_off() {
    exchange_->lock();
    exchange_->raise(all_);
  }
  void let_others_on() {
    exchange_->unlock();
    exchange_->reschedule();
  }

  std::unique_ptr<Exchange> exchange_;
  std::uint32_t in_ = 0;
  std::uint32_t all_ = 0;
  std::vector<std::uint32_t> out_;
};

/// Two tasks without code and a table made by the test.
struct Tables {
  ImageBuilder b;
  std::optional<bytecode::VerifiedImage> verified;
  std::unique_ptr<GlobalTable> globals;

  std::uint32_t global(const std::string& name, std::uint32_t type, ImageBuilder::GlobalOptions options = {}) {
    return bytecode::offset_of(b.global(name, type, {}, std::move(options)));
  }
  /// Task 0 is the most urgent.
  GlobalTable& build(std::size_t tasks = 2) {
    for (std::size_t i = 0; i < tasks; ++i) {
      PouBuilder program = b.pou("P" + std::to_string(i), PouKind::kProgram);
      b.task("T" + std::to_string(i), 1'000'000, {program.finish()}, static_cast<std::int32_t>(i));
    }
    core::Diagnostics diagnostics;
    verified = bytecode::verify(b.build(), diagnostics);
    std::ostringstream text;
    diagnostics.render(text);
    EXPECT_TRUE(verified.has_value()) << text.str();
    globals = std::make_unique<GlobalTable>(verified->image());
    return *globals;
  }
  template <class T>
  T read(std::uint32_t offset) const {
    T value;
    globals->read(offset, sizeof value, reinterpret_cast<std::byte*>(&value));
    return value;
  }
  template <class T>
  WriteResult write(std::uint32_t offset, std::uint32_t type, T value, std::optional<T> mask = {}) {
    const GlobalWrite write{offset, type, reinterpret_cast<const std::byte*>(&value),
                            mask ? reinterpret_cast<const std::byte*>(&*mask) : nullptr};
    return globals->write({&write, 1});
  }
};

TEST(Exchange, AnExportIsSeenAtTheReadersNextStart) {
  Tables t;
  const std::uint32_t dint = t.b.type(TypeId::kDint);
  const std::uint32_t x = t.global("x", dint, {.owner = 0});
  GlobalTable& globals = t.build();
  HandTask writer(globals, 0);
  HandTask reader(globals, 1);
  reader.begin();
  writer.begin();
  writer.put<std::int32_t>(x, 7);
  EXPECT_EQ(t.read<std::int32_t>(x), 0) << "published before the end of the cycle";
  writer.end();
  EXPECT_EQ(t.read<std::int32_t>(x), 7);
  EXPECT_EQ(reader.get<std::int32_t>(x), 0) << "a running cycle saw a change";
  reader.end();
  EXPECT_EQ(t.read<std::int32_t>(x), 7) << "a reader exported what it does not own";
  reader.begin();
  EXPECT_EQ(reader.get<std::int32_t>(x), 7);
  reader.end();
}

TEST(Exchange, AReaderKeepsItsSnapshotWhileTheWriterGoesOn) {
  Tables t;
  const std::uint32_t x = t.global("x", t.b.type(TypeId::kDint), {.owner = 0});
  GlobalTable& globals = t.build();
  HandTask writer(globals, 0);
  GlobalReader reader(globals);
  reader.take();
  for (std::int32_t i = 1; i <= 20; ++i) {
    writer.begin();
    writer.put(x, i);
    writer.end();
    std::int32_t seen = -1;
    reader.read(x, sizeof seen, reinterpret_cast<std::byte*>(&seen));
    EXPECT_EQ(seen, 0);
  }
  reader.take();
  std::int32_t seen = -1;
  reader.read(x, sizeof seen, reinterpret_cast<std::byte*>(&seen));
  EXPECT_EQ(seen, 20);
}

TEST(Exchange, OutsideWritesWaitForTheExportersNextStart) {
  Tables t;
  const std::uint32_t dint = t.b.type(TypeId::kDint);
  const std::uint32_t x = t.global("x", dint, {.owner = 0});
  GlobalTable& globals = t.build();
  HandTask owner(globals, 0);
  owner.begin();
  EXPECT_EQ(t.write<std::int32_t>(x, dint, 5), WriteResult::kDone);
  owner.end();
  EXPECT_EQ(t.read<std::int32_t>(x), 0) << "the running cycle published a write it had not seen";
  owner.begin();
  EXPECT_EQ(owner.get<std::int32_t>(x), 5);
  owner.end();
  EXPECT_EQ(t.read<std::int32_t>(x), 5);
}

TEST(Exchange, MasksApplyAtTheOwnerOneAfterTheOther) {
  Tables t;
  const std::uint32_t dword = t.b.type(TypeId::kDword);
  const std::uint32_t owned = t.global("owned", dword, {.owner = 0});
  const std::uint32_t outside = t.global("outside", dword, {.input = true});
  const std::uint32_t shared = t.global("shared", dword);
  GlobalTable& globals = t.build();
  HandTask owner(globals, 0);
  for (const std::uint32_t x : {owned, outside, shared}) {
    EXPECT_EQ(t.write<std::uint32_t>(x, dword, 0x12345678u, 0xffff0000u), WriteResult::kDone);
    EXPECT_EQ(t.write<std::uint32_t>(x, dword, 0x12345678u, 0x0000ff00u), WriteResult::kDone);
    const std::uint32_t bits = 0x000000f1u;
    const std::uint32_t mask = 0x00000001u;
    const GlobalWrite twice[] = {
        {x, dword, reinterpret_cast<const std::byte*>(&bits), reinterpret_cast<const std::byte*>(&mask)},
        {x, dword, reinterpret_cast<const std::byte*>(&bits), reinterpret_cast<const std::byte*>(&bits)},
    };
    EXPECT_EQ(globals.write(twice), WriteResult::kDone);
  }
  owner.begin();
  for (const std::uint32_t x : {owned, outside, shared}) EXPECT_EQ(owner.get<std::uint32_t>(x), 0x123456f1u);
  owner.end();
  for (const std::uint32_t x : {owned, outside, shared}) EXPECT_EQ(t.read<std::uint32_t>(x), 0x123456f1u);
}

TEST(Exchange, WritesAreNormalised) {
  Tables t;
  const std::uint32_t boolean = t.b.boolean();
  const std::uint32_t percent = t.b.limited(TypeId::kInt, 0, 100);
  const std::uint32_t real = t.b.type(TypeId::kReal);
  const std::uint32_t text = t.b.string(3);
  const std::uint32_t a = t.global("a", boolean, {.input = true});
  const std::uint32_t p = t.global("p", percent, {.input = true});
  const std::uint32_t r = t.global("r", real, {.input = true});
  const std::uint32_t s = t.global("s", text, {.input = true});
  GlobalTable& globals = t.build(1);
  EXPECT_EQ(t.write<std::uint8_t>(a, boolean, 0x40), WriteResult::kDone);
  EXPECT_EQ(t.read<std::uint8_t>(a), 1);
  t.write<std::int16_t>(p, percent, 100);
  t.write<std::int16_t>(p, percent, 101);
  EXPECT_EQ(t.read<std::int16_t>(p), 100) << "outside the subrange";
  t.write<std::int16_t>(p, percent, 0x100, std::int16_t{0x100});
  EXPECT_EQ(t.read<std::int16_t>(p), 100) << "a masked write led outside the subrange";
  t.write<std::uint32_t>(r, real, 0xffc12345u);
  EXPECT_EQ(t.read<std::uint32_t>(r), 0x7fc00000u) << "not the one NaN";
  struct Text {
    std::uint16_t capacity = 9;
    std::uint16_t length = 9;
    char bytes[4] = {'a', 'b', 'c', 'd'};
  } forged;
  const GlobalWrite write{s, text, reinterpret_cast<const std::byte*>(&forged), nullptr};
  EXPECT_EQ(globals.write({&write, 1}), WriteResult::kDone);
  EXPECT_EQ(t.read<core::StringHeader>(s).capacity, 3);
  EXPECT_EQ(t.read<core::StringHeader>(s).length, 3);
}

TEST(Exchange, ConstantsAndDriverInputsAreRefused) {
  Tables t;
  const std::uint32_t dint = t.b.type(TypeId::kDint);
  const std::uint32_t fixed = t.global("fixed", dint, {.constant = true});
  const std::uint32_t in = t.global("in", dint, {.input = true});
  const std::uint32_t out = t.global("out", dint, {.owner = 0});
  GlobalTable& globals = t.build(1);
  EXPECT_FALSE(globals.claimable(0));
  EXPECT_TRUE(globals.claimable(1));
  EXPECT_FALSE(globals.claimable(2)) << "a task exports it";
  HandTask task(globals, 0);
  const std::uint32_t fields[] = {1};
  GlobalInputs inputs(globals, fields);
  EXPECT_FALSE(globals.claimable(1)) << "claimed twice";
  EXPECT_EQ(t.write<std::int32_t>(fixed, dint, 1), WriteResult::kRefused);
  EXPECT_EQ(t.write<std::int32_t>(in, dint, 1), WriteResult::kRefused);
  const std::int32_t one = 1;
  const auto* const bytes = reinterpret_cast<const std::byte*>(&one);
  const GlobalWrite mixed[] = {{out, dint, bytes, nullptr}, {in, dint, bytes, nullptr}};
  EXPECT_EQ(globals.write(mixed), WriteResult::kRefused);
  task.begin();
  EXPECT_EQ(task.get<std::int32_t>(out), 0) << "half of a refused batch was written";
  task.end();
  inputs.set(in, dint, bytes);
  EXPECT_EQ(t.read<std::int32_t>(in), 0);
  inputs.publish();
  task.begin();
  EXPECT_EQ(task.get<std::int32_t>(in), 1);
  task.end();
}

TEST(Exchange, AFullJournalIsBusyAndRecovers) {
  Tables t;
  const std::uint32_t lint = t.b.type(TypeId::kLint);
  const std::uint32_t x = t.global("x", lint, {.owner = 0});
  GlobalTable& globals = t.build(1);
  HandTask task(globals, 0);
  for (int round = 0; round < 3; ++round) {
    std::int64_t written = 0;
    while (t.write<std::int64_t>(x, lint, written + 1) == WriteResult::kDone) ++written;
    EXPECT_GT(written, 500);
    EXPECT_LT(written, 100'000);
    task.begin();
    EXPECT_EQ(task.get<std::int64_t>(x), written);
    task.end();
  }
}

TEST(Exchange, OfSeveralWritersTheLastChangeCounts) {
  Tables t;
  const std::uint32_t dint = t.b.type(TypeId::kDint);
  const std::uint32_t text = t.b.string(20);
  const std::uint32_t x = t.global("x", dint);
  const std::uint32_t y = t.global("y", dint);
  const std::uint32_t s = t.global("s", text);
  GlobalTable& globals = t.build();
  HandTask a(globals, 0);
  HandTask b(globals, 1);
  a.begin();
  b.begin();
  a.put<std::int32_t>(x, 1);
  b.put<std::int32_t>(y, 2);
  b.put(s, core::StringHeader{20, 7});
  a.end();
  b.end();
  EXPECT_EQ(t.read<std::int32_t>(x), 1) << "a task that did not change a value published it";
  EXPECT_EQ(t.read<std::int32_t>(y), 2);
  struct Text {
    core::StringHeader header;
    std::byte bytes[20];
  };
  EXPECT_EQ(t.read<Text>(s).header.length, 7);
  b.begin();
  EXPECT_EQ(b.get<std::int32_t>(x), 1);
  b.put<std::int32_t>(x, 3);
  b.end();
  EXPECT_EQ(t.read<std::int32_t>(x), 3);
  EXPECT_EQ(t.write<std::int32_t>(x, dint, 4), WriteResult::kDone);
  EXPECT_EQ(t.read<std::int32_t>(x), 4) << "the outside publishes shared values at once";
  a.begin();
  EXPECT_EQ(a.get<std::int32_t>(x), 4);
  a.put<std::int32_t>(x, 5);
  a.end();
  EXPECT_EQ(t.read<std::int32_t>(x), 5);
}

TEST(Exchange, OverlappingAddressesAreSingleValues) {
  Tables t;
  t.b.image.options.profile = core::AddressProfile::kOverlay;
  const std::uint32_t word = t.b.type(TypeId::kWord);
  const std::uint32_t bit = t.global("bit", t.b.boolean(), {.address = "%QX0.3", .owner = 0});
  const std::uint32_t whole = t.global("whole", word, {.address = "%QW0", .owner = 1});
  GlobalTable& globals = t.build();
  HandTask a(globals, 0);
  HandTask b(globals, 1);
  runtime::ProcessImage image(globals.image(), globals);
  a.begin();
  a.put<std::uint8_t>(bit, 1);
  a.end();
  image.sync();
  b.begin();
  EXPECT_EQ(b.get<std::uint16_t>(whole), 8);
  b.put<std::uint16_t>(whole, 0x8000);
  b.end();
  image.sync();
  EXPECT_EQ(t.read<std::uint8_t>(bit), 0);
  EXPECT_EQ(t.write<std::uint16_t>(whole, word, 0x0008, std::uint16_t{0x0008}), WriteResult::kDone);
  image.sync();
  EXPECT_EQ(t.read<std::uint8_t>(bit), 1);
  EXPECT_EQ(t.read<std::uint16_t>(whole), 0x8008);
}

TEST(Exchange, AClaimCoversWhatSharesItsBits) {
  Tables t;
  t.b.image.options.profile = core::AddressProfile::kOverlay;
  const std::uint32_t word = t.b.type(TypeId::kWord);
  t.global("bit", t.b.boolean(), {.input = true, .address = "%MX0.3"});
  const std::uint32_t whole = t.global("whole", word, {.input = true, .address = "%MW0"});
  t.global("out", t.b.boolean(), {.address = "%QX0.0", .owner = 0});
  t.global("outs", word, {.input = true, .address = "%QW0"});
  GlobalTable& globals = t.build(1);
  EXPECT_FALSE(globals.claimable(3)) << "a task exports a bit of it";
  const std::uint32_t bit_field[] = {0};
  GlobalInputs inputs(globals, bit_field);
  EXPECT_FALSE(globals.writable(1));
  EXPECT_EQ(t.write<std::uint16_t>(whole, word, 8), WriteResult::kRefused);
}

TEST(Exchange, AnExportBetweenTwoSyncsIsNotUndone) {
  Tables t;
  t.b.image.options.profile = core::AddressProfile::kOverlay;
  const std::uint32_t bit = t.global("bit", t.b.boolean(), {.address = "%QX0.0", .owner = 0});
  t.global("whole", t.b.type(TypeId::kWord), {.input = true, .address = "%QW0"});
  GlobalTable& globals = t.build(1);
  HandTask task(globals, 0);
  runtime::ProcessImage image(globals.image(), globals);
  std::atomic<bool> stop{false};
  std::thread other([&] {
    while (!stop) image.sync();
  });
  std::uint64_t undone = 0;
  for (int round = 0; round < 20'000; ++round) {
    const auto wanted = static_cast<std::uint8_t>(round % 2);
    task.begin();
    task.put(bit, wanted);
    task.end();
    image.sync();
    if (t.read<std::uint8_t>(bit) != wanted) ++undone;
  }
  stop = true;
  other.join();
  EXPECT_EQ(undone, 0u);
}

TEST(Exchange, AStoppedTaskTakesNoWrites) {
  Tables t;
  const std::uint32_t dint = t.b.type(TypeId::kDint);
  const std::uint32_t x = t.global("x", dint, {.owner = 0});
  GlobalTable& globals = t.build(1);
  EXPECT_EQ(t.write<std::int32_t>(x, dint, 1), WriteResult::kDone);
  globals.task_stopped(0);
  EXPECT_EQ(t.write<std::int32_t>(x, dint, 2), WriteResult::kBusy);
  globals.reset();
  EXPECT_EQ(t.write<std::int32_t>(x, dint, 3), WriteResult::kDone);
}

TEST(Exchange, ALateStampIsSeen) {
  // The change with the lower stamp is published after the one with the higher: both must arrive.
  Tables t;
  const std::uint32_t pair = t.global("pair", t.b.array(t.b.type(TypeId::kDint), 2));
  GlobalTable& globals = t.build(3);
  HandTask early(globals, 0);
  HandTask late(globals, 1);
  HandTask reader(globals, 2);
  early.begin();
  early.put<std::int32_t>(pair, 1);
  early.export_only();
  late.begin();
  late.put<std::int32_t>(pair + 4, 2);
  late.end();
  reader.begin();
  EXPECT_EQ(reader.get<std::int32_t>(pair + 4), 2);
  reader.end();
  early.finish();
  reader.begin();
  EXPECT_EQ(reader.get<std::int32_t>(pair), 1);
  EXPECT_EQ(reader.get<std::int32_t>(pair + 4), 2);
  reader.end();
}

/// Exchanges per size of group; PLC_EXCHANGES raises it for longer runs.
std::uint64_t exchanges() {
  const char* const text = std::getenv("PLC_EXCHANGES");
  return text == nullptr ? 60'000 : std::strtoull(text, nullptr, 10);
}

/// Two tasks that own a group each, a reader and a writer from outside, all as fast as they can, on two cores. Every
/// publication fills its group with one number, so any mixture of two shows.
class Consistency : public testing::TestWithParam<std::tuple<core::Coherence, std::uint32_t>> {};

TEST_P(Consistency, NothingTearsAndNothingMixes) {
  const auto [coherence, size] = GetParam();
  Tables t;
  t.b.image.options.coherence = coherence;
  const std::uint32_t lint = t.b.type(TypeId::kLint);
  const std::uint32_t text = t.b.string(28);
  const std::uint32_t group = t.b.array(lint, size);
  const std::uint32_t first = t.global("first", group, {.owner = 0});
  const std::uint32_t second = t.global("second", group, {.owner = 1});
  const std::uint32_t outside = t.global("outside", group, {.input = true});
  const std::uint32_t asked = t.global("asked", t.b.array(lint, 3), {.owner = 0});
  const std::uint32_t shared = t.global("shared", text);
  GlobalTable& globals = t.build();
  HandTask a(globals, 0);
  HandTask b(globals, 1);
  GlobalReader reader(globals);
  constexpr std::int64_t kStop = -1;
  const std::uint64_t rounds = std::max<std::uint64_t>(exchanges() / (1 + size / 100), 50);
  std::atomic<std::uint64_t> done{0};
  std::atomic<std::uint64_t> bad{0};
  std::atomic<bool> stop{false};

  // The number a group is filled with, or kStop when it is not one number.
  const auto number = [](const std::byte* values, std::uint32_t count) {
    std::int64_t head;
    std::memcpy(&head, values, sizeof head);
    for (std::uint32_t i = 1; i < count; ++i) {
      if (std::memcmp(values, values + 8u * i, 8) != 0) return kStop;
    }
    return head;
  };
  const auto expect = [&bad](bool good) {
    if (!good) bad.fetch_add(1, std::memory_order_relaxed);
  };
  // A string whose characters are all its length: "", "\1", "\2\2", ..
  const auto string_is_whole = [](const std::byte* value) {
    core::StringHeader header;
    std::memcpy(&header, value, sizeof header);
    for (std::uint16_t i = 0; i < header.length; ++i) {
      if (std::to_integer<std::uint16_t>(value[sizeof header + i]) != header.length) return false;
    }
    return header.length <= 28 && header.capacity == 28;
  };
  const auto cycle = [&](HandTask& task, std::uint32_t mine, std::uint32_t theirs) {
    std::vector<std::byte> copy(8u * size);
    std::int64_t newest = 0;
    std::int64_t newest_outside = 0;
    for (std::uint64_t round = 1; round <= rounds; ++round) {
      if (round % 2 == 0) task.exchange().expect(100'000);
      task.begin();
      for (std::uint32_t i = 0; i < size; ++i) {
        const auto value = task.get<std::int64_t>(theirs + 8 * i);
        std::memcpy(copy.data() + 8u * i, &value, 8);
      }
      const std::int64_t seen = number(copy.data(), size);
      expect(seen >= newest);
      newest = seen;
      for (std::uint32_t i = 0; i < size; ++i) {
        const auto value = task.get<std::int64_t>(outside + 8 * i);
        std::memcpy(copy.data() + 8u * i, &value, 8);
      }
      const std::int64_t from_outside = number(copy.data(), size);
      expect(from_outside >= newest_outside);
      newest_outside = from_outside;
      if (mine == first) {
        expect(task.get<std::int64_t>(asked) == task.get<std::int64_t>(asked + 8) &&
               task.get<std::int64_t>(asked) == task.get<std::int64_t>(asked + 16));
      }
      struct {
        std::byte bytes[32];
      } string = task.get<decltype(string)>(shared);
      expect(string_is_whole(string.bytes));
      const auto length = static_cast<std::uint16_t>(round % 29);
      const core::StringHeader header{28, length};
      std::memcpy(string.bytes, &header, sizeof header);
      for (std::uint16_t i = 0; i < length; ++i) string.bytes[sizeof header + i] = static_cast<std::byte>(length);
      task.put(shared, string);
      for (std::uint32_t i = 0; i < size; ++i) task.put<std::int64_t>(mine + 8 * i, static_cast<std::int64_t>(round));
      task.end();
      done.fetch_add(1, std::memory_order_relaxed);
    }
  };
  std::thread one([&] { cycle(a, first, second); });
  std::thread two([&] { cycle(b, second, first); });
  std::thread three([&] {
    std::vector<std::byte> copy(8u * size);
    std::byte string[32];
    while (!stop) {
      reader.take();
      for (const std::uint32_t where : {first, second, outside}) {
        reader.read(where, 8 * size, copy.data());
        expect(number(copy.data(), size) >= 0);
      }
      reader.read(shared, sizeof string, string);
      expect(string_is_whole(string));
      done.fetch_add(1, std::memory_order_relaxed);
    }
  });
  std::thread four([&] {
    std::vector<std::byte> table(globals.size());
    for (std::int64_t round = 1; !stop; ++round) {
      std::vector<GlobalWrite> batch;
      const auto* const value = reinterpret_cast<const std::byte*>(&round);
      for (std::uint32_t i = 0; i < size; ++i) batch.push_back({outside + 8 * i, lint, value, nullptr});
      for (std::uint32_t i = 0; i < 3; ++i) batch.push_back({asked + 8 * i, lint, value, nullptr});
      const WriteResult result = globals.write(batch);
      expect(result != WriteResult::kRefused);
      if (result == WriteResult::kBusy) std::this_thread::yield();
      globals.copy(table.data());
      expect(number(table.data() + first, size) >= 0 && number(table.data() + outside, size) >= 0);
      expect(number(table.data() + asked, 3) >= 0 && string_is_whole(table.data() + shared));
      done.fetch_add(1, std::memory_order_relaxed);
    }
  });
  one.join();
  two.join();
  stop = true;
  three.join();
  four.join();
  EXPECT_EQ(bad, 0u);
  EXPECT_GE(done, 2 * rounds);
  RecordProperty("exchanges", std::to_string(done));
}

// Priority ceilings need one processor and priorities: below.
INSTANTIATE_TEST_SUITE_P(Groups, Consistency,
                         testing::Combine(testing::Values(core::Coherence::kWaitFree, core::Coherence::kGlobalLock),
                                          testing::Values(1u, 10u, 100u, 1'000u, 10'000u)));

/// Everything that changes globals, once with and once without what tasks do ahead of their releases.
class Ahead : public testing::TestWithParam<core::Coherence> {
 protected:
  struct World {
    Tables t;
    std::uint32_t dint = t.b.type(TypeId::kDint);
    std::uint32_t mine[2] = {t.global("mine0", t.b.array(dint, 20), {.owner = 0}),
                             t.global("mine1", t.b.array(dint, 20), {.owner = 1})};
    std::uint32_t outside = t.global("outside", dint, {.input = true});
    std::uint32_t in = t.global("in", dint, {.input = true});
    std::uint32_t shared = t.global("shared", t.b.array(dint, 4));
    std::uint32_t text = t.global("text", t.b.string(9));
    std::uint32_t bit, whole;
    std::unique_ptr<GlobalInputs> inputs;
    std::unique_ptr<runtime::ProcessImage> image;
    std::unique_ptr<HandTask> tasks[2];

    explicit World(core::Coherence coherence) {
      t.b.image.options.coherence = coherence;
      t.b.image.options.profile = core::AddressProfile::kOverlay;
      bit = t.global("bit", t.b.boolean(), {.address = "%QX0.3", .owner = 0});
      whole = t.global("whole", t.b.type(TypeId::kWord), {.address = "%QW0", .owner = 1});
      GlobalTable& globals = t.build();
      for (std::uint32_t task = 0; task < 2; ++task) tasks[task] = std::make_unique<HandTask>(globals, task);
      const std::uint32_t field[] = {globals.field_of(in)};
      inputs = std::make_unique<GlobalInputs>(globals, field);
      image = std::make_unique<runtime::ProcessImage>(globals.image(), globals);
    }
    [[nodiscard]] std::vector<std::byte> published() const {
      std::vector<std::byte> all(t.globals->size());
      t.globals->copy(all.data());
      return all;
    }
    [[nodiscard]] std::vector<std::byte> local(std::uint32_t task) const {
      std::vector<std::byte> all(t.globals->size());
      for (std::uint32_t i = 0; i < all.size(); ++i) all[i] = tasks[task]->get<std::byte>(i);
      return all;
    }
    void write(std::uint32_t offset, std::int32_t value) {
      EXPECT_EQ(t.write<std::int32_t>(offset, dint, value), WriteResult::kDone);
    }
    void input(std::int32_t value) {
      inputs->set(in, dint, reinterpret_cast<const std::byte*>(&value));
      inputs->publish();
    }
    void safe(std::uint32_t task, std::int32_t value) {
      const auto* const bytes = reinterpret_cast<const std::byte*>(&value);
      const std::array<GlobalWrite, 2> values = {{{mine[task], dint, bytes, nullptr}, {shared, dint, bytes, nullptr}}};
      tasks[task]->exchange().publish_safe(values);
    }
    /// What a program does; some of it every time, some only now and then.
    void compute(std::uint32_t task, std::uint32_t round) {
      HandTask& me = *tasks[task];
      for (std::uint32_t i = 0; i < 20; ++i)
        me.put(mine[task] + 4 * i, me.get<std::int32_t>(mine[1 - task] + 4 * i) + static_cast<std::int32_t>(round));
      me.put(mine[task], me.get<std::int32_t>(outside) + me.get<std::int32_t>(in));
      if (round % 3 == 0) me.put(shared + 4 * (round % 4), static_cast<std::int32_t>(round));
      if (round % 5 == 0) me.put(bit, static_cast<std::uint8_t>(round / 5 % 2));
      if (round % 7 == 0) me.put(whole, static_cast<std::uint16_t>(round));
    }
  };
};

TEST_P(Ahead, LeavesNoTrace) {
  for (std::uint32_t seed = 1; seed <= 40; ++seed) {
    std::mt19937 random(seed);
    World with(GetParam()), without(GetParam());
    std::uint64_t ahead = 0;
    for (std::uint32_t round = 1; round <= 150; ++round) {
      const std::uint32_t task = random() % 2;
      const std::uint32_t what = random() % 8;
      for (const std::uint32_t other : {task, 1 - task}) {
        if (random() % 2 == 0) continue;
        // Nothing, some ranges, all of them.
        constexpr std::size_t kBytes[] = {0, 40, 100'000};
        with.tasks[other]->exchange().expect(kBytes[random() % 3]);
        ++ahead;
      }
      const auto value = static_cast<std::int32_t>(random() % 1000);
      const std::uint32_t place = random() % 4;
      for (World* const world : {&with, &without}) {
        if (what == 0) world->write(world->mine[task] + 4 * place, value);
        if (what == 1) world->write(world->shared + 4 * place, value);
        if (what == 2) world->write(world->outside, value);
        if (what == 3) world->input(value);
        if (what == 4) world->safe(task, value);
        if (what < 5) continue;
        world->tasks[task]->begin();
      }
      ASSERT_TRUE(what < 5 || with.local(task) == without.local(task)) << "at the start of a cycle, seed " << seed;
      for (World* const world : {&with, &without}) {
        if (what < 5) continue;
        world->compute(task, round);
        if (what != 5) world->tasks[task]->export_only();  // else it ended in a fault
        world->tasks[task]->finish();
        world->image->sync();
      }
      ASSERT_EQ(with.published(), without.published()) << "seed " << seed << ", round " << round;
      ASSERT_TRUE(what < 5 || with.local(task) == without.local(task)) << "at the end of a cycle, seed " << seed;
    }
    EXPECT_GT(ahead, 100u);
  }
}

TEST_P(Ahead, BringsWhatOthersPublishAsLongAsTheBytesReach) {
  World world(GetParam());
  world.tasks[1]->begin();
  world.tasks[1]->put<std::int32_t>(world.mine[1], 7);
  world.tasks[1]->end();
  HandTask& task = *world.tasks[0];
  task.exchange().expect(1);
  EXPECT_EQ(task.get<std::int32_t>(world.mine[1]), 0);
  task.exchange().expect(100'000);
  // The common table is not looked at outside of critical sections.
  EXPECT_EQ(task.get<std::int32_t>(world.mine[1]), GetParam() == core::Coherence::kWaitFree ? 7 : 0);
}

TEST_P(Ahead, NobodyCanRevokeATaskBetweenItsCycles) {
  World world(GetParam());
  world.tasks[0]->exchange().expect(100'000);
  EXPECT_FALSE(world.tasks[0]->exchange().revoke());
  world.tasks[0]->begin();
  EXPECT_TRUE(world.tasks[0]->exchange().revoke());
}

INSTANTIATE_TEST_SUITE_P(Protocols, Ahead,
                         testing::Values(core::Coherence::kWaitFree, core::Coherence::kPriorityCeiling,
                                         core::Coherence::kGlobalLock));

/// What a task's thread has under the protocol; the priorities of these tasks are 0, 1, 2. Below the kernel's threads.
constexpr std::int32_t lowered(std::int32_t priority) { return 60 + priority; }
void set_lowered(std::int32_t priority) noexcept { set_own_priority(lowered(priority)); }

/// Three tasks of one processor, the more urgent ones preempting the others at any instant, in exchanges above all.
/// Each publishes its group filled with the number of its round.
class Ceilings : public testing::TestWithParam<std::uint32_t> {};

TEST_P(Ceilings, NothingMixesOnOneProcessor) {
  const std::uint32_t size = GetParam();
  Tables t;
  t.b.image.options.coherence = core::Coherence::kPriorityCeiling;
  const std::uint32_t lint = t.b.type(TypeId::kLint);
  std::array<std::uint32_t, 3> group{};
  for (std::uint32_t task = 0; task < 3; ++task) {
    group[task] = t.global("g" + std::to_string(task), t.b.array(lint, size), {.owner = task});
  }
  GlobalTable& globals = t.build(3);
  std::array<HandTask, 3> tasks{{{globals, 0, set_lowered}, {globals, 1, set_lowered}, {globals, 2, set_lowered}}};
  std::atomic<std::uint64_t> bad{0};
  std::array<std::atomic<std::uint64_t>, 3> done{};
  std::atomic<bool> stop{false};
  std::atomic<int> refused{0};
  const int cpu = sched_getcpu();
  const auto run = [&](std::uint32_t me) {
    if (bind_to_cpu(pthread_self(), cpu) != 0 ||
        set_fifo(pthread_self(), fifo_priority(lowered(static_cast<std::int32_t>(me)))) != 0) {
      ++refused;
      return;
    }
    HandTask& task = tasks[me];
    std::array<std::int64_t, 3> newest{};
    for (std::int64_t round = 1; !stop.load(std::memory_order_relaxed); ++round) {
      const auto began = std::chrono::steady_clock::now();
      task.begin();
      for (std::uint32_t other = 0; other < 3; ++other) {
        const auto head = task.get<std::int64_t>(group[other]);
        bool whole = head >= newest[other];
        for (std::uint32_t i = 1; i < size; ++i) whole = whole && task.get<std::int64_t>(group[other] + 8 * i) == head;
        if (!whole) ++bad;
        newest[other] = head;
      }
      for (std::uint32_t i = 0; i < size; ++i) task.put<std::int64_t>(group[me] + 8 * i, round);
      task.end();
      ++done[me];
      // The more urgent come again while the others exchange, and leave them time to: on an emulated processor a round
      // may take as long as a pause. The least urgent leaves some to the kernel, which may need it to wake this test.
      const auto took = std::chrono::steady_clock::now() - began;
      constexpr std::array<int, 3> kPauseUs = {20, 70, 5};
      std::this_thread::sleep_for(
          std::max<std::chrono::nanoseconds>(std::chrono::microseconds(kPauseUs[me]), me == 2 ? took / 4 : 3 * took));
    }
  };
  std::array<std::thread, 3> threads;
  for (std::uint32_t i = 0; i < 3; ++i) threads[i] = std::thread(run, i);
  const std::uint64_t wanted = std::max<std::uint64_t>(exchanges() / 20 / (1 + size / 100), 50);
  const auto begin = std::chrono::steady_clock::now();
  while (refused == 0 && (done[0] < wanted || done[1] < wanted || done[2] < wanted)) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    if (std::chrono::steady_clock::now() - begin > std::chrono::minutes(5)) break;
  }
  stop = true;
  for (std::thread& thread : threads) thread.join();
  if (refused != 0) GTEST_SKIP() << "no real-time priority";
  EXPECT_EQ(bad, 0u);
  for (const auto& count : done) EXPECT_GE(count, wanted);
}

INSTANTIATE_TEST_SUITE_P(Groups, Ceilings, testing::Values(1u, 10u, 100u, 1'000u, 10'000u));

/// Records what the protocol does to the priority.
std::vector<std::int32_t> raised;
void record_priority(std::int32_t priority) noexcept { raised.push_back(priority); }

TEST(CeilingProtocol, EveryGroupIsCopiedAtTheCeilingOfWhatItHolds) {
  Tables t;
  t.b.image.options.coherence = core::Coherence::kPriorityCeiling;
  const std::uint32_t dint = t.b.type(TypeId::kDint);
  t.global("mine", dint, {.owner = 1});
  GlobalTable& globals = t.build(2);
  EXPECT_EQ(globals.ceiling(0), 0) << "task 0 imports it";
  HandTask urgent(globals, 0, record_priority);
  HandTask slow(globals, 1, record_priority);
  raised.clear();
  urgent.begin();
  urgent.end();
  EXPECT_TRUE(raised.empty()) << "nobody is more urgent";
  slow.begin();
  EXPECT_TRUE(raised == (std::vector<std::int32_t>{0, 1})) << raised.size();
  slow.end();
  EXPECT_TRUE(raised == (std::vector<std::int32_t>{0, 1, 0, 1})) << raised.size();
}

TEST(CeilingProtocol, PrioritiesOfTheMachineCountNotThoseOfTheImage) {
  Tables t;
  t.b.image.options.coherence = core::Coherence::kPriorityCeiling;
  t.global("mine", t.b.type(TypeId::kDint), {.owner = 1});
  t.build(2);
  const std::array<std::int32_t, 2> swapped = {7, 3};
  GlobalTable globals(t.verified->image(), swapped);
  EXPECT_EQ(globals.ceiling(0), 3);
  EXPECT_EQ(globals.priority(0), 7);
  HandTask first(globals, 0, record_priority);
  raised.clear();
  first.begin();
  EXPECT_TRUE(raised == (std::vector<std::int32_t>{3, 7}));
}

/// The watchdog's part: a task that computes loses the right to publish, one that exports does not.
class Revocation : public testing::TestWithParam<core::Coherence> {};

TEST_P(Revocation, ARevokedCycleHasNoEffectAndSafeValuesStand) {
  Tables t;
  t.b.image.options.coherence = GetParam();
  const std::uint32_t dint = t.b.type(TypeId::kDint);
  const std::uint32_t output = t.global("output", dint, {.owner = 0});
  const std::uint32_t other = t.global("other", dint, {.owner = 0});
  const std::uint32_t shared = t.global("shared", dint);
  GlobalTable& globals = t.build();
  HandTask task(globals, 0);
  HandTask reader(globals, 1);
  EXPECT_FALSE(task.exchange().revoke()) << "between cycles";
  task.begin();
  task.put<std::int32_t>(output, 1);
  task.put<std::int32_t>(other, 2);
  task.put<std::int32_t>(shared, 3);
  task.export_only();
  EXPECT_FALSE(task.exchange().revoke()) << "it exports already";
  EXPECT_TRUE(task.finish());
  task.begin();
  task.put<std::int32_t>(output, 10);
  task.put<std::int32_t>(other, 20);
  task.put<std::int32_t>(shared, 30);
  ASSERT_TRUE(task.exchange().revoke());
  const std::int32_t safe = 77;
  const auto* const bytes = reinterpret_cast<const std::byte*>(&safe);
  const std::array<GlobalWrite, 2> values = {{{output, dint, bytes, nullptr}, {shared, dint, bytes, nullptr}}};
  task.exchange().publish_safe(values);
  task.export_only();
  EXPECT_FALSE(task.finish());
  EXPECT_EQ(t.read<std::int32_t>(output), 77);
  EXPECT_EQ(t.read<std::int32_t>(other), 2) << "as published last";
  EXPECT_EQ(t.read<std::int32_t>(shared), 77);
  reader.begin();
  EXPECT_EQ(reader.get<std::int32_t>(output), 77);
  EXPECT_EQ(reader.get<std::int32_t>(other), 2);
  EXPECT_EQ(reader.get<std::int32_t>(shared), 77);
  reader.end();
}

INSTANTIATE_TEST_SUITE_P(Protocols, Revocation,
                         testing::Values(core::Coherence::kWaitFree, core::Coherence::kPriorityCeiling,
                                         core::Coherence::kGlobalLock));

}  // namespace
}  // namespace plc::test
