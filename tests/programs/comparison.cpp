#include "tests/programs/comparison.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include <cstdlib>
#include <cstring>
#include <fstream>
#include <limits>
#include <memory>
#include <sstream>
#include <vector>

#include "compiler/compile.h"
#include "runtime/access.h"
#include "runtime/resource.h"

namespace plc::programs {
namespace {

/// The bits of a scalar, or the code units of a string.
struct Value {
  std::uint64_t bits = 0;
  std::u16string text;
  friend bool operator==(const Value&, const Value&) = default;
};

std::size_t bytes_of(const Type& type) { return type.kind == Kind::kBool ? 1 : type.bits / 8; }

std::string shown(const Value& value, const Type& type) {
  if (type.kind == Kind::kString) {
    std::string out = "'";
    for (const char16_t unit : value.text)
      out += unit >= ' ' && unit < 127 ? fmt::format("{}", static_cast<char>(unit))
                                       : fmt::format("${:02X}", static_cast<unsigned>(unit));
    return out + "'";
  }
  std::string decimal;
  if (type.kind == Kind::kReal && type.bits == 32) {
    float real = 0;
    std::memcpy(&real, &value.bits, sizeof real);
    decimal = fmt::format(" = {}", real);
  } else if (type.kind == Kind::kReal) {
    double real = 0;
    std::memcpy(&real, &value.bits, sizeof real);
    decimal = fmt::format(" = {}", real);
  } else {
    const unsigned unused = 64 - static_cast<unsigned>(bytes_of(type)) * 8;
    decimal = fmt::format(" = {}", static_cast<std::int64_t>(value.bits << unused) >> unused);
  }
  return fmt::format("16#{:x}{}", value.bits, decimal);
}

/// The program as a shared object made by the C compiler.
class Native {
 public:
  Native(const Program& program, const ComparisonPlan& plan) {
    const std::string source = plan.folder + "/program.c";
    // A name of its own: the dynamic linker knows objects by theirs.
    static int count = 0;
    const std::string object = fmt::format("{}/program{}.so", plan.folder, ++count);
    std::ofstream(source) << program.c(plan.prelude);
    const std::string command = fmt::format(
        "{} -std=gnu11 -O1 -fwrapv -ffp-contract=off -fno-builtin -w -shared -fPIC -o {} {} -lm 2> {}/cc.txt",
        PLC_C_COMPILER, object, source, plan.folder);
    if (std::system(command.c_str()) != 0) return;
    library_ = ::dlopen(object.c_str(), RTLD_NOW | RTLD_LOCAL);
    static_cast<void>(std::remove(object.c_str()));
    if (library_ == nullptr) return;
    const auto leaf = reinterpret_cast<void* (*)(unsigned)>(::dlsym(library_, "plc_leaf"));
    for (unsigned i = 0; i < program.leaves.size(); ++i) leaves_.push_back(static_cast<unsigned char*>(leaf(i)));
    scan_ = reinterpret_cast<void (*)()>(::dlsym(library_, "plc_scan"));
    executed_ = reinterpret_cast<unsigned long long (*)()>(::dlsym(library_, "plc_executed"));
    reinterpret_cast<void (*)()>(::dlsym(library_, "plc_init"))();
  }
  ~Native() {
    if (library_ != nullptr) ::dlclose(library_);
  }
  Native(const Native&) = delete;
  Native& operator=(const Native&) = delete;

  [[nodiscard]] bool ok() const { return library_ != nullptr; }
  void scan() { scan_(); }
  [[nodiscard]] std::uint64_t executed() const { return executed_(); }
  [[nodiscard]] Value read(std::size_t leaf, const Type& type) const {
    Value value;
    if (type.kind != Kind::kString) {
      std::memcpy(&value.bits, leaves_[leaf], bytes_of(type));
      return value;
    }
    std::uint16_t length = 0;
    std::memcpy(&length, leaves_[leaf], sizeof length);
    value.text.resize(length);
    std::memcpy(value.text.data(), leaves_[leaf] + sizeof length, length * sizeof(char16_t));
    return value;
  }
  void write(std::size_t leaf, const Type& type, const Value& value) {
    if (type.kind != Kind::kString) {
      std::memcpy(leaves_[leaf], &value.bits, bytes_of(type));
      return;
    }
    const auto length = static_cast<std::uint16_t>(value.text.size());
    std::memcpy(leaves_[leaf], &length, sizeof length);
    std::memcpy(leaves_[leaf] + sizeof length, value.text.data(), length * sizeof(char16_t));
  }

 private:
  void* library_ = nullptr;
  void (*scan_)() = nullptr;
  unsigned long long (*executed_)() = nullptr;
  std::vector<unsigned char*> leaves_;
};

/// The program through the pipeline, with the place of every variable.
class Compiled {
 public:
  Compiled(const Program& program, const ComparisonPlan& plan) {
    const std::string path = plan.folder + "/program.st";
    std::ofstream(path) << program.st();
    compiler::Compilation compilation;
    compiler::compile({path, {}, compiler::Goal::kRun}, compilation);
    std::ostringstream problems;
    if (!compilation.ok() || !compilation.image) {
      compilation.diagnostics.render(problems);
      problem_ = problems.str().empty() ? "no image" : problems.str();
      return;
    }
    auto loaded = runtime::Resource::load(std::move(*compilation.image));
    if (!loaded) {
      problem_ = loaded.error().message;
      return;
    }
    resource_ = std::move(*loaded);
    const runtime::Access access(*resource_);
    for (const Leaf& leaf : program.leaves) {
      const auto place = access.find_leaf(leaf.path);
      if (!place) {
        problem_ = place.error().message;
        return;
      }
      places_.push_back(*place);
    }
  }
  [[nodiscard]] const std::string& problem() const { return problem_; }
  [[nodiscard]] bool scan(core::TimeNs now_ns) { return !resource_->program(0).execute({now_ns}); }

  [[nodiscard]] Value read(std::size_t leaf, const Type& type) {
    const runtime::Place& place = places_[leaf];
    if (place.task == runtime::Place::kGlobal) return global(place, type);
    const std::byte* at = resource_->program(place.task).table().data() + place.offset;
    Value value;
    if (type.kind != Kind::kString) {
      std::memcpy(&value.bits, at, bytes_of(type));
      return value;
    }
    core::StringHeader header;
    std::memcpy(&header, at, sizeof header);
    at += sizeof header;
    for (std::size_t i = 0; i < header.length; ++i) {
      char16_t unit = 0;
      std::memcpy(&unit, at + i * (type.is_long ? 2 : 1), type.is_long ? 2 : 1);
      value.text += unit;
    }
    return value;
  }
  void write(std::size_t leaf, const Type& type, const Value& value) {
    std::byte* at = resource_->program(places_[leaf].task).table().data() + places_[leaf].offset;
    if (type.kind != Kind::kString) {
      std::memcpy(at, &value.bits, bytes_of(type));
      return;
    }
    core::StringHeader header;
    std::memcpy(&header, at, sizeof header);
    header.length = static_cast<std::uint16_t>(value.text.size());
    std::memcpy(at, &header, sizeof header);
    for (std::size_t i = 0; i < value.text.size(); ++i) {
      const char16_t unit = value.text[i];
      std::memcpy(at + sizeof header + i * (type.is_long ? 2 : 1), &unit, type.is_long ? 2 : 1);
    }
  }

 private:
  /// Globals live in their own table, read as text; they are numbers only.
  [[nodiscard]] Value global(const runtime::Place& place, const Type& type) {
    const std::string text = runtime::Access(*resource_).read(place);
    Value value;
    if (type.kind == Kind::kReal && type.bits == 32) {
      const float real = std::strtof(text.c_str(), nullptr);
      std::memcpy(&value.bits, &real, sizeof real);
    } else if (type.kind == Kind::kReal) {
      const double real = std::strtod(text.c_str(), nullptr);
      std::memcpy(&value.bits, &real, sizeof real);
    } else {
      value.bits = text.starts_with('-') ? static_cast<std::uint64_t>(std::strtoll(text.c_str(), nullptr, 10))
                                         : std::strtoull(text.c_str(), nullptr, 10);
      value.bits &= ~std::uint64_t{0} >> (64 - bytes_of(type) * 8);
    }
    return value;
  }

  std::string problem_;
  std::unique_ptr<runtime::Resource> resource_;
  std::vector<runtime::Place> places_;
};

/// What is at an input: edges of its type, small numbers, anything.
Value random_input(const Type& type, Random& random) {
  Value value;
  switch (type.kind) {
    case Kind::kBool:
      value.bits = random.below(2);
      return value;
    case Kind::kString:
      for (std::size_t n = random.below(type.capacity + 1u); n > 0; --n) {
        value.text += static_cast<char16_t>(random.between('a', 'f'));
      }
      return value;
    case Kind::kEnum:
      value.bits = static_cast<std::uint64_t>(random.pick(type.values).second);
      return value;
    case Kind::kSubrange:
      value.bits = static_cast<std::uint64_t>(random.between(type.lower, type.upper));
      break;
    case Kind::kDate:
      value.bits = random.below(40'000) * 86'400'000'000'000ull;
      return value;
    case Kind::kTod:
      value.bits = random.bits() % 86'400'000'000'000ull;
      return value;
    case Kind::kReal: {
      static const std::vector<double> kOdd = {
          0.0,  -0.0, 1.0,   -1.0, 0.5,   1.5,   2.5,
          -2.5, 1e10, -1e10, 3e38, 1e300, 1e-40, std::numeric_limits<double>::infinity()};
      const double real = random.chance(40) ? random.pick(kOdd) : static_cast<double>(random.between(-4000, 4000)) / 16;
      const bool is_nan = random.chance(3);
      if (type.bits == 32) {
        const auto narrow = static_cast<float>(real);
        std::memcpy(&value.bits, &narrow, sizeof narrow);
        if (is_nan) value.bits = 0x7fc00000u;
      } else {
        std::memcpy(&value.bits, &real, sizeof real);
        if (is_nan) value.bits = 0x7ff8000000000000ull;
      }
      return value;
    }
    default:
      value.bits = random.chance(50)   ? static_cast<std::uint64_t>(random.between(-5, 12))
                   : random.chance(30) ? std::uint64_t{1} << random.below(type.bits)
                                       : random.bits();
  }
  const unsigned unused = 64 - static_cast<unsigned>(bytes_of(type)) * 8;
  value.bits = value.bits << unused >> unused;
  return value;
}

}  // namespace

Outcome compare(const Program& program, const ComparisonPlan& plan) {
  Outcome out;
  Compiled compiled(program, plan);
  if (!compiled.problem().empty()) {
    out.kind = Outcome::Kind::kRefused;
    out.text = compiled.problem();
    return out;
  }
  Native native(program, plan);
  if (!native.ok()) {
    out.kind = Outcome::Kind::kUntranslated;
    std::ifstream in(plan.folder + "/cc.txt");
    out.text.assign(std::istreambuf_iterator<char>(in), {});
    return out;
  }
  Random random(program.seed + 1);
  for (std::uint32_t scan = 0; scan <= plan.scans; ++scan) {
    if (scan > 0) {
      for (std::size_t i = 0; i < program.leaves.size(); ++i) {
        const Leaf& leaf = program.leaves[i];
        if (!leaf.input) continue;
        const Value value = random_input(*leaf.type, random);
        native.write(i, *leaf.type, value);
        compiled.write(i, *leaf.type, value);
      }
      native.scan();
      if (!compiled.scan(static_cast<core::TimeNs>(scan) * 10'000'000)) {
        out.kind = Outcome::Kind::kFault;
        out.text = fmt::format("scan {} ended with a fault", scan);
        return out;
      }
    }
    for (std::size_t i = 0; i < program.leaves.size(); ++i) {
      const Leaf& leaf = program.leaves[i];
      const Value expected = native.read(i, *leaf.type);
      const Value actual = compiled.read(i, *leaf.type);
      if (expected == actual) continue;
      out.kind = Outcome::Kind::kDifferent;
      out.text = fmt::format("{} : {} after scan {}: C has {}, the engine has {}", leaf.path, leaf.type->st, scan,
                             shown(expected, *leaf.type), shown(actual, *leaf.type));
      return out;
    }
  }
  out.statements = native.executed();
  return out;
}

}  // namespace plc::programs
