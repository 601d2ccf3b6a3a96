// ProgramStore: the programs of a plant that were uploaded, in files, and which of them a start takes.
//
// In: a folder; images that were found to be good. Out: at any moment, also after a loss of power, one program to
// start: the one that runs, or the one that is to be tried. A program on trial that was begun and never confirmed is
// not taken again. `chosen.json` says which; it is replaced in one step, after the files that it names are on the disk.
// Threads: any; blocks on the disk. Does not belong here: whether an image is good, starting it (tools/plc-run).
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

#include "core/clock.h"
#include "core/result.h"

namespace plc::engineering {

/// An image, by its hash.
struct StoredProgram {
  std::string image;        ///< SHA-256, 64 digits
  std::string project;      ///< name of the project stored with it, "plant.xml"; or empty
  std::string by;           ///< who uploaded it; empty: it is what FILE of plc-run was compiled to
  core::TimeNs utc_ns = 0;  ///< when
  bool operator==(const StoredProgram&) const = default;
};

/// A program that was tried and did not start.
struct FailedStart {
  StoredProgram program;
  std::string why;
  core::TimeNs utc_ns = 0;
};

class ProgramStore {
 public:
  /// What a start is to take.
  struct Choice {
    StoredProgram program;
    std::string file;   ///< the image
    std::string start;  ///< "warm", "cold" when it is tried for the first time; else empty: as the command line says
    bool trial = false;
  };

  /// The folder need not be there. P7753 when there is one that cannot be understood.
  static core::Result<std::unique_ptr<ProgramStore>> open(std::string folder);

  /// What is to start; nothing: FILE of plc-run. A trial begins by this call, on the disk: the next one takes what ran
  /// before. A trial that cannot be noted there, or whose image is damaged, does not begin, and what ran before is
  /// taken: failed() says why. P7753 when the image of that one is damaged.
  core::Result<std::optional<Choice>> choose(core::TimeNs utc_ns);
  /// The program on trial runs: from now on it is the one. Empty, or why that cannot be kept. Nothing happens when the
  /// trial of `image` has not begun, or another one is to be tried by now.
  std::string confirm(std::string_view image);
  /// The program on trial does not start: it is not taken again. Otherwise as confirm().
  std::string fail(std::string_view image, std::string why, core::TimeNs utc_ns);
  /// Whether choose() has left something that is not on the disk yet.
  [[nodiscard]] bool has_unkept() const;
  /// Puts it there. Empty, or why that cannot be done.
  std::string keep();
  /// Forgets what was uploaded: FILE is taken again.
  std::string forget();

  /// Keeps an image for a later try_next(). `check`: what is wrong with the image in a file, or empty; then nothing
  /// changes. P7750 with its words; P7753 when it cannot be written.
  core::Result<StoredProgram> put(std::string_view image, std::string by, core::TimeNs utc_ns,
                                  const std::function<std::string(const std::string& file)>& check);
  /// Keeps the project of the image that waits. `name`: of a file. P7755 when no image waits, P7753.
  core::Result<StoredProgram> put_project(std::string_view bytes, std::string name);
  /// The next start tries `image`, which waits, with this kind of start; `running` is what runs now, `given` the
  /// fingerprint of FILE. P7755 when none waits, or another one by now; P7753.
  std::optional<core::Problem> try_next(std::string_view image, std::string start, StoredProgram running,
                                        std::string_view running_image, std::string given);

  /// Nothing came of it: the program waits as before.
  void wait_again();

  [[nodiscard]] std::optional<StoredProgram> waiting() const;
  [[nodiscard]] std::optional<FailedStart> failed() const;
  /// FILE as it was when something else was chosen; empty when nothing was.
  [[nodiscard]] std::string given() const;
  /// FILE is known by this from now on. Empty, or why that cannot be kept.
  std::string note_given(std::string given);
  /// Of a stored image, and of its project.
  [[nodiscard]] std::string image_file(const StoredProgram& program) const;
  [[nodiscard]] std::string project_file(const StoredProgram& program) const;
  [[nodiscard]] const std::string& folder() const { return folder_; }

 private:
  struct Chosen {
    std::string given;
    std::optional<StoredProgram> runs, waits, trial;
    std::string start;   ///< of `trial`
    bool tried = false;  ///< `trial` was begun
    std::optional<FailedStart> failed;
  };
  explicit ProgramStore(std::string folder) : folder_(std::move(folder)) {}
  std::string read();
  /// On the disk, then in memory; empty, or why not.
  std::string replace(Chosen next);
  /// The trial is over. In memory also where the disk refuses: what ran before starts in any case.
  void give_up(std::string why, core::TimeNs utc_ns);
  [[nodiscard]] bool tries(std::string_view image) const;
  /// What is wrong with a stored image, or empty.
  [[nodiscard]] std::string damage_of(const StoredProgram& program) const;
  void sweep() const;

  std::string folder_;
  mutable std::mutex mutex_;
  Chosen chosen_;
  bool unkept_ = false;  ///< `chosen_` is newer than what is on the disk
};

/// What tells whether FILE has changed: "file:" and a hash of its content; of a folder, or a .plcproj, "sources:" and a
/// hash of the source files that the compiler would read there (sources/folder.h), and of nothing else: pages, tables
/// and logs may lie beside them. Empty when it cannot be read.
std::string fingerprint_of(const std::string& path);
/// Of a fingerprint that was kept and one of now.
enum class SameFile : std::uint8_t {
  kYes,
  kNo,
  kUnknown,  ///< the one that was kept is of a version that took it of other bytes
};
SameFile compare_fingerprints(std::string_view kept, std::string_view now);

}  // namespace plc::engineering
