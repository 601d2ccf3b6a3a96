#include "runtime/memory/global_ports.h"

#include <cstring>

#include "runtime/memory/shared_words.h"

namespace plc::runtime {

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
