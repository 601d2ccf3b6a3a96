#include "io-drivers/modbus-rtu/request_stream.h"

#include <algorithm>

#include "io-drivers/modbus-rtu/line.h"

namespace plc::modbus_rtu {
namespace {

/// Before and after a frame there may be so many bytes that a driver made which was switched on or off.
constexpr std::size_t kMaxStray = 2;
constexpr std::uint8_t kLastUnit = 247;

bool is_stray(std::uint8_t byte) { return byte == 0x00 || byte == 0xff; }
bool are_stray(std::span<const std::uint8_t> bytes) {
  return bytes.size() <= kMaxStray && std::ranges::all_of(bytes, is_stray);
}

}  // namespace

void RequestStream::clear() {
  at_ = size_ = 0;
  lost_ = false;
  asked_unit_ = 0;
}

void RequestStream::add(std::span<const std::uint8_t> bytes, core::TimeNs now_ns) {
  last_ns_ = now_ns;
  if (bytes_.size() - size_ < bytes.size()) {
    std::copy(bytes_.begin() + static_cast<std::ptrdiff_t>(at_), bytes_.begin() + static_cast<std::ptrdiff_t>(size_),
              bytes_.begin());
    size_ -= at_;
    at_ = 0;
  }
  if (lost_ || bytes_.size() - size_ < bytes.size()) {
    lost_ = true;
    return;
  }
  std::ranges::copy(bytes, bytes_.begin() + static_cast<std::ptrdiff_t>(size_));
  size_ += bytes.size();
}

RequestStream::Found RequestStream::look_at(std::size_t begin) const {
  const auto bytes = std::span(bytes_).subspan(begin, size_ - begin);
  if (bytes.empty()) return {};
  bool more = false;
  const auto is_whole = [&](std::size_t size) {
    more = more || size == kNotKnownYet || (size != kNeverKnown && size > bytes.size());
    return size != kNotKnownYet && size <= bytes.size() && is_sealed(bytes.first(size));
  };
  const bool may_answer =
      asked_unit_ == bytes[0] && asked_unit_ != 0 && (bytes.size() < 2 || (bytes[1] & 0x7f) == asked_function_);
  if (may_answer && is_whole(answer_size(bytes))) return {What::kAnswer, begin, answer_size(bytes)};
  if (bytes[0] <= kLastUnit && is_whole(request_size(bytes))) return {What::kRequest, begin, request_size(bytes)};
  return {more ? What::kMore : What::kNoFrame, begin, 0};
}

RequestStream::Found RequestStream::look() const {
  Found found = look_at(at_);
  for (std::size_t stray = 1; stray <= kMaxStray && at_ + stray < size_ && is_stray(bytes_[at_ + stray - 1]); ++stray) {
    if (found.what == What::kRequest || found.what == What::kAnswer) break;
    const Found next = look_at(at_ + stray);
    if (next.what != What::kNoFrame) found = next;
  }
  return found;
}

std::span<const std::uint8_t> RequestStream::end_of_all() {
  const auto all = rest();
  at_ = size_;
  asked_unit_ = 0;
  if (all.size() > kMaxFrame || !is_sealed(all)) {
    if (!are_stray(all)) ++damaged_;
    return {};
  }
  ++frames_;
  return is_for_us(all[0]) ? all : std::span<const std::uint8_t>();
}

std::span<const std::uint8_t> RequestStream::take(core::TimeNs now_ns) {
  const core::TimeNs silent_ns = now_ns - last_ns_;
  if (lost_) {
    if (silent_ns < silence_ns_) return {};
    ++damaged_;
    clear();
  }
  while (at_ < size_) {
    const Found found = look();
    const std::size_t end = found.begin + found.size;
    const auto frame = std::span<const std::uint8_t>(bytes_).subspan(found.begin, found.size);
    const auto after = std::span<const std::uint8_t>(bytes_).subspan(end, size_ - end);
    switch (found.what) {
      case What::kMore:
        if (silent_ns < std::max(silence_ns_, kLongestPauseNs)) return {};
        return end_of_all();
      case What::kNothing:
      case What::kNoFrame:
        if (silent_ns < silence_ns_) return {};
        return end_of_all();
      case What::kAnswer:
        asked_unit_ = 0;
        break;
      case What::kRequest: {
        const bool is_last = are_stray(after);
        if (is_for_us(frame[0]) && is_last && silent_ns < silence_ns_) return {};
        asked_unit_ = is_for_us(frame[0]) ? std::uint8_t{0} : frame[0];
        asked_function_ = frame[1];
        if (frame[0] != kBroadcast && (frame[0] != unit_ || !is_last)) break;
        ++frames_;
        at_ = is_last ? size_ : end;
        return frame;
      }
    }
    ++frames_;
    at_ = end;
  }
  at_ = size_ = 0;
  return {};
}

std::optional<core::TimeNs> RequestStream::due() const {
  if (!lost_ && at_ == size_) return std::nullopt;
  const bool waits_for_more = !lost_ && look().what == What::kMore;
  return last_ns_ + (waits_for_more ? std::max(silence_ns_, kLongestPauseNs) : silence_ns_);
}

}  // namespace plc::modbus_rtu
