// Coded problems: collecting, counting, rendering. The collector knows wording and places; it never decides control
// flow.
//
// A message describes what was found ("input "IN2" of LIMIT has type REAL, other inputs are DINT"), lower case, no full
// stop; the help line says how to mend it. Not thread-safe; never used in a cycle.
#pragma once

#include <cstddef>
#include <cstdint>
#include <iosfwd>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/excerpt.h"
#include "core/source_ref.h"
#include "core/text_jumps.h"

namespace plc::core {

enum class Severity : std::uint8_t {
  kNote,  ///< an idiom that the standard does not know and other tools take, with one meaning everywhere
  kWarning,
  kError,
};

/// What becomes of notes.
enum class Notes : std::uint8_t {
  kShow,
  kHide,    ///< neither kept nor counted
  kRefuse,  ///< they are errors
};

enum class Code : std::uint16_t {
#define PLC_DIAGNOSTIC(code, severity, title) code,
#include "core/diagnostics.def"
};

struct CodeInfo {
  std::string_view name;  ///< "P3007"
  Severity severity;
  std::string_view title;  ///< heading of the code's page
};
const CodeInfo& info(Code code);
/// All codes in the order of diagnostics.def.
const std::vector<CodeInfo>& all_codes();

struct Diagnostic {
  Code code;
  Severity severity;
  SourceRef at;
  std::string pou;      ///< POU the place belongs to, or empty
  std::string message;  ///< what was found
  std::string help;     ///< how to mend it, or empty
};

class Diagnostics {
 public:
  /// Names an input file; the returned index goes into SourceRef::file.
  std::uint16_t add_file(std::string name);
  [[nodiscard]] std::size_t file_count() const { return files_.size(); }
  [[nodiscard]] const std::string& file_name(std::uint16_t file) const { return files_[file]; }

  /// Where texts of the file do not go on from character to character, for all who find places in them.
  void set_text_jumps(std::uint16_t file, TextJumps jumps);
  /// Null for a file that is not known here.
  [[nodiscard]] const TextJumps* text_jumps(std::uint16_t file) const {
    return file < jumps_.size() ? &jumps_[file] : nullptr;
  }

  /// What becomes of notes that are reported from now on; at first they are shown.
  void set_notes(Notes notes) { notes_ = notes; }
  /// Files named from now on, up to end_libraries(), are libraries. What is reported of places in them is set aside,
  /// and `unwanted` codes, unless they are errors, are neither kept nor counted, nor refused.
  void begin_libraries(std::vector<Code> unwanted);
  void end_libraries() { last_library_ = files_.size(); }
  [[nodiscard]] bool is_library(std::uint16_t file) const { return file >= first_library_ && file < last_library_; }
  /// The first error set aside from `begin` to `end`, places of one file; null when there is none.
  [[nodiscard]] const Diagnostic* error_aside(const SourceRef& begin, const SourceRef& end);
  /// Reports what was set aside from `begin` to `end`.
  void release(const SourceRef& begin, const SourceRef& end);
  /// What is reported of libraries from now on is reported at once.
  void end_setting_aside() { sets_aside_ = false; }

  /// Warnings and notes of this code are neither kept nor counted from now on; errors cannot be muted.
  void mute(Code code);
  void report(Code code, const SourceRef& at, std::string_view pou, std::string message, std::string help = {});

  /// The same, and not set aside: about what the project does with the library that `at` lies in.
  void report_at_once(Code code, const SourceRef& at, std::string_view pou, std::string message, std::string help = {});

  /// Takes out again what was reported from the `first` diagnostic on and was there before, with the same code, place
  /// and words: text that is read more than once has the same mistakes.
  void drop_repeated(std::size_t first);

  [[nodiscard]] bool has_errors() const { return errors_ != 0; }
  [[nodiscard]] std::size_t error_count() const { return errors_; }
  [[nodiscard]] std::size_t warning_count() const { return warnings_; }
  [[nodiscard]] std::size_t note_count() const { return notes_counted_; }
  [[nodiscard]] const std::vector<Diagnostic>& all() const { return all_; }
  /// Errors beyond this many are counted, not kept, and so are warnings and notes of one code: a broken file of 10^6
  /// elements stays readable.
  static constexpr std::size_t kMaxKept = 1000;
  /// Warnings and notes of one code that are rendered; of the others a line says how many there are.
  static constexpr std::size_t kMaxShown = 20;
  /// From now on all warnings and notes are kept and rendered.
  void show_all() { show_all_ = true; }

  /// `motor.xml:212:9: error P3007: message [POU Fill, block 14]` and a help line; in file order as reported.
  void render(std::ostream& out) const;
  /// The same with the line of the file and a caret between message and help, where the file is as it was when it was
  /// named.
  void render_with_lines(std::ostream& out) const;
  [[nodiscard]] std::string render_one(const Diagnostic& diagnostic) const;

 private:
  [[nodiscard]] std::string message_line(const Diagnostic& diagnostic) const;
  /// Calls `one` for each diagnostic that is to be shown, then says what is not.
  template <class One>
  void render_each(std::ostream& out, One one) const;

  std::vector<std::string> files_;
  std::vector<FileStamp> stamps_;  ///< of the files, when they were named
  std::vector<TextJumps> jumps_;   ///< of the files
  std::vector<Diagnostic> all_;
  std::vector<Code> muted_;
  std::vector<std::size_t> counts_;  ///< warnings and notes by code, also those that are not kept
  bool show_all_ = false;
  [[nodiscard]] std::size_t& count_of(Severity severity);

  using Aside = std::vector<Diagnostic>;
  [[nodiscard]] std::pair<Aside::iterator, Aside::iterator> aside(const SourceRef& begin, const SourceRef& end);
  void keep(Diagnostic diagnostic);

  std::size_t first_library_ = SIZE_MAX;  ///< index of the first file that is a library's
  std::size_t last_library_ = SIZE_MAX;   ///< index past the last one
  std::vector<Code> unwanted_;            ///< in libraries
  bool sets_aside_ = true;
  Aside aside_;                   ///< what was reported of libraries and not asked for yet
  std::size_t sorted_aside_ = 0;  ///< so many of them, from the first on, are in the order of their places
  Notes notes_ = Notes::kShow;
  std::size_t errors_ = 0;
  std::size_t warnings_ = 0;
  std::size_t notes_counted_ = 0;
};

}  // namespace plc::core
