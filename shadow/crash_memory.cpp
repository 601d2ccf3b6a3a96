#include "shadow/crash_memory.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>
#include <xxhash.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <climits>
#include <cstring>
#include <filesystem>
#include <new>
#include <optional>
#include <system_error>
#include <utility>

#include "runtime/record/ring.h"
#include "shadow/record_file.h"

namespace plc::shadow {
namespace {

namespace fs = std::filesystem;
using runtime::RecordHead;
using runtime::RecordKind;
using runtime::RingEnd;

constexpr const char* kHead = "recording";
constexpr const char* kState = "state";  ///< whose memory it is
constexpr const char* kPrefix = "picard-";
constexpr std::size_t kKept = 3;  ///< tables: of the newest block, of the one before, and of the next

/// Where a block begins.
struct Start {
  std::uint64_t scan = 0;
  std::uint64_t position = 0;  ///< in the ring
};
/// The beginning of a file of tables. The tables follow, kKept of them.
struct TablesHead {
  std::uint64_t table_bytes = 0;
  std::atomic<std::uint64_t> starts{0};  ///< that have been made; number n is in place n % kKept
  Start start[kKept];
};
constexpr std::size_t kTablesHead = 128;
static_assert(sizeof(TablesHead) <= kTablesHead);

std::size_t place_of(std::size_t table_bytes, std::uint64_t number) {
  return kTablesHead + number % kKept * runtime::padded(table_bytes);
}
std::size_t tables_bytes(std::size_t table_bytes) {
  return place_of(table_bytes, 0) + kKept * runtime::padded(table_bytes);
}

std::string ring_name(std::size_t task) { return "task-" + std::to_string(task) + ".ring"; }
std::string tables_name(std::size_t task) { return "task-" + std::to_string(task) + ".tables"; }
std::string left_name(const std::string& folder) { return folder + ".left"; }

core::Problem refused(const std::string& folder, const std::string& why) {
  return {core::Code::P7631, folder + ": " + why, "what led to a crash of plc-run will not be recorded"};
}
core::Problem refused(const std::string& folder, int error) {
  return refused(folder, std::system_category().message(error));
}

/// A new file of `bytes` that are there: writing to its memory cannot fail later. -1, and errno.
int new_file(int directory, const std::string& name, std::size_t bytes) {
  const int file = ::openat(directory, name.c_str(), O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0600);
  if (file < 0) return -1;
  errno = bytes == 0 ? 0 : ::posix_fallocate(file, 0, static_cast<off_t>(bytes));
  if (errno == 0) return file;
  const int error = errno;
  ::close(file);
  errno = error;
  return -1;
}

bool write_file(int directory, const std::string& name, const void* data, std::size_t bytes) {
  const int file = new_file(directory, name, bytes);
  if (file < 0) return false;
  const bool written = ::pwrite(file, data, bytes, 0) == static_cast<ssize_t>(bytes);
  ::close(file);
  return written;
}

/// A descriptor that is closed at the end.
class Descriptor {
 public:
  explicit Descriptor(int value) : value_(value) {}
  ~Descriptor() {
    if (value_ >= 0) ::close(value_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  operator int() const { return value_; }

 private:
  int value_;
};

int open_directory(const std::string& path) {
  return ::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
}

/// Whether a directory is the calling user's, and nobody else may look into it.
/// WHY: everybody may make files in /dev/shm, of any kind and size: what is in the directories of others is not read.
bool is_own(int directory) {
  struct stat status {};
  return ::fstat(directory, &status) == 0 && status.st_uid == ::geteuid() && (status.st_mode & 077) == 0;
}

/// All bytes of a regular file; nothing when it is none, cannot be read, or has more than `most`.
std::optional<std::vector<std::byte>> read_all(int directory, const std::string& name, std::size_t most = SIZE_MAX) {
  // WHY O_NONBLOCK: opening a pipe would wait for who writes into it.
  const Descriptor file(::openat(directory, name.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
  struct stat status {};
  if (file < 0 || ::fstat(file, &status) != 0 || !S_ISREG(status.st_mode)) return std::nullopt;
  const auto size = static_cast<std::size_t>(status.st_size);
  if (size > most) return std::nullopt;
  std::vector<std::byte> bytes(size);
  std::size_t done = 0;
  while (done < size) {
    const ssize_t count = ::pread(file, bytes.data() + done, size - done, static_cast<off_t>(done));
    if (count <= 0) break;
    done += static_cast<std::size_t>(count);
  }
  bytes.resize(done);
  return bytes;
}

/// A ring that somebody wrote who is gone.
class LeftRing {
 public:
  /// False when it is none.
  bool read(int directory, const std::string& name) {
    auto bytes = read_all(directory, name);
    const auto page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
    if (!bytes || bytes->size() < page) return false;
    bytes_ = std::move(*bytes);
    capacity_ = bytes_.size() - page;
    const auto number = [this](std::size_t at) {
      std::uint64_t value = 0;
      std::memcpy(&value, bytes_.data() + capacity_ + at, sizeof value);
      return value;
    };
    head_ = number(offsetof(RingEnd, head));
    tail_ = number(offsetof(RingEnd, tail));
    most_record_bytes_ = number(offsetof(RingEnd, most_record_bytes));
    return number(offsetof(RingEnd, capacity)) == capacity_ && capacity_ > 0 && most_record_bytes_ <= capacity_ / 2;
  }
  /// Whether nothing at or after `position` has been written over, also not by a record that was being written.
  [[nodiscard]] bool holds(std::uint64_t position) const {
    if (position > head_ || head_ - position > capacity_) return false;
    return position >= tail_ || head_ - position + most_record_bytes_ <= capacity_;
  }
  /// The record there, in one piece; empty at the end, and where there is none.
  std::span<const std::byte> at(std::uint64_t position) {
    RecordHead head;
    if (position > head_ || head_ - position < sizeof head) return {};
    copy(position, sizeof head);
    std::memcpy(&head, record_.data(), sizeof head);
    if (head.bytes < sizeof head || head.bytes > std::min(head_ - position, most_record_bytes_) ||
        head.bytes % runtime::kRecordAlign != 0) {
      return {};
    }
    copy(position, head.bytes);
    return record_;
  }

 private:
  void copy(std::uint64_t position, std::size_t bytes) {
    record_.resize(bytes);
    const std::size_t from = position % capacity_;
    const std::size_t first = std::min(bytes, capacity_ - from);
    std::memcpy(record_.data(), bytes_.data() + from, first);
    std::memcpy(record_.data() + first, bytes_.data(), bytes - first);
  }

  std::vector<std::byte> bytes_, record_;
  std::size_t capacity_ = 0;
  std::uint64_t head_ = 0, tail_ = 0, most_record_bytes_ = 0;
};

/// Removes what plants other than that of `folder` have left that nobody starts again.
void sweep(const fs::path& folder) {
  std::error_code error;
  for (fs::directory_iterator at(folder.parent_path(), error), end; !error && at != end; at.increment(error)) {
    const std::string name = at->path().filename().string();
    if (!name.starts_with(kPrefix) || name.starts_with(folder.filename().string())) continue;
    const Descriptor directory(open_directory(at->path().string()));
    if (directory < 0 || !is_own(directory)) continue;
    const auto state = read_all(directory, kState, PATH_MAX);
    std::error_code ignored;
    if (!state || fs::exists(std::string(reinterpret_cast<const char*>(state->data()), state->size()), ignored) ||
        ignored) {
      continue;
    }
    if (::flock(directory, LOCK_EX | LOCK_NB) == 0) fs::remove_all(at->path(), ignored);
  }
}

struct LeftBlock {
  core::TimeNs first_ns = 0;
  std::vector<std::byte> bytes;
};

/// The blocks of a task.
void read_blocks(int directory, std::size_t task, std::vector<LeftBlock>& blocks) {
  LeftRing ring;
  const auto tables = read_all(directory, tables_name(task));
  if (!tables || tables->size() < kTablesHead || !ring.read(directory, ring_name(task))) return;
  const auto* const head = reinterpret_cast<const TablesHead*>(tables->data());
  if (head->table_bytes > tables->size() || tables->size() != tables_bytes(head->table_bytes)) return;
  const std::uint64_t starts = head->starts.load(std::memory_order_relaxed);
  for (std::uint64_t number = starts < 2 ? 0 : starts - 2; number < starts; ++number) {
    const Start& start = head->start[number % kKept];
    if (!ring.holds(start.position)) continue;
    BlockBuilder block;
    block.begin(static_cast<std::uint32_t>(task), start.scan,
                std::span(*tables).subspan(place_of(head->table_bytes, number), head->table_bytes));
    for (std::uint64_t position = start.position;;) {
      const std::span<const std::byte> record = ring.at(position);
      RecordHead one;
      if (record.size() < sizeof one) break;
      std::memcpy(&one, record.data(), sizeof one);
      // At a checkpoint the next block begins.
      if (one.kind != RecordKind::kScan || !block.add(record) || (one.flags & runtime::kCut) != 0) break;
      position += one.bytes;
    }
    if (!block.empty()) blocks.push_back({block.info().first_ns, block.pack()});
  }
}

}  // namespace

std::string CrashMemory::folder_of(const std::string& state) {
  std::error_code error;
  // WHY absolute: of a relative path that is not there weakly_canonical() makes no whole one.
  const fs::path from_root = fs::absolute(state, error);
  const fs::path whole = error ? fs::path(state) : fs::weakly_canonical(from_root, error);
  std::string path = error ? from_root.string() : whole.string();
  while (path.size() > 1 && path.ends_with('/')) path.pop_back();
  return fmt::format("/dev/shm/{}{}-{:016x}", kPrefix, ::geteuid(), XXH3_64bits(path.data(), path.size()));
}

core::Result<std::unique_ptr<CrashMemory>> CrashMemory::make(const std::string& folder,
                                                             std::span<const std::byte> file_head, const Sizes& sizes) {
  std::error_code error;
  if (const int before = open_directory(folder); before >= 0) {
    const bool own = is_own(before);
    const bool free = own && ::flock(before, LOCK_EX | LOCK_NB) == 0;
    ::close(before);
    if (!own) return refused(folder, "belongs to somebody else");
    if (!free) return refused(folder, "another process uses it");
    fs::remove_all(left_name(folder), error);
    fs::rename(folder, left_name(folder), error);
  }
  std::unique_ptr<CrashMemory> made(new CrashMemory(folder));
  if (::mkdir(folder.c_str(), 0700) != 0) return refused(folder, errno);
  made->directory_ = open_directory(folder);
  if (made->directory_ < 0 || ::flock(made->directory_, LOCK_EX | LOCK_NB) != 0) return refused(folder, errno);
  sweep(folder);
  if (!write_file(made->directory_, kState, sizes.state.data(), sizes.state.size())) return refused(folder, errno);
  for (std::size_t t = 0; t < sizes.table_bytes.size(); ++t) {
    Task& task = made->tasks_.emplace_back();
    task.table_bytes = sizes.table_bytes[t];
    task.ring_file = new_file(made->directory_, ring_name(t),
                              runtime::RecordRing::file_bytes(sizes.ring_bytes, sizes.most_record_bytes));
    if (task.ring_file < 0) return refused(folder, errno);
    const std::size_t bytes = tables_bytes(task.table_bytes);
    const int file = new_file(made->directory_, tables_name(t), bytes);
    if (file < 0) return refused(folder, errno);
    void* const memory = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_POPULATE, file, 0);
    const int why = errno;
    ::close(file);
    if (memory == MAP_FAILED) return refused(folder, why);
    task.tables = static_cast<std::byte*>(memory);
    (new (memory) TablesHead)->table_bytes = task.table_bytes;
  }
  // Last: without it nothing was left.
  if (!write_file(made->directory_, kHead, file_head.data(), file_head.size())) return refused(folder, errno);
  return made;
}

CrashMemory::~CrashMemory() {
  for (const Task& task : tasks_) {
    if (task.ring_file >= 0) ::close(task.ring_file);
    if (task.tables != nullptr) ::munmap(task.tables, tables_bytes(task.table_bytes));
  }
  if (directory_ < 0) return;
  std::error_code error;
  fs::remove_all(folder_, error);
  ::close(directory_);
}

void CrashMemory::begin_block(std::size_t t, std::uint64_t first_scan, std::uint64_t position,
                              std::span<const std::byte> table) noexcept {
  const Task& task = tasks_[t];
  auto* const head = reinterpret_cast<TablesHead*>(task.tables);
  const std::uint64_t number = head->starts.load(std::memory_order_relaxed);
  std::memcpy(task.tables + place_of(task.table_bytes, number), table.data(), std::min(table.size(), task.table_bytes));
  head->start[number % kKept] = {first_scan, position};
  // After what it counts: the process may die at any instruction.
  head->starts.store(number + 1, std::memory_order_release);
}

std::vector<std::byte> CrashMemory::take_left(const std::string& folder) {
  const std::string left = left_name(folder);
  std::vector<std::byte> recording;
  const Descriptor directory(open_directory(left));
  if (directory < 0 || !is_own(directory)) return recording;
  if (auto head = read_all(directory, kHead)) {
    std::vector<LeftBlock> blocks;
    for (std::size_t task = 0; ::faccessat(directory, ring_name(task).c_str(), F_OK, AT_SYMLINK_NOFOLLOW) == 0; ++task)
      read_blocks(directory, task, blocks);
    std::stable_sort(blocks.begin(), blocks.end(),
                     [](const LeftBlock& a, const LeftBlock& b) { return a.first_ns < b.first_ns; });
    if (!blocks.empty()) recording = std::move(*head);
    for (const LeftBlock& block : blocks) recording.insert(recording.end(), block.bytes.begin(), block.bytes.end());
  }
  std::error_code error;
  fs::remove_all(left, error);
  return recording;
}

}  // namespace plc::shadow
