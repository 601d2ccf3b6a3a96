#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <functional>
#include <limits>
#include <string>

#include "bytecode/verifier.h"

namespace plc::bytecode {

namespace {

template <class T>
T read(const std::byte* at) {
  T value;
  std::memcpy(&value, at, sizeof value);
  return value;
}

template <class F>
bool is_proper_float(const std::byte* at) {
  const F value = read<F>(at);
  if (!std::isnan(value)) return true;
  using Bytes = std::array<std::byte, sizeof(F)>;
  return read<Bytes>(at) == std::bit_cast<Bytes>(std::numeric_limits<F>::quiet_NaN());
}

std::int64_t integer_at(Rep rep, const std::byte* at) {
  switch (rep) {
    case Rep::kI8:
      return read<std::int8_t>(at);
    case Rep::kU8:
      return read<std::uint8_t>(at);
    case Rep::kI16:
      return read<std::int16_t>(at);
    case Rep::kU16:
      return read<std::uint16_t>(at);
    case Rep::kI32:
      return read<std::int32_t>(at);
    case Rep::kU32:
      return read<std::uint32_t>(at);
    default:
      return read<std::int64_t>(at);
  }
}

class TableVerifier {
 public:
  TableVerifier(const Image& image, Report& report) : image_(image), report_(report) {}

  void run() {
    make_plans();
    check_table("the global table", image_.global_type, image_.global_initial);
    check_table("the constants", image_.const_type, image_.const_bytes);
    for (const ImagePou& pou : image_.pous) {
      if (report_.full()) return;
      check_table(fmt::format("the instance of {}", pou.name), pou.instance_type, pou.instance_initial);
      check_table(fmt::format("the frame of {}", pou.name), pou.frame_type, pou.frame_initial);
      if (pou.kind == PouKind::kFunction && !pou.instance_initial.empty()) {
        report_.broken(Rule::kV210,
                       fmt::format("function {} has an instance of {} bytes", pou.name, pou.instance_initial.size()));
      }
    }
    if (!report_.clean()) return;
    if (image_.globals.size() != image_.types[image_.global_type].fields.size()) {
      report_.broken(Rule::kV208, fmt::format("{} globals for {} fields", image_.globals.size(),
                                              image_.types[image_.global_type].fields.size()));
    }
    check_memory();
    check_queues();
  }

 private:
  // Plain integers need no look, and structures may have any number of fields without bytes: what is left is worth its
  // bytes, however often it occurs.
  void make_plans() {
    plans_.resize(image_.types.size());
    for (std::size_t i = 0; i < image_.types.size(); ++i) {
      const ImageType& type = image_.types[i];
      const Rep rep = rep_of(type);
      Plan& plan = plans_[i];
      switch (type.kind) {
        case TypeKind::kScalar:
          plan.any = type.limited || rep == Rep::kBool || rep == Rep::kF32 || rep == Rep::kF64;
          break;
        case TypeKind::kString:
        case TypeKind::kRef:
          plan.any = true;
          break;
        case TypeKind::kArray:
          plan.any = plans_[type.element].any;
          break;
        case TypeKind::kStruct:
          for (std::uint32_t f = 0; f < type.fields.size(); ++f) {
            if (plans_[type.fields[f].type].any) plan.fields.push_back(f);
          }
          plan.any = !plan.fields.empty();
          break;
      }
    }
  }

  void check_table(const std::string& name, std::uint32_t type, std::span<const std::byte> bytes) {
    if (type >= image_.types.size() || image_.types[type].kind != TypeKind::kStruct) {
      report_.broken(Rule::kV201, fmt::format("the type of {} is not a structure", name));
      return;
    }
    if (bytes.size() != image_.types[type].size) {
      report_.broken(Rule::kV202,
                     fmt::format("{} has {} initial bytes, its type {}", name, bytes.size(), image_.types[type].size));
      return;
    }
    table_ = name;
    start_ = bytes.data();
    check_value(type, bytes.data());
  }

  void broken(Rule rule, const std::byte* at) {
    report_.broken(rule, fmt::format("{} at byte {}", table_, at - start_));
  }

  // Nesting is bounded by V106.
  void check_value(std::uint32_t index, const std::byte* at) {
    const ImageType& type = image_.types[index];
    if (report_.full()) return;
    switch (type.kind) {
      case TypeKind::kScalar:
        check_scalar(type, at);
        return;
      case TypeKind::kString: {
        const auto header = read<core::StringHeader>(at);
        if (header.capacity != type.capacity || header.length > type.capacity) broken(Rule::kV204, at);
        return;
      }
      case TypeKind::kArray: {
        const std::uint32_t size = image_.types[type.element].size;
        if (!plans_[type.element].any) return;
        for (std::uint32_t i = 0; i < type.count; ++i) check_value(type.element, at + std::size_t{i} * size);
        return;
      }
      case TypeKind::kStruct:
        for (const std::uint32_t i : plans_[index].fields) check_value(type.fields[i].type, at + type.fields[i].offset);
        return;
      case TypeKind::kRef:
        if (read<std::uint64_t>(at) != 0) broken(Rule::kV205, at);
        return;
    }
  }

  void check_scalar(const ImageType& type, const std::byte* at) {
    const Rep rep = rep_of(type);
    if (rep == Rep::kBool && read<std::uint8_t>(at) > 1) broken(Rule::kV203, at);
    if (rep == Rep::kF32 && !is_proper_float<float>(at)) broken(Rule::kV207, at);
    if (rep == Rep::kF64 && !is_proper_float<double>(at)) broken(Rule::kV207, at);
    if (!type.limited) return;
    const std::int64_t value = integer_at(rep, at);
    if (value < type.lower || value > type.upper) broken(Rule::kV206, at);
  }

  void check_memory() {
    std::uint64_t common = image_.global_initial.size() + image_.const_bytes.size();
    for (const ImagePou& pou : image_.pous) common += pou.frame_initial.size();
    std::uint64_t total = 0;
    for (const ImageTask& task : image_.tasks) {
      // verify_calls() reports a body that does not exist.
      const std::uint64_t instance =
          task.body < image_.pous.size() ? image_.pous[task.body].instance_initial.size() : 0;
      if (common + instance > kMaxTableBytes) {
        report_.broken(Rule::kV209, fmt::format("task {} needs {} bytes", task.name, common + instance));
      }
      total += common + instance;
    }
    if (total > kMaxTotalBytes) report_.broken(Rule::kV209, fmt::format("the tasks need {} bytes", total));
  }

  void check_queues() {
    const auto task_exists = [this](std::uint32_t task) { return task < image_.tasks.size(); };
    for (std::size_t q = 0; q < image_.queues.size() && !report_.full(); ++q) {
      const ImageQueue& queue = image_.queues[q];
      const bool sound =
          queue.type < image_.types.size() && queue.capacity != 0 &&
          std::uint64_t{image_.types[queue.type].size} * queue.capacity <=
              kMaxTableBytes / std::max<std::size_t>(queue.puts.size(), 1) &&
          (queue.takes == ImageQueue::kNoTask || task_exists(queue.takes)) &&
          std::all_of(queue.puts.begin(), queue.puts.end(), task_exists) &&
          std::adjacent_find(queue.puts.begin(), queue.puts.end(), std::greater_equal<>()) == queue.puts.end();
      if (!sound) report_.broken(Rule::kV211, fmt::format("queue {} (\"{}\")", q, queue.name));
    }
  }

  struct Plan {
    bool any = false;                   // something of the type is worth a look
    std::vector<std::uint32_t> fields;  // those of a structure
  };

  const Image& image_;
  Report& report_;
  std::vector<Plan> plans_;  // per type
  std::string table_;
  const std::byte* start_ = nullptr;
};

}  // namespace

void verify_tables(const Image& image, Report& report) { TableVerifier(image, report).run(); }

}  // namespace plc::bytecode
