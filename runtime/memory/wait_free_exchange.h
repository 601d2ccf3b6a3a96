// WaitFreeExchange: every owner publishes a snapshot of all it exports; readers take the newest of each
// (docs/adr/0012).
//
// What a task alone exports lives in its local copy; importing brings only what others own. Wait-free, bounded by the
// sizes of the ranges and the journal. The protocols with a common table build on it: devices, servers and tools see
// snapshots under every protocol.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "runtime/memory/exchange.h"
#include "runtime/memory/table.h"

namespace plc::runtime {

class alignas(kTableAlign) WaitFreeExchange : public Exchange {
 public:
  WaitFreeExchange(GlobalTable& globals, std::uint32_t task, std::byte* local);
  ~WaitFreeExchange() override;
  WaitFreeExchange(const WaitFreeExchange&) = delete;
  WaitFreeExchange& operator=(const WaitFreeExchange&) = delete;

  std::uint32_t add_range(std::uint32_t first, std::uint32_t count, Use use) override;
  void prepare() override;
  void reset() override;
  void set_recorder(Recorder* recorder) override { recorder_ = recorder; }
  void expect(std::size_t bytes) noexcept override;
  void begin() noexcept override;
  void import(std::uint32_t range) noexcept override;
  void export_range(std::uint32_t range) noexcept override;
  bool end() noexcept override;
  [[nodiscard]] bool read_bool(std::uint32_t offset) noexcept override;
  bool revoke() noexcept override;
  void publish_safe(std::span<const GlobalWrite> values) noexcept override;

 protected:
  /// Bytes of the table that one owner publishes side by side.
  struct Stretch {
    std::uint32_t owner = 0;
    std::uint32_t begin = 0;
    std::uint32_t end = 0;
    std::size_t at = 0;  ///< where they start in its snapshot
  };
  struct Range {
    std::uint32_t first = 0;
    std::uint32_t count = 0;
    Use use = Use::kImport;
  };
  /// What a range copies: stretches that others own (to import) or this task (to export), and leaves, shared and
  /// overlapping.
  struct Slice {
    std::uint32_t first_stretch = 0;
    std::uint32_t last_stretch = 0;
    std::uint32_t first_leaves = 0;
    std::uint32_t last_leaves = 0;
    std::size_t bytes = 0;  ///< that an import reads; 0 for other uses
  };
  [[nodiscard]] std::span<const Stretch> stretches(std::uint32_t range) const noexcept {
    const Slice& s = slices_[range];
    return stretches_.subspan(s.first_stretch, s.last_stretch - s.first_stretch);
  }
  /// Numbers of GlobalTable::leaves_.
  [[nodiscard]] std::span<const std::uint32_t> leaves(std::uint32_t range) const noexcept {
    const Slice& s = slices_[range];
    return leaves_.subspan(s.first_leaves, s.last_leaves - s.first_leaves);
  }
  /// All that begin() does but the turn: between cycles it may be done again and again. RT.
  void take() noexcept;
  /// Whether this cycle may publish; once it was told so, it can no longer be revoked. RT.
  bool may_publish() noexcept;
  void import_leaves(std::uint32_t index) noexcept;
  /// Copies what others wrote into the local copy, at `at`. RT.
  void take_in(std::uint32_t at, const std::byte* from, std::uint32_t bytes) noexcept;
  /// An import of the cycle begins. RT.
  void next_import() noexcept;
  [[nodiscard]] bool from_task(const Stretch& stretch) const noexcept { return stretch.owner < globals_.task_count_; }
  [[nodiscard]] const std::byte* held(const Stretch& stretch) const noexcept {
    return held_[stretch.owner] + stretch.at;
  }
  [[nodiscard]] std::byte* local() const noexcept { return local_; }
  [[nodiscard]] std::byte* common() const noexcept { return globals_.common_.data(); }
  [[nodiscard]] GlobalTable& globals() const noexcept { return globals_; }
  [[nodiscard]] std::atomic<std::uint64_t>& copies() const noexcept { return globals_.common_copies_; }
  [[nodiscard]] pthread_mutex_t& mutex() const noexcept { return globals_.common_mutex_; }
  [[nodiscard]] const GlobalTable::Field& field(std::uint32_t f) const noexcept { return globals_.fields_[f]; }
  [[nodiscard]] std::uint32_t task() const noexcept { return task_; }
  [[nodiscard]] const std::vector<Range>& ranges() const noexcept { return ranges_; }

 private:
  /// Whose turn it is to publish: between cycles and while exporting, nobody can take it from the task.
  enum class Turn : std::uint8_t { kExchanging, kComputing, kRevoked };

  void bring(std::uint32_t range) noexcept;
  void export_leaves(const GlobalTable::Leaves& leaves) noexcept;
  void open_snapshot() noexcept;
  void apply(const Journal::Entry& entry, const std::byte* value, const std::byte* mask) noexcept;

  struct Source {
    std::uint32_t owner = 0;
    Snapshot::Reader reader;
  };
  // What every cycle looks at, side by side; what these point to is side by side in the table's arena.
  GlobalTable& globals_;
  std::byte* local_;
  std::span<const std::byte> used_;  ///< of the arena: all of the spans here; empty where they lie apart or are long
  Snapshot* own_ = nullptr;          ///< what it publishes
  Journal* journal_ = nullptr;
  std::span<Source> sources_;  ///< owners it reads, and those of the variable that releases it
  std::span<const std::byte*> held_;
  std::span<const Slice> slices_;  ///< by range
  std::span<const Stretch> stretches_;
  std::span<const std::uint32_t> leaves_;
  Recorder* recorder_ = nullptr;
  std::atomic<Turn> turn_{Turn::kExchanging};
  bool in_parts_ = false;         ///< several ranges make up what it publishes
  bool publishing_ = false;       ///< this cycle can no longer be revoked
  std::byte* writing_ = nullptr;  ///< the snapshot of this cycle, once something was exported
  std::uint64_t stamp_ = 0;       ///< of this cycle; 0 = none drawn yet
  std::size_t owned_bytes_ = 0;   ///< of its snapshot: what it alone exports, from the start
  std::size_t shared_bytes_ = 0;  ///< and its copies of shared leaves, after that
  const std::byte* shared_image_ = nullptr;
  std::uint32_t task_;

  std::vector<Range> ranges_;
  static constexpr std::ptrdiff_t kMostUsed = 1024;  ///< fetched ahead: bytes
  static constexpr std::uint64_t kNotImported = ~std::uint64_t{0};
  std::vector<std::uint64_t> imported_;  ///< per GlobalTable::leaves_: its version at the last import
  TableMemory shadow_;                   ///< shared and overlapping leaves as imported; size 0 without any
};

}  // namespace plc::runtime
