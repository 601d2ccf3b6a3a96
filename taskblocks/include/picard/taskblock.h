// The only header a taskblock needs: write a class, declare its ports as members, list it in PICARD_LIBRARY.
//
//   class LowPass final : public picard::Taskblock {
//    public:
//     static constexpr picard::Info info{.name = "LOWPASS", .group = "Filters", .summary = "First-order filter."};
//     picard::Input<double> in{this, "IN", "signal"};
//     picard::Config<double> time{this, "TIME", "its constant", {.unit = "s", .lowest = 1e-9, .initial = "0.1"}};
//     picard::Output<double> out{this, "OUT", "filtered signal"};
//     void ready() override { gain_ = -std::expm1(-period() / time); }  // once: may allocate, open files, throw
//     void fire() override { out = out + gain_ * (in - out); }  // every cycle: nothing that allocates, locks or waits
//    private:
//     double gain_ = 0;
//   };
//   PICARD_LIBRARY("filters", "1.0.0", LowPass)
//
// Names, types, units, ranges, defaults and documentation of a port are in its declaration and nowhere else: what
// drawings may wire to it, the page of `plc blocks`, the stub for editors and what HMIs see follow from it. Ports are
// used as plain variables; their values lie in the table of variables of the task (paper, 3.1). In: nothing of PICARD
// but abi.h. Threads: construction, ready() and destruction on one that may wait; fire() on the task's.
#pragma once

#include <array>
#include <chrono>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <exception>
#include <limits>
#include <memory>
#include <new>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "picard/abi.h"

/// What is made from a library's own classes stays in it. WHY: otherwise the loader takes two libraries that happen to
/// have classes of the same name for one, and gives the second the descriptions of the first.
#define PICARD_HIDDEN __attribute__((visibility("hidden")))

namespace picard {

// ---- values
// ------------------------------------------------------------------------------------------------------------

/// A value of an elementary type that C++ has no type of its own for: bit strings, dates.
template <class Rep, int Tag>
struct Tagged {
  Rep value{};
  constexpr Tagged() = default;
  constexpr Tagged(Rep v) : value(v) {}             // NOLINT(google-explicit-constructor)
  constexpr operator Rep() const { return value; }  // NOLINT(google-explicit-constructor)
};
using Byte = Tagged<std::uint8_t, 0>;    ///< BYTE; std::uint8_t is USINT
using Word = Tagged<std::uint16_t, 1>;   ///< WORD
using Dword = Tagged<std::uint32_t, 2>;  ///< DWORD
using Lword = Tagged<std::uint64_t, 3>;  ///< LWORD
using Time = std::chrono::nanoseconds;   ///< TIME
using Ltime = Tagged<std::int64_t, 4>;   ///< LTIME, nanoseconds; so are those below, since 1970-01-01 or midnight
using Date = Tagged<std::int64_t, 5>;
using Ldate = Tagged<std::int64_t, 6>;
using TimeOfDay = Tagged<std::int64_t, 7>;
using LtimeOfDay = Tagged<std::int64_t, 8>;
using DateAndTime = Tagged<std::int64_t, 9>;
using LdateAndTime = Tagged<std::int64_t, 10>;

/// STRING[N] or, of char16_t, WSTRING[N]. Longer texts are cut.
template <std::size_t N, class Char = char>
class Text {
 public:
  Text() = default;
  Text(std::basic_string_view<Char> text) { *this = text; }  // NOLINT(google-explicit-constructor)
  Text& operator=(std::basic_string_view<Char> text) {
    length_ = static_cast<std::uint16_t>(text.size() < N ? text.size() : N);
    // WHY move: it may be a part of this text.
    if (length_ != 0) std::memmove(text_, text.data(), length_ * sizeof(Char));
    return *this;
  }
  [[nodiscard]] std::basic_string_view<Char> view() const { return {text_, length_ < N ? length_ : N}; }
  operator std::basic_string_view<Char>() const { return view(); }  // NOLINT(google-explicit-constructor)
  [[nodiscard]] bool empty() const { return length_ == 0; }

 private:
  static_assert(N >= 1 && N <= 65535);
  std::uint16_t capacity_ = N;
  std::uint16_t length_ = 0;
  Char text_[N]{};
};

// ---- descriptions of types
// ---------------------------------------------------------------------------------------------

namespace detail {

template <class T>
constexpr const char* elementary_name() {
  if constexpr (std::is_same_v<T, bool>) return "BOOL";
  if constexpr (std::is_same_v<T, std::int8_t>) return "SINT";
  if constexpr (std::is_same_v<T, std::int16_t>) return "INT";
  if constexpr (std::is_same_v<T, std::int32_t>) return "DINT";
  if constexpr (std::is_same_v<T, std::int64_t>) return "LINT";
  if constexpr (std::is_same_v<T, std::uint8_t>) return "USINT";
  if constexpr (std::is_same_v<T, std::uint16_t>) return "UINT";
  if constexpr (std::is_same_v<T, std::uint32_t>) return "UDINT";
  if constexpr (std::is_same_v<T, std::uint64_t>) return "ULINT";
  if constexpr (std::is_same_v<T, float>) return "REAL";
  if constexpr (std::is_same_v<T, double>) return "LREAL";
  if constexpr (std::is_same_v<T, char>) return "CHAR";
  if constexpr (std::is_same_v<T, char16_t>) return "WCHAR";
  if constexpr (std::is_same_v<T, Time>) return "TIME";
  if constexpr (std::is_same_v<T, Byte>) return "BYTE";
  if constexpr (std::is_same_v<T, Word>) return "WORD";
  if constexpr (std::is_same_v<T, Dword>) return "DWORD";
  if constexpr (std::is_same_v<T, Lword>) return "LWORD";
  if constexpr (std::is_same_v<T, Ltime>) return "LTIME";
  if constexpr (std::is_same_v<T, Date>) return "DATE";
  if constexpr (std::is_same_v<T, Ldate>) return "LDATE";
  if constexpr (std::is_same_v<T, TimeOfDay>) return "TIME_OF_DAY";
  if constexpr (std::is_same_v<T, LtimeOfDay>) return "LTIME_OF_DAY";
  if constexpr (std::is_same_v<T, DateAndTime>) return "DATE_AND_TIME";
  if constexpr (std::is_same_v<T, LdateAndTime>) return "LDATE_AND_TIME";
  return nullptr;
}

template <class T>
struct IsText : std::false_type {
  struct View {};  ///< nothing is convertible to it
};
template <std::size_t N, class Char>
struct IsText<Text<N, Char>> : std::true_type {
  using View = std::basic_string_view<Char>;
  static constexpr std::uint32_t kCapacity = N;
  static constexpr bool kWide = !std::is_same_v<Char, char>;
};
template <class T>
struct IsArray : std::false_type {};
template <class T, std::size_t N>
struct IsArray<std::array<T, N>> : std::true_type {
  using Element = T;
  static constexpr std::uint32_t kCount = N;
};

}  // namespace detail

/// Specialised by PICARD_STRUCT: name and fields of a structure that ports may have.
template <class T>
struct StructOf {
  static constexpr bool kDeclared = false;
};
/// Specialised by PICARD_ENUM: name and values of an enumeration that ports may have.
template <class T>
struct EnumOf {
  static constexpr bool kDeclared = false;
};

namespace detail {

template <class T>
PICARD_HIDDEN const picard_type* type_of() {
  static const picard_type type = [] {
    picard_type t{};
    t.size = sizeof(T);
    t.align = alignof(T);
    if constexpr (IsText<T>::value) {
      t.kind = PICARD_STRING;
      t.name = IsText<T>::kWide ? "WSTRING" : "STRING";
      t.capacity = IsText<T>::kCapacity;
    } else if constexpr (IsArray<T>::value) {
      t.kind = PICARD_ARRAY;
      t.name = "";
      t.capacity = IsArray<T>::kCount;
      t.element = type_of<typename IsArray<T>::Element>();
    } else if constexpr (StructOf<T>::kDeclared) {
      static_assert(std::is_standard_layout_v<T> && std::is_trivially_copyable_v<T>);
      t.kind = PICARD_STRUCT_TYPE;
      t.name = StructOf<T>::kName;
      const auto& fields = StructOf<T>::fields();
      t.fields = fields.data();
      t.field_count = static_cast<std::uint32_t>(fields.size());
    } else if constexpr (EnumOf<T>::kDeclared) {
      t.kind = PICARD_ENUM_TYPE;
      t.name = EnumOf<T>::kName;
      t.element = type_of<std::underlying_type_t<T>>();
      t.enumerators = EnumOf<T>::kValues.data();
      t.enumerator_count = static_cast<std::uint32_t>(EnumOf<T>::kValues.size());
    } else {
      static_assert(elementary_name<T>() != nullptr,
                    "a port is of an elementary type, picard::Text, std::array, a PICARD_STRUCT or a PICARD_ENUM");
      t.kind = PICARD_ELEMENTARY;
      t.name = elementary_name<T>();
    }
    return t;
  }();
  return &type;
}

}  // namespace detail

// ---- failures
// ----------------------------------------------------------------------------------------------------------

/// To throw in fire() or ready(): says why. The text lies in here and takes no memory; what is beyond
/// PICARD_TEXT_BYTES - 1 characters is cut.
class Failure : public std::exception {
 public:
  explicit Failure(std::string_view text) noexcept {
    const std::size_t length = text.size() < PICARD_TEXT_BYTES ? text.size() : PICARD_TEXT_BYTES - 1;
    if (length != 0) std::memcpy(text_, text.data(), length);
  }
  /// As printf makes it: throw Failure::format("SIZE is %d, at most %d", size.get(), kMost).
  [[gnu::format(__printf__, 1, 2)]] static Failure format(const char* text, ...) noexcept {
    Failure made{std::string_view()};
    std::va_list values;
    va_start(values, text);
    static_cast<void>(std::vsnprintf(made.text_, sizeof made.text_, text, values));
    va_end(values);
    return made;
  }
  [[nodiscard]] const char* what() const noexcept override { return text_; }

 private:
  char text_[PICARD_TEXT_BYTES]{};
};

// ---- ports
// -------------------------------------------------------------------------------------------------------------

inline constexpr double kNoLimit = std::numeric_limits<double>::infinity();

/// What can be said of a port besides its name and meaning.
struct PortInfo {
  const char* unit = "";  ///< "mm/s"
  /// The range of a number. A configuration outside is refused before ready(), NaN too. An output outside takes the
  /// nearest limit and is an event of the drawn block. At inputs it is for people and HMIs: they may have any value.
  double lowest = -kNoLimit;
  double highest = kNoLimit;
  /// As IEC 61131-3 spells it: "T#100ms", "[1, 2, 3]", "(X := 1.0, NAME := 'a')", "Manual". What is not said is zero,
  /// FALSE, empty, or the first value of an enumeration.
  const char* initial = "";
};

class Taskblock;

namespace detail {

/// Made while an object is: collects its ports, or gives them their places.
struct Construction {
  std::vector<picard_port>* ports = nullptr;               ///< to describe
  std::vector<std::vector<std::byte>>* scratch = nullptr;  ///< values of the object that is made to be described
  void* const* places = nullptr;                           ///< to run
  const picard_context* context = nullptr;
  std::uint32_t next = 0;
};
inline thread_local Construction* construction = nullptr;

inline void* place_port(const char* name, const picard_type* type, std::uint32_t direction, const char* summary,
                        const PortInfo& info) {
  Construction& c = *construction;
  if (c.places != nullptr) return c.places[c.next++];
  c.ports->push_back({name, type, direction, summary, info.unit, info.initial, info.lowest, info.highest});
  c.scratch->emplace_back(type->size + 16);
  return c.scratch->back().data() + (16 - reinterpret_cast<std::uintptr_t>(c.scratch->back().data()) % 16) % 16;
}

/// A value somewhere else that is used like a variable.
template <class T>
class Port {
 public:
  Port(const Port&) = delete;
  Port& operator=(const Port&) = delete;
  [[nodiscard]] const T& get() const { return *at_; }
  operator const T&() const { return *at_; }  // NOLINT(google-explicit-constructor)
  const T* operator->() const { return at_; }
  const T& operator*() const { return *at_; }
  template <class U = T>
  decltype(auto) operator[](std::size_t i) const {
    return static_cast<const U&>(*at_)[i];
  }

 protected:
  Port(const char* name, const char* summary, const PortInfo& info, std::uint32_t direction)
      : at_(static_cast<T*>(place_port(name, type_of<T>(), direction, summary, info))) {}
  T* at_;
};

}  // namespace detail

/// A value that drawings and texts give the block, read only here.
template <class T>
class Input : public detail::Port<T> {
 public:
  Input(Taskblock* /*owner*/, const char* name, const char* summary, const PortInfo& info = {})
      : detail::Port<T>(name, summary, info, PICARD_INPUT) {}
};

/// A constant of the project: a drawn constant, or the initial value of the instance. It is there before ready().
template <class T>
class Config : public detail::Port<T> {
 public:
  Config(Taskblock* /*owner*/, const char* name, const char* summary, const PortInfo& info = {})
      : detail::Port<T>(name, summary, info, PICARD_CONFIG) {
    if constexpr (std::is_arithmetic_v<T>) {
      const bool described = detail::construction->places == nullptr;
      if (described || (info.lowest == -kNoLimit && info.highest == kNoLimit)) return;
      const auto value = static_cast<double>(*this->at_);
      if (!(value >= info.lowest && value <= info.highest))
        throw Failure::format("%s is %g, its range is %g .. %g", name, value, info.lowest, info.highest);
    }
  }
};

/// A value that the block gives; it keeps what was last assigned.
template <class T>
class Output : public detail::Port<T> {
 public:
  Output(Taskblock* /*owner*/, const char* name, const char* summary, const PortInfo& info = {})
      : detail::Port<T>(name, summary, info, PICARD_OUTPUT) {}
  Output& operator=(const T& value) {
    *this->at_ = value;
    return *this;
  }
  /// Any text for a text; what is beyond its capacity is cut.
  template <class Value>
  requires std::is_convertible_v<const Value&, typename detail::IsText<T>::View> Output& operator=(const Value& text) {
    *this->at_ = typename detail::IsText<T>::View(text);
    return *this;
  }
  T& get() { return *this->at_; }
  T* operator->() { return this->at_; }
  T& operator*() { return *this->at_; }
  template <class U = T>
  decltype(auto) operator[](std::size_t i) {
    return static_cast<U&>(*this->at_)[i];
  }
};

/// Takes elements out of a queue that other tasks fill.
template <class T>
class QueueReader {
 public:
  QueueReader(Taskblock* /*owner*/, const char* name, const char* summary)
      : at_(static_cast<picard_queue*>(
            detail::place_port(name, detail::type_of<T>(), PICARD_QUEUE_READER, summary, {}))) {}
  QueueReader(const QueueReader&) = delete;
  QueueReader& operator=(const QueueReader&) = delete;
  /// False, and `element` as it was, when the queue is empty.
  bool pop(T& element) { return at_->pop(at_, &element) != 0; }
  [[nodiscard]] std::uint32_t count() const { return at_->count(at_); }

 private:
  picard_queue* at_;
};

/// Puts elements into a queue that another task empties.
template <class T>
class QueueWriter {
 public:
  QueueWriter(Taskblock* /*owner*/, const char* name, const char* summary)
      : at_(static_cast<picard_queue*>(
            detail::place_port(name, detail::type_of<T>(), PICARD_QUEUE_WRITER, summary, {}))) {}
  QueueWriter(const QueueWriter&) = delete;
  QueueWriter& operator=(const QueueWriter&) = delete;
  /// False when the queue is full.
  bool push(const T& element) { return at_->push(at_, &element) != 0; }
  [[nodiscard]] std::uint32_t space() const { return at_->space(at_); }

 private:
  picard_queue* at_;
};

// ---- blocks
// ------------------------------------------------------------------------------------------------------------

/// What can be said of a class of taskblocks.
struct Info {
  const char* name = "";               ///< "LOWPASS": in capitals, as the type in drawings
  const char* group = "";              ///< "Filters"
  const char* summary = "";            ///< one sentence
  const char* details = "";            ///< Markdown, or nothing
  std::chrono::nanoseconds budget{0};  ///< a fire() that takes longer is a fault of the task; 0 = not measured
};

/// How much a message matters.
enum class Severity : std::uint32_t {
  Note = PICARD_NOTE,        ///< good to know
  Warning = PICARD_WARNING,  ///< somebody should look at it
  Error = PICARD_ERROR,      ///< the component does not do its work
};

class Taskblock {
 public:
  Taskblock() : context_(detail::construction->context), number_(context_->object) {}
  virtual ~Taskblock() = default;
  Taskblock(const Taskblock&) = delete;
  Taskblock& operator=(const Taskblock&) = delete;

  /// Once, before the first cycle: configuration ports have their values. May allocate, wait and throw.
  virtual void ready() {}
  /// Each time the block is executed. No allocation, no lock, nothing that waits. May throw: a fault of the task.
  virtual void fire() = 0;

 protected:
  /// The task's clock, taken once a cycle; its zero is of no meaning.
  [[nodiscard]] std::chrono::nanoseconds now() const { return std::chrono::nanoseconds(context_->now_ns); }
  /// Of the task, in seconds; 0 for event and freewheeling tasks.
  [[nodiscard]] double period() const { return static_cast<double>(context_->period_ns) * 1e-9; }
  /// Tells the operator, in the log of plc-run, a line as printf makes it: tell(picard::Severity::Warning, "sensor %d
  /// is silent", n). Longer ones are cut at PICARD_TEXT_BYTES - 1 bytes. Allocates nothing and never waits; a message
  /// that finds no room is lost and counted, and the log counts one that repeats. For what changes, not for every
  /// cycle. In ready(), fire(), and on threads of the component.
  [[gnu::format(__printf__, 3, 4)]] void tell(Severity severity, const char* format, ...) const noexcept {
    if (context_->tell == nullptr) return;
    char text[PICARD_TEXT_BYTES];
    std::va_list values;
    va_start(values, format);
    static_cast<void>(std::vsnprintf(text, sizeof text, format, values));
    va_end(values);
    context_->tell(context_, number_, static_cast<std::uint32_t>(severity), text);
  }

 private:
  const picard_context* context_;
  std::uint32_t number_;
};

namespace detail {

inline void say(picard_failure* failure, const char* text) noexcept {
  std::size_t i = 0;
  for (; text[i] != '\0' && i + 1 < PICARD_TEXT_BYTES; ++i) failure->text[i] = text[i];
  failure->text[i] = '\0';
}

/// Calls `what`; false, and why, when it throws.
template <class What>
bool contained(picard_failure* failure, What what) noexcept {
  try {
    what();
    return true;
  } catch (const std::exception& error) {
    say(failure, error.what());
  } catch (...) {
    say(failure, "an exception that is no std::exception");
  }
  return false;
}

template <class Block>
PICARD_HIDDEN void* create(void* const* ports, const picard_context* context, picard_failure* failure) noexcept {
  Construction here;
  here.places = ports;
  here.context = context;
  Block* made = nullptr;
  contained(failure, [&] {
    construction = &here;
    made = std::make_unique<Block>().release();
  });
  construction = nullptr;
  return made;
}
template <class Block>
PICARD_HIDDEN int ready(void* object, picard_failure* failure) noexcept {
  return contained(failure, [object] { static_cast<Block*>(object)->ready(); }) ? 1 : 0;
}
template <class Block>
PICARD_HIDDEN int fire(void* object, picard_failure* failure) noexcept {
  return contained(failure, [object] { static_cast<Block*>(object)->fire(); }) ? 1 : 0;
}
template <class Block>
PICARD_HIDDEN void destroy(void* object) noexcept {
  delete static_cast<Block*>(object);
}

/// The ports of a class, by making an object once.
template <class Block>
PICARD_HIDDEN std::vector<picard_port> ports_of() {
  static const picard_context context{};
  std::vector<picard_port> ports;
  std::vector<std::vector<std::byte>> scratch;
  Construction here;
  here.ports = &ports;
  here.scratch = &scratch;
  here.context = &context;
  struct Restore {
    ~Restore() { construction = nullptr; }
  } restore;
  construction = &here;
  const Block described;
  return ports;
}

/// All classes of a library, described when it is first asked for.
template <class... Block>
PICARD_HIDDEN const picard_library* library(const char* name, const char* version) noexcept {
  struct Described {
    std::vector<std::vector<picard_port>> ports;
    std::vector<picard_block> blocks;
    picard_failure failure{};
    picard_library library{};
  };
  static const Described described = [name, version] {
    Described d;
    const bool done = contained(&d.failure, [&d] { (d.ports.push_back(ports_of<Block>()), ...); });
    std::size_t i = 0;
    const auto add = [&d, &i](const Info& info, auto create_, auto ready_, auto fire_, auto destroy_) {
      d.blocks.push_back({info.name, info.group, info.summary, info.details, d.ports[i].data(),
                          static_cast<std::uint32_t>(d.ports[i].size()), info.budget.count(), create_, ready_, fire_,
                          destroy_});
      ++i;
    };
    if (done) (add(Block::info, create<Block>, ready<Block>, fire<Block>, destroy<Block>), ...);
    d.library = {PICARD_ABI_VERSION,
                 sizeof(picard_block),
                 sizeof(picard_port),
                 sizeof(picard_type),
                 name,
                 version,
                 nullptr,
                 d.blocks.data(),
                 static_cast<std::uint32_t>(d.blocks.size())};
    if (!done) d.library.failure = "";
    return d;
  }();
  // WHY here: the text lies in `described`, which has its place only now.
  static const picard_library final_library = [] {
    picard_library l = described.library;
    if (l.failure != nullptr) l.failure = described.failure.text;
    return l;
  }();
  return &final_library;
}

}  // namespace detail

}  // namespace picard

/// After a structure, outside of namespaces: PICARD_STRUCT(Move, "MOVE", x, y, feed) makes it a type that ports and
/// projects have, with these fields in this order.
#define PICARD_STRUCT(T, iec_name, ...)                                             \
  template <>                                                                       \
  struct picard::StructOf<T> {                                                      \
    static constexpr bool kDeclared = true;                                         \
    static constexpr const char* kName = iec_name;                                  \
    PICARD_HIDDEN static const auto& fields() {                                     \
      static const std::array all{PICARD_FOR_EACH_(PICARD_FIELD_, T, __VA_ARGS__)}; \
      return all;                                                                   \
    }                                                                               \
  };
/// After an enumeration of some integer type, outside of namespaces: PICARD_ENUM(Mode, "MODE", Off, Manual, Auto) makes
/// it a type that ports and projects have, with these values. Variables begin with the first.
#define PICARD_ENUM(T, iec_name, ...)                                                                        \
  template <>                                                                                                \
  struct picard::EnumOf<T> {                                                                                 \
    static constexpr bool kDeclared = true;                                                                  \
    static constexpr const char* kName = iec_name;                                                           \
    PICARD_HIDDEN static constexpr std::array kValues{PICARD_FOR_EACH_(PICARD_ENUMERATOR_, T, __VA_ARGS__)}; \
  };
#define PICARD_FIELD_(T, field) \
  picard_field{#field, picard::detail::type_of<decltype(T::field)>(), static_cast<std::uint32_t>(offsetof(T, field))},
#define PICARD_ENUMERATOR_(T, value) picard_enumerator{#value, static_cast<std::int64_t>(T::value)},
#define PICARD_PARENS_ ()
#define PICARD_EXPAND_(...) PICARD_EXPAND3_(PICARD_EXPAND3_(PICARD_EXPAND3_(PICARD_EXPAND3_(__VA_ARGS__))))
#define PICARD_EXPAND3_(...) PICARD_EXPAND2_(PICARD_EXPAND2_(PICARD_EXPAND2_(PICARD_EXPAND2_(__VA_ARGS__))))
#define PICARD_EXPAND2_(...) PICARD_EXPAND1_(PICARD_EXPAND1_(PICARD_EXPAND1_(PICARD_EXPAND1_(__VA_ARGS__))))
#define PICARD_EXPAND1_(...) __VA_ARGS__
#define PICARD_FOR_EACH_(make, T, ...) __VA_OPT__(PICARD_EXPAND_(PICARD_NEXT_(make, T, __VA_ARGS__)))
#define PICARD_NEXT_(make, T, name, ...) make(T, name) __VA_OPT__(PICARD_AGAIN_ PICARD_PARENS_(make, T, __VA_ARGS__))
#define PICARD_AGAIN_() PICARD_NEXT_
/// Once in a library, outside of namespaces: its name, its version, its classes.
#define PICARD_LIBRARY(name, version, ...)                                                          \
  extern "C" __attribute__((visibility("default"))) const picard_library* picard_library_v1(void) { \
    return picard::detail::library<__VA_ARGS__>(name, version);                                     \
  }
/// The same for a library that is linked into a program beside others: `function` takes the place of the exported one.
#define PICARD_LINKED_LIBRARY(function, name, version, ...) \
  const picard_library* function() { return picard::detail::library<__VA_ARGS__>(name, version); }
