#include "retain/store.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>
#include <xxhash.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <system_error>

#include "bytecode/byte_io.h"

namespace plc::retain {
namespace {

using bytecode::load_le;
using bytecode::store_le;

constexpr std::array<unsigned char, 8> kMagic = {'P', 'L', 'C', 'K', 'E', 'E', 'P', 0x1a};
constexpr std::uint32_t kVersion = 1;
constexpr std::size_t kVersionAt = 8, kLayoutBytesAt = 12, kValueBytesAt = 16, kLayoutHashAt = 24, kHeaderBytes = 32;
constexpr std::size_t kTimeAt = 8, kTimeOfDayAt = 16, kChecksumAt = 24, kSlotHeaderBytes = 32;
/// What disks write whole, at least as often as anything.
constexpr std::uint64_t kBlock = 4096;
constexpr const char* kNewName = "retain.new";

std::uint64_t rounded(std::uint64_t bytes) { return (bytes + kBlock - 1) / kBlock * kBlock; }

/// Of a slot: its head but for the sum, the layout, its values.
std::uint64_t checksum(const std::byte* slot, std::size_t value_bytes, std::uint64_t layout_hash) {
  return XXH3_64bits_withSeed(slot + kSlotHeaderBytes, value_bytes,
                              XXH3_64bits_withSeed(slot, kChecksumAt, layout_hash));
}

core::Problem unusable(std::string message, std::string help = {}) {
  return {core::Code::P7611, std::move(message), std::move(help)};
}

std::string error_text() { return std::system_category().message(errno); }

}  // namespace

core::Result<Stored> parse_file(std::span<const std::byte> bytes) {
  if (bytes.size() < kHeaderBytes || std::memcmp(bytes.data(), kMagic.data(), kMagic.size()) != 0) {
    return unusable("not a file of retained values, or cut short");
  }
  if (const auto version = load_le<std::uint32_t>(bytes.data() + kVersionAt); version != kVersion) {
    return unusable(
        "format version " + std::to_string(version) + ", this program reads version " + std::to_string(kVersion),
        "read it with the version of PICARD that wrote it");
  }
  const std::uint64_t layout_bytes = load_le<std::uint32_t>(bytes.data() + kLayoutBytesAt);
  const auto value_bytes = load_le<std::uint64_t>(bytes.data() + kValueBytesAt);
  const auto layout_hash = load_le<std::uint64_t>(bytes.data() + kLayoutHashAt);
  if (layout_bytes > bytes.size() - kHeaderBytes || value_bytes > bytes.size() ||
      XXH3_64bits(bytes.data() + kHeaderBytes, layout_bytes) != layout_hash) {
    return unusable("the list of its variables is damaged");
  }
  auto layout = decode(bytes.subspan(kHeaderBytes, layout_bytes));
  if (!layout || layout->bytes != value_bytes) return unusable("the list of its variables is not sound");
  Stored stored;
  const std::uint64_t first = rounded(kHeaderBytes + layout_bytes),
                      slot_bytes = rounded(kSlotHeaderBytes + value_bytes);
  const std::byte* newest = nullptr;
  for (const std::uint64_t at : {first, first + slot_bytes}) {
    if (at > bytes.size() || kSlotHeaderBytes + value_bytes > bytes.size() - at) continue;
    const std::byte* const slot = bytes.data() + at;
    const auto sequence = load_le<std::uint64_t>(slot);
    if (sequence <= stored.sequence) continue;
    if (load_le<std::uint64_t>(slot + kChecksumAt) != checksum(slot, value_bytes, layout_hash)) continue;
    stored.sequence = sequence;
    newest = slot;
  }
  if (newest == nullptr) return unusable("neither of its two sets of values is whole");
  stored.layout = std::move(*layout);
  stored.program_time_ns = load_le<std::int64_t>(newest + kTimeAt);
  stored.time_of_day_ns = load_le<std::int64_t>(newest + kTimeOfDayAt);
  stored.values.assign(newest + kSlotHeaderBytes, newest + kSlotHeaderBytes + value_bytes);
  return stored;
}

core::Result<Stored> read_file(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) {
    return core::Problem{core::Code::P7001, "cannot open " + path, error ? error.message() : "it is no file"};
  }
  const std::uint64_t size = std::filesystem::file_size(path, error);
  if (!error && size > kMostFileBytes) return unusable(path + ": too large for a file of retained values");
  std::ifstream in(path, std::ios::binary);
  std::vector<std::byte> bytes(error ? 0 : size);
  in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (!in) return core::Problem{core::Code::P7001, "cannot read " + path, {}};
  auto stored = parse_file(bytes);
  if (!stored) return unusable(path + ": " + stored.error().message, stored.error().help);
  return stored;
}

Store::Store(std::string folder, const Layout& layout) : folder_(std::move(folder)) {
  const std::vector<std::byte> encoded = encode(layout);
  value_bytes_ = static_cast<std::size_t>(layout.bytes);
  layout_hash_ = XXH3_64bits(encoded.data(), encoded.size());
  slot_bytes_ = rounded(kSlotHeaderBytes + value_bytes_);
  header_.resize(rounded(kHeaderBytes + encoded.size()));
  std::memcpy(header_.data(), kMagic.data(), kMagic.size());
  store_le(header_.data() + kVersionAt, kVersion);
  store_le(header_.data() + kLayoutBytesAt, static_cast<std::uint32_t>(encoded.size()));
  store_le(header_.data() + kValueBytesAt, static_cast<std::uint64_t>(value_bytes_));
  store_le(header_.data() + kLayoutHashAt, layout_hash_);
  std::memcpy(header_.data() + kHeaderBytes, encoded.data(), encoded.size());
  image_.resize(slot_bytes_);
}

Store::~Store() { close(); }

std::string Store::path() const { return (std::filesystem::path(folder_) / kFileName).string(); }

void Store::close() {
  if (file_ >= 0) ::close(file_);
  if (directory_ >= 0) ::close(directory_);
  file_ = directory_ = -1;
}

bool Store::write_at(std::uint64_t at, std::span<const std::byte> bytes) const {
  while (!bytes.empty()) {
    const ssize_t written = ::pwrite(file_, bytes.data(), bytes.size(), static_cast<off_t>(at));
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    at += static_cast<std::uint64_t>(written);
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
  return true;
}

void Store::fill(std::span<const std::byte> values, core::TimeNs program_time_ns, std::int64_t time_of_day_ns) {
  std::byte* const slot = image_.data();
  store_le(slot, sequence_ + 1);
  store_le(slot + kTimeAt, program_time_ns);
  store_le(slot + kTimeOfDayAt, time_of_day_ns);
  std::memcpy(slot + kSlotHeaderBytes, values.data(), value_bytes_);
  store_le(slot + kChecksumAt, checksum(slot, value_bytes_, layout_hash_));
}

/// Goes on with a file of the same layout: true when it is one.
bool Store::open_existing() {
  file_ = ::openat(directory_, kFileName, O_RDWR | O_CLOEXEC);
  if (file_ < 0) return false;
  const auto stored = read_file(path());
  std::vector<std::byte> header(header_.size());
  const bool same = stored && ::pread(file_, header.data(), header.size(), 0) == static_cast<ssize_t>(header.size()) &&
                    header == header_;
  if (!same) {
    ::close(file_);
    file_ = -1;
    return false;
  }
  for (std::uint32_t slot = 0; slot < 2; ++slot) {
    std::vector<std::byte>& has = on_disk_[slot];
    has.resize(slot_bytes_);
    const auto at = static_cast<off_t>(header_.size() + slot * slot_bytes_);
    if (::pread(file_, has.data(), has.size(), at) != static_cast<ssize_t>(has.size())) has.clear();
    if (!has.empty() && load_le<std::uint64_t>(has.data()) == stored->sequence) next_ = 1 - slot;
  }
  sequence_ = std::max(sequence_, stored->sequence);
  return true;
}

std::string Store::open_folder() {
  if (directory_ >= 0) return {};
  std::error_code error;
  std::filesystem::create_directories(folder_, error);
  directory_ = ::open(folder_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (directory_ < 0) return "cannot open folder " + folder_ + ": " + error_text();
  // WHY the folder: the file is replaced by another one.
  if (::flock(directory_, LOCK_EX | LOCK_NB) == 0) return {};
  std::string problem = errno == EWOULDBLOCK ? "folder " + folder_ + " is in use by another plc-run"
                                             : "cannot lock folder " + folder_ + ": " + error_text();
  close();
  return problem;
}

/// With the values in image_, which are complete on the disk before the file has its name.
std::string Store::make_file() {
  const auto failed = [this] {
    std::string problem = "cannot write " + (std::filesystem::path(folder_) / kNewName).string() + ": " + error_text();
    close();
    return problem;
  };
  file_ = ::openat(directory_, kNewName, O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (file_ < 0) return failed();
  on_disk_[0] = image_;
  on_disk_[1].assign(slot_bytes_, std::byte{0});
  const bool written = write_at(0, header_) && write_at(header_.size(), on_disk_[0]) &&
                       write_at(header_.size() + slot_bytes_, on_disk_[1]);
  if (!written || ::fsync(file_) != 0) return failed();
  // What an earlier program has kept may be wanted again. Without it all goes on.
  ::unlinkat(directory_, kPreviousName, 0);
  [[maybe_unused]] const int linked = ::linkat(directory_, kFileName, directory_, kPreviousName, 0);
  if (::renameat(directory_, kNewName, directory_, kFileName) != 0 || ::fsync(directory_) != 0) return failed();
  next_ = 1;
  ++sequence_;
  return {};
}

std::string Store::write(std::span<const std::byte> values, core::TimeNs program_time_ns, std::int64_t time_of_day_ns) {
  struct stat file {};
  // Somebody has removed it, or its folder.
  if (file_ >= 0 && (::fstat(file_, &file) != 0 || file.st_nlink == 0)) close();
  const bool opened = file_ >= 0;
  if (!opened) {
    if (std::string problem = open_folder(); !problem.empty()) return problem;
  }
  const bool goes_on = opened || open_existing();
  fill(values, program_time_ns, time_of_day_ns);
  if (!goes_on) return make_file();
  std::vector<std::byte>& has = on_disk_[next_];
  const std::uint64_t slot_at = header_.size() + next_ * slot_bytes_;
  bool written = true;
  // Only the blocks that differ: the other slot is whole meanwhile, and flash memory wears less.
  for (std::size_t at = 0; at < slot_bytes_ && written;) {
    const auto differs = [&](std::size_t block) {
      return has.empty() || std::memcmp(has.data() + block, image_.data() + block, kBlock) != 0;
    };
    std::size_t end = at;
    while (end < slot_bytes_ && differs(end)) end += kBlock;
    if (end != at) written = write_at(slot_at + at, std::span(image_).subspan(at, end - at));
    at = end + kBlock;
  }
  if (!written || ::fdatasync(file_) != 0) {
    std::string problem = "cannot write " + path() + ": " + error_text();
    has.clear();
    return problem;
  }
  has = image_;
  next_ = 1 - next_;
  ++sequence_;
  return {};
}

}  // namespace plc::retain
