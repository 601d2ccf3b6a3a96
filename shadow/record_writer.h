// RecordWriter: a file of recorded scans as it grows.
//
// In: blocks. Out: a file that ends with a whole block, whatever happened: what a full disk left of a block is taken
// away again. Readable by its owner alone, since it shows how a plant works. Threads: one. Does not belong here: the
// form (record_file.h).
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "core/result.h"
#include "shadow/record_file.h"

namespace plc::shadow {

class RecordWriter {
 public:
  /// Makes the file anew, with these bytes: a head (file_head()), or more. P7631 when that cannot be; a
  /// file that could not take them is removed.
  static core::Result<std::unique_ptr<RecordWriter>> open(const std::string& path, std::span<const std::byte> begin);
  ~RecordWriter();
  RecordWriter(const RecordWriter&) = delete;
  RecordWriter& operator=(const RecordWriter&) = delete;

  /// False when the block could not be written; the next one is tried again.
  bool write(std::span<const std::byte> block);
  /// Why the last block could not be written (P7631); nothing when it was.
  [[nodiscard]] std::optional<core::Problem> problem() const;
  [[nodiscard]] std::uint64_t bytes() const noexcept { return bytes_; }

 private:
  RecordWriter(int descriptor, std::string path) : descriptor_(descriptor), path_(std::move(path)) {}
  int descriptor_;
  std::string path_;
  std::uint64_t bytes_ = 0;  ///< whole blocks
  int error_ = 0;
};

}  // namespace plc::shadow
