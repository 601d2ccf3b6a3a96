#include "runtime/interpreter/pointer_ops.h"

#include "runtime/interpreter/operations.h"
#include "runtime/pointers/objects.h"

namespace plc::runtime {
namespace {

using stdlib::Event;

void report(Machine& m, const std::uint32_t* pc, Reached reached) noexcept {
  if (reached != Reached::kFine) [[unlikely]]
    raise(m, pc, reached == Reached::kCut ? Event::kTruncated : Event::kBadPointer);
}

}  // namespace

// RT:
Pointer address_of(Machine& m, const std::uint32_t* pc, const std::byte* part, std::uint32_t type) noexcept {
  if (part == nullptr) return {};
  const Pointer made = m.objects->address_of(static_cast<std::uint32_t>(part - m.table), type);
  if (made.bits == 0) [[unlikely]]
    raise(m, pc, Event::kBadPointer);
  return made;
}

// RT:
void load_through(Machine& m, const std::uint32_t* pc, std::optional<Pointer> from, const std::uint32_t* type,
                  std::byte* to) noexcept {
  const auto capacity = static_cast<std::uint16_t>(type[1]);
  const Reached reached = from ? m.objects->load(m.table, *from, type[0], to, capacity) : Reached::kNowhere;
  if (reached == Reached::kNowhere) [[unlikely]] {
    const std::uint32_t bytes = m.objects->stored_bytes(type[0]);
    if (bytes == 0) {
      // A text.
      store(to, core::StringHeader{capacity, 0});
    } else {
      std::memcpy(to, load_pointer<const std::byte*>(type + 2), bytes);
    }
  }
  if (from) report(m, pc, reached);
}

// RT:
void store_through(Machine& m, const std::uint32_t* pc, std::optional<Pointer> to, const std::uint32_t* type,
                   const std::byte* from) noexcept {
  if (!to) return;
  report(m, pc, m.objects->store(m.table, *to, type[0], from, static_cast<std::uint16_t>(type[1])));
}

// RT:
Handle handle_through(Machine& m, const std::uint32_t* pc, std::optional<Pointer> to, std::uint32_t type) noexcept {
  if (!to) return {};
  const auto place = m.objects->place_of(*to, type);
  if (!place) [[unlikely]] {
    raise(m, pc, Event::kBadPointer);
    return {};
  }
  return handle_of(m, m.table + *place, type);
}

// RT:
std::uint32_t pointer_to_32(Machine& m, const std::uint32_t* pc, Pointer pointer) noexcept {
  const auto address = m.objects->to_32(pointer);
  if (!address) [[unlikely]]
    raise(m, pc, Event::kBadPointer);
  return address.value_or(0);
}

// RT:
Pointer pointer_from_32(Machine& m, const std::uint32_t* pc, std::uint32_t address) noexcept {
  const auto pointer = m.objects->from_32(address);
  if (!pointer) [[unlikely]]
    raise(m, pc, Event::kBadPointer);
  return pointer.value_or(Pointer{});
}

}  // namespace plc::runtime
