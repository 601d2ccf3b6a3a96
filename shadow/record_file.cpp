#include "shadow/record_file.h"

#include <fmt/format.h>
#include <xxhash.h>
#include <zstd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <system_error>

#include "shadow/packed_records.h"

namespace plc::shadow {
namespace {

using core::Code;
using core::Problem;

constexpr char kFileMagic[8] = {'P', 'I', 'C', 'R', 'E', 'C', '\0', '\n'};
constexpr std::uint32_t kBlockMagic = 0x4b4c4250;  // "PBLK"
/// No table or block is larger; what says so is damaged.
constexpr std::uint32_t kMostBytes = 1u << 31;
/// Fast: the shadow packs beside a plant. Higher levels gain a few hundredths.
constexpr int kLevel = 1;

/// Head of a block; what it holds follows, compressed: table, then packed records.
struct BlockHead {
  std::uint32_t magic = kBlockMagic;
  std::uint32_t task = 0;
  std::uint64_t first_scan = 0;
  std::int64_t first_ns = 0, last_ns = 0;
  std::uint32_t scans = 0;
  std::uint32_t table_bytes = 0;
  std::uint32_t record_bytes = 0;
  std::uint32_t stored_bytes = 0;
  std::uint64_t check = 0;  ///< XXH3 of what is stored, then of this head with 0 here
};
static_assert(sizeof(BlockHead) == 56);

std::uint64_t check_of(BlockHead head, const std::byte* stored) {
  head.check = 0;
  return XXH3_64bits_withSeed(&head, sizeof head, XXH3_64bits(stored, head.stored_bytes));
}

template <class T>
void append(std::vector<std::byte>& out, const T& value) {
  const auto* const bytes = reinterpret_cast<const std::byte*>(&value);
  out.insert(out.end(), bytes, bytes + sizeof value);
}
void append_bytes(std::vector<std::byte>& out, std::span<const std::byte> bytes) {
  append(out, static_cast<std::uint64_t>(bytes.size()));
  out.insert(out.end(), bytes.begin(), bytes.end());
}
void append_text(std::vector<std::byte>& out, const std::string& text) {
  append_bytes(out, std::as_bytes(std::span(text)));
}

/// Reads one after the other; whatever is not there is a failure, and zero.
class Cursor {
 public:
  explicit Cursor(std::span<const std::byte> bytes) : rest_(bytes) {}
  template <class T>
  T get() {
    T value{};
    if (const auto from = take(sizeof value); !from.empty()) std::memcpy(&value, from.data(), sizeof value);
    return value;
  }
  std::span<const std::byte> bytes() { return take(get<std::uint64_t>()); }
  std::string text() {
    const auto from = bytes();
    return {reinterpret_cast<const char*>(from.data()), from.size()};
  }
  [[nodiscard]] bool failed() const { return failed_; }
  [[nodiscard]] std::size_t left() const { return rest_.size(); }

 private:
  std::span<const std::byte> take(std::uint64_t count) {
    if (count > rest_.size()) {
      failed_ = true;
      rest_ = {};
      return {};
    }
    const auto part = rest_.first(static_cast<std::size_t>(count));
    rest_ = rest_.subspan(static_cast<std::size_t>(count));
    return part;
  }
  std::span<const std::byte> rest_;
  bool failed_ = false;
};

Problem refused(const std::string& name, const std::string& why, std::string help = {}) {
  return {Code::P7630, name + ": " + why, std::move(help)};
}

}  // namespace

// ---- writing

std::vector<std::byte> file_head(const RecordingHead& head) {
  std::vector<std::byte> body;
  append_text(body, head.product);
  append_text(body, head.processor);
  append(body, head.arithmetic);
  append(body, head.loop_budget);
  append_text(body, head.zone);
  append_bytes(body, head.image);
  std::vector<std::byte> out;
  append(out, kFileMagic);
  append(out, kRecordFileVersion);
  append(out, XXH3_64bits(body.data(), body.size()));
  append_bytes(out, body);
  return out;
}

void BlockBuilder::begin(std::uint32_t task, std::uint64_t first_scan, std::span<const std::byte> table) {
  info_ = {};
  info_.task = task;
  info_.first_scan = first_scan;
  block_.table.assign(table.begin(), table.end());
  block_.records.clear();
  open_ = true;
}

bool BlockBuilder::add(std::span<const std::byte> record) {
  runtime::RecordHead head;
  std::memcpy(&head, record.data(), sizeof head);
  if (!open_ || head.scan != info_.first_scan + info_.scans) return false;
  if (info_.scans == 0) info_.first_ns = head.now_ns;
  info_.last_ns = head.now_ns;
  ++info_.scans;
  block_.records.insert(block_.records.end(), record.begin(), record.end());
  return true;
}

void BlockBuilder::close() {
  open_ = false;
  block_ = {};
}

std::vector<std::byte> BlockBuilder::pack() const {
  std::vector<std::byte> raw = block_.table;
  BlockHead head;
  head.task = info_.task;
  head.first_scan = info_.first_scan;
  head.first_ns = info_.first_ns;
  head.last_ns = info_.last_ns;
  head.scans = info_.scans;
  head.table_bytes = static_cast<std::uint32_t>(raw.size());
  head.record_bytes = static_cast<std::uint32_t>(block_.records.size());
  const std::vector<std::byte> packed = pack_records(block_.records);
  raw.insert(raw.end(), packed.begin(), packed.end());
  std::vector<std::byte> out(sizeof head + ZSTD_compressBound(raw.size()));
  const std::size_t stored =
      ZSTD_compress(out.data() + sizeof head, out.size() - sizeof head, raw.data(), raw.size(), kLevel);
  if (ZSTD_isError(stored) != 0) return {};
  head.stored_bytes = static_cast<std::uint32_t>(stored);
  head.check = check_of(head, out.data() + sizeof head);
  std::memcpy(out.data(), &head, sizeof head);
  out.resize(sizeof head + stored);
  return out;
}

// ---- reading

core::Result<RecordFile> RecordFile::open(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) return Problem{Code::P7001, path + ": " + std::system_category().message(errno), {}};
  const std::string text((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  if (in.bad()) return refused(path, "cannot be read");
  const auto bytes = std::as_bytes(std::span(text));
  return read({bytes.begin(), bytes.end()}, path);
}

core::Result<RecordFile> RecordFile::read(std::vector<std::byte> bytes, const std::string& name) {
  RecordFile file;
  file.bytes_ = std::move(bytes);
  Cursor cursor(file.bytes_);
  char magic[sizeof kFileMagic];
  for (char& c : magic) c = cursor.get<char>();
  if (cursor.failed() || std::memcmp(magic, kFileMagic, sizeof magic) != 0) {
    return refused(name, "is no recording", "plc sim --record FILE and plc-run --record FOLDER make some");
  }
  const auto version = cursor.get<std::uint32_t>();
  if (!cursor.failed() && version != kRecordFileVersion) {
    return refused(
        name, fmt::format("is a recording of version {}; this PICARD reads version {}", version, kRecordFileVersion));
  }
  const auto check = cursor.get<std::uint64_t>();
  const std::span<const std::byte> body = cursor.bytes();
  if (cursor.failed() || XXH3_64bits(body.data(), body.size()) != check)
    return refused(name, "its head is cut or damaged");
  Cursor in(body);
  file.head_.product = in.text();
  file.head_.processor = in.text();
  file.head_.arithmetic = in.get<std::uint64_t>();
  file.head_.loop_budget = in.get<std::uint32_t>();
  file.head_.zone = in.text();
  const auto image = in.bytes();
  if (in.failed()) return refused(name, "its head is cut or damaged");
  file.head_.image.assign(image.begin(), image.end());

  std::uint64_t at = file.bytes_.size() - cursor.left();
  while (at < file.bytes_.size()) {
    BlockHead head;
    const std::uint64_t left = file.bytes_.size() - at;
    bool whole = left >= sizeof head;
    if (whole) {
      std::memcpy(&head, &file.bytes_[at], sizeof head);
      whole = head.magic == kBlockMagic && head.stored_bytes <= left - sizeof head && head.table_bytes < kMostBytes &&
              head.record_bytes < kMostBytes && check_of(head, &file.bytes_[at] + sizeof head) == head.check;
    }
    if (!whole) {
      ++file.damaged_bytes_;
      ++at;
      continue;
    }
    file.blocks_.push_back({at, head.task, head.scans, head.first_scan, head.first_ns, head.last_ns, head.table_bytes,
                            head.record_bytes, head.stored_bytes});
    at += sizeof head + head.stored_bytes;
  }
  return file;
}

std::optional<Block> RecordFile::load(const BlockInfo& info) const {
  const std::byte* const stored = &bytes_[info.at] + sizeof(BlockHead);
  const unsigned long long size = ZSTD_getFrameContentSize(stored, info.stored_bytes);
  // What is packed is shorter than the records, but for a few bytes of each column.
  if (size < info.table_bytes || size > std::uint64_t{info.table_bytes} + 2 * std::uint64_t{info.record_bytes} + 4096)
    return {};
  std::vector<std::byte> raw(static_cast<std::size_t>(size));
  if (ZSTD_decompress(raw.data(), raw.size(), stored, info.stored_bytes) != raw.size()) return {};
  auto records = unpack_records(std::span(raw).subspan(info.table_bytes), info.scans, info.record_bytes);
  if (!records) return {};
  Block block;
  block.records = std::move(*records);
  raw.resize(info.table_bytes);
  block.table = std::move(raw);
  return block;
}

}  // namespace plc::shadow
