#include "runtime/memory/global_ports.h"

#include <algorithm>
#include <cstring>

#include "core/integer_at.h"
#include "runtime/memory/shared_words.h"

namespace plc::runtime {
namespace {

/// A device knows no subranges: of what it says the nearest value that the type has. RT.
const std::byte* nearest(const bytecode::ImageType& type, const std::byte* value, std::byte (&room)[8]) noexcept {
  if (!type.limited) return value;
  const core::Rep rep = bytecode::rep_of(type);
  const std::optional<std::int64_t> given = core::integer_at(rep, value);
  if (!given) return value;
  // A ULINT above the largest LINT comes as a negative number.
  const bool beyond = rep == core::Rep::kU64 && *given < 0;
  const std::int64_t number = beyond ? type.upper : std::clamp(*given, type.lower, type.upper);
  std::memcpy(room, &number, sizeof number);  // little-endian: narrower integers take the low bytes
  return room;
}

}  // namespace

GlobalReader::GlobalReader(GlobalTable& table) : table_(table) { table.add_view(view_); }
GlobalReader::~GlobalReader() { table_.remove_view(view_); }

// RT:
void GlobalReader::take() noexcept { GlobalTable::hold(view_); }

// RT:
void GlobalReader::read(std::uint32_t offset, std::uint32_t bytes, std::byte* to) const noexcept {
  table_.read_held(view_.held, offset, bytes, to);
}

GlobalInputs::GlobalInputs(GlobalTable& table, std::span<const std::uint32_t> fields)
    : table_(table), owner_(table.claim(fields)) {}

// RT:
void GlobalInputs::set(std::uint32_t offset, std::uint32_t type, const std::byte* value) noexcept {
  std::byte room[8];
  value = nearest(table_.image().types[type], value, room);
  const GlobalTable::Field& field = table_.field_at(offset);
  if (field.kind == GlobalTable::Kind::kOverlapping) {
    table_.write_overlapping({offset, type, value, nullptr});
    return;
  }
  GlobalTable::Owner& own = table_.owners_[owner_];
  table_.merge(own.next(field.at + (offset - field.begin)), type, value, nullptr);
}

// RT:
void GlobalInputs::publish() noexcept { table_.publish_image(owner_); }

}  // namespace plc::runtime
