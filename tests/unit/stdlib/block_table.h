// Function blocks driven as the runtime drives them: through the port struct and its fields, one call a cycle, by hand
// or from a table in text (the form of stdlib::BlockExample).
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/unit/stdlib/values.h"

namespace plc::test {

constexpr std::int64_t kMs = 1'000'000;

/// An instance in memory that is no larger than the block says, with a canary after it.
class Instance {
 public:
  explicit Instance(std::string_view name) : spec_(stdlib::block_named(name)) {
    if (spec_ == nullptr) throw std::runtime_error("no block " + std::string(name));
    memory_.assign(spec_->size / 8 + 2, kCanary);
    std::memcpy(memory_.data(), spec_->initial, spec_->size);
  }
  /// The low bytes of `value`, whatever the type of the field is.
  void set(std::string_view name, std::int64_t value) { std::memcpy(at(field(name)), &value, bytes(field(name))); }
  [[nodiscard]] std::int64_t get(std::string_view name) {
    std::uint64_t raw = 0;
    std::memcpy(&raw, at(field(name)), bytes(field(name)));
    const unsigned w = 8 * static_cast<unsigned>(bytes(field(name)));
    const bool negative = core::in_category(field(name).type, core::kAnySigned) && w < 64 && (raw >> (w - 1)) != 0;
    return static_cast<std::int64_t>(negative ? raw | ~0ull << w : raw);
  }
  void set_real(std::string_view name, double value) {
    const auto narrow = static_cast<float>(value);
    std::memcpy(at(field(name)), &narrow, sizeof narrow);
  }
  [[nodiscard]] double real(std::string_view name) {
    float value = 0;
    std::memcpy(&value, at(field(name)), sizeof value);
    return static_cast<double>(value);
  }
  void step(std::int64_t now_ms = 0) { step_ns(now_ms * kMs); }
  void step_ns(std::int64_t now_ns) {
    spec_->step(memory_.data(), stdlib::StepContext{.now_ns = now_ns, .utc_ns = now_ns});
  }

  [[nodiscard]] const stdlib::BlockSpec& spec() const { return *spec_; }
  [[nodiscard]] const stdlib::Field& field(std::string_view name) const {
    const stdlib::Field* f = stdlib::field_named(*spec_, name);
    if (f == nullptr) throw std::runtime_error("no field " + std::string(name) + " in " + std::string(spec_->name));
    return *f;
  }
  std::byte* at(const stdlib::Field& f) { return reinterpret_cast<std::byte*>(memory_.data()) + f.offset; }
  static std::size_t bytes(const stdlib::Field& f) { return core::rep_bytes(core::rep_of(f.type)); }
  [[nodiscard]] bool canary_is_whole() const { return memory_.back() == kCanary; }

 private:
  static constexpr std::uint64_t kCanary = 0xa5a5a5a5a5a5a5a5ull;

  const stdlib::BlockSpec* spec_;
  std::vector<std::uint64_t> memory_;
};

/// The words of each line that has any.
inline std::vector<std::vector<std::string>> words_of(std::string_view table) {
  std::vector<std::vector<std::string>> lines;
  std::istringstream in{std::string(table)};
  for (std::string line; std::getline(in, line);) {
    for (std::size_t bar = line.find('|'); bar != std::string::npos; bar = line.find('|', bar + 3))
      line.replace(bar, 1, " | ");
    std::istringstream words(line);
    std::vector<std::string> cells;
    for (std::string word; words >> word;) cells.push_back(word);
    if (!cells.empty()) lines.push_back(cells);
  }
  return lines;
}

/// Runs a table on a fresh instance; each line that the block contradicts is a failure of its own.
inline void run_table(std::string_view block, std::string_view title, std::string_view table) {
  Instance instance(block);
  const std::vector<std::vector<std::string>> lines = words_of(table);
  ASSERT_GE(lines.size(), 2u) << block << ": " << title;
  const std::vector<std::string>& names = lines[0];
  const auto bar = static_cast<std::size_t>(std::find(names.begin(), names.end(), "|") - names.begin());
  ASSERT_TRUE(names[0] == "at" && bar > 0 && bar + 1 < names.size()) << block << ": " << title;
  for (std::size_t c = 1; c < names.size(); ++c) {
    if (c == bar) continue;
    const auto wanted = c < bar ? stdlib::Direction::kInput : stdlib::Direction::kOutput;
    ASSERT_EQ(instance.field(names[c]).direction, wanted) << block << "." << names[c];
  }
  for (std::size_t l = 1; l < lines.size(); ++l) {
    const std::vector<std::string>& cells = lines[l];
    std::string where = std::string(block) + ", " + std::string(title) + ":";
    for (const std::string& cell : cells) where += " " + cell;
    ASSERT_EQ(cells.size(), names.size()) << where;
    ASSERT_EQ(cells[bar], "|") << where;
    for (std::size_t c = 1; c < bar; ++c) {
      if (cells[c] == ".") continue;
      const stdlib::Field& field = instance.field(names[c]);
      const Value value(field.type, cells[c]);
      std::memcpy(instance.at(field), value.bytes, Instance::bytes(field));
    }
    instance.step_ns(static_cast<std::int64_t>(Value::integer(cells[0])));
    for (std::size_t c = bar + 1; c < names.size(); ++c) {
      if (cells[c] == ".") continue;
      const stdlib::Field& field = instance.field(names[c]);
      if (field.type == TypeId::kReal) {
        const double expected = Value(field.type, cells[c]).get<float>();
        EXPECT_NEAR(instance.real(names[c]), expected, 1e-6 * std::max(1.0, std::fabs(expected)))
            << where << ": " << names[c];
      } else {
        Value actual(field.type);
        std::memcpy(actual.bytes, instance.at(field), Instance::bytes(field));
        EXPECT_EQ(actual.bits(), Value(field.type, cells[c]).bits()) << where << ": " << names[c];
      }
    }
  }
  EXPECT_TRUE(instance.canary_is_whole()) << block;
}

}  // namespace plc::test
