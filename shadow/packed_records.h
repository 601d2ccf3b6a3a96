// Packed records: the records of a block in a form that compresses well, and back.
//
// Heads become columns of differences from one scan to the next, of which nearly all are 0; what a scan took in is
// stored as what differs from the scan before, where both are of one length. Of each check 16 bits remain: a replica
// that differs goes on differing, and the next table is compared whole. In: records of scans that follow each other, or
// bytes of a file that nobody vouches for. Does not belong here: compressing (record_file.cpp).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace plc::shadow {

std::vector<std::byte> pack_records(std::span<const std::byte> records);
/// `scans` records of `record_bytes` in all; nothing when the bytes are not that.
std::optional<std::vector<std::byte>> unpack_records(std::span<const std::byte> packed, std::uint32_t scans,
                                                     std::uint32_t record_bytes);

}  // namespace plc::shadow
