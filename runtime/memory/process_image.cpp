#include "runtime/memory/process_image.h"

#include <algorithm>
#include <cstring>
#include <numeric>
#include <tuple>

#include "runtime/memory/location.h"
#include "runtime/memory/shared_words.h"

namespace plc::runtime {
namespace {

/// A scalar of the global table at an address.
struct Span : Location {
  std::size_t field = 0;
  std::uint32_t global = 0;
  std::uint32_t bytes = 1;
};

constexpr std::uint64_t kMaxAreaBits = std::uint64_t{1} << 24;  // 2 MB an area; beyond it a location is on its own

/// Which spans share bits with another one; the others need no work.
std::vector<bool> overlapping(const std::vector<Span>& spans) {
  std::vector<std::size_t> order(spans.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return std::tie(spans[a].area, spans[a].first_bit) < std::tie(spans[b].area, spans[b].first_bit);
  });
  std::vector<bool> shared(spans.size(), false);
  std::uint64_t end_bit = 0;  // of all spans of the area so far
  for (std::size_t i = 0; i < order.size(); ++i) {
    const Span& span = spans[order[i]];
    if (i == 0 || spans[order[i - 1]].area != span.area) end_bit = 0;
    const bool before = span.first_bit < end_bit;
    const bool after = i + 1 < order.size() && spans[order[i + 1]].area == span.area &&
                       spans[order[i + 1]].first_bit < span.first_bit + span.bits;
    shared[order[i]] = before || after;
    end_bit = std::max(end_bit, span.first_bit + span.bits);
  }
  return shared;
}

/// The locations that can overlap, by declaration.
std::vector<Span> located(const bytecode::Image& image) {
  std::vector<Span> spans;
  if (image.options.profile != core::AddressProfile::kOverlay) return spans;
  const bytecode::ImageType& table = image.types[image.global_type];
  for (std::size_t i = 0; i < image.globals.size(); ++i) {
    const auto location = parse_location(image.globals[i].address);
    const bytecode::ImageType& type = image.types[table.fields[i].type];
    if (!location || type.kind != bytecode::TypeKind::kScalar) continue;
    if (location->first_bit + location->bits > kMaxAreaBits) continue;
    const bool is_bool = bytecode::rep_of(type) == core::Rep::kBool;
    if (is_bool ? location->bits != 1 : type.size * 8 != location->bits) continue;
    spans.push_back({*location, i, table.fields[i].offset, type.size});
  }
  return spans;
}

}  // namespace

std::vector<FieldBits> overlapping_globals(const bytecode::Image& image) {
  std::vector<FieldBits> fields;
  const std::vector<Span> spans = located(image);
  const std::vector<bool> shared = overlapping(spans);
  for (std::size_t i = 0; i < spans.size(); ++i) {
    if (!shared[i]) continue;
    fields.push_back({static_cast<std::uint32_t>(spans[i].field), spans[i].area, spans[i].first_bit, spans[i].bits});
  }
  return fields;
}

ProcessImage::ProcessImage(const bytecode::Image& image, GlobalTable& globals) : globals_(globals) {
  const std::vector<Span> spans = located(image);
  const std::vector<bool> shared = overlapping(spans);
  std::uint32_t base = 0;
  for (const char area : {'I', 'Q', 'M'}) {
    std::uint64_t end_bit = 0;
    for (std::size_t i = 0; i < spans.size(); ++i) {
      const Span& span = spans[i];
      if (span.area != area || !shared[i]) continue;
      locations_.push_back({span.global, span.bytes, base + static_cast<std::uint32_t>(span.first_bit), span.bits});
      end_bit = std::max(end_bit, span.first_bit + span.bits);
    }
    base += static_cast<std::uint32_t>((end_bit + 63) / 64 * 64);
  }
  packed_.resize(base / 8);
  next_.resize(packed_.size());
  found_.resize(locations_.size());
}

std::uint64_t ProcessImage::load(const Location& location) const noexcept {
  std::byte bytes[8] = {};
  copy_from_shared(bytes, globals_.overlapping_.data() + location.global, location.bytes);
  std::uint64_t value = 0;
  std::memcpy(&value, bytes, sizeof value);
  return value;
}

std::uint64_t ProcessImage::packed(const Location& location) const noexcept {
  if (location.bits == 1) return (packed_[location.first_bit / 8] >> (location.first_bit % 8)) & 1u;
  std::uint64_t value = 0;
  std::memcpy(&value, packed_.data() + location.first_bit / 8, location.bits / 8);
  return value;
}

void ProcessImage::pack(const Location& location, std::uint64_t value) noexcept {
  std::uint8_t& byte = next_[location.first_bit / 8];
  if (location.bits == 1) {
    const auto mask = static_cast<std::uint8_t>(1u << (location.first_bit % 8));
    byte = static_cast<std::uint8_t>(value != 0 ? byte | mask : byte & ~mask);
  } else {
    std::memcpy(&byte, &value, location.bits / 8);
  }
}

// RT:
void ProcessImage::sync() noexcept {
  if (locations_.empty() || busy_.test_and_set(std::memory_order_acquire)) return;
  // Changes are found against the image as it was, so that what one location brings does not look like another's
  // change.
  for (std::size_t i = 0; i < locations_.size(); ++i) {
    found_[i] = load(locations_[i]);
    if (found_[i] != packed(locations_[i])) pack(locations_[i], found_[i]);
  }
  std::copy(next_.begin(), next_.end(), packed_.begin());
  for (std::size_t i = 0; i < locations_.size(); ++i) {
    const std::uint64_t value = packed(locations_[i]);
    if (value == found_[i]) continue;
    // What was written meanwhile stays: the next sync finds it changed.
    std::byte before[8], after[8];
    std::memcpy(before, &found_[i], sizeof before);
    std::memcpy(after, &value, sizeof after);
    replace_shared(globals_.overlapping_.data() + locations_[i].global, before, after, locations_[i].bytes);
  }
  busy_.clear(std::memory_order_release);
}

}  // namespace plc::runtime
