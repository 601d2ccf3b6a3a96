// What plc-run says while it runs, on streams whose reader may stall, go away, or be a full disk.
//
// In: text for std::cout and std::cerr. Out: as much of it as the streams take; a plant never waits for them. Text that
// is not taken waits in memory, up to kMostWaiting bytes; what is more is lost, and that is said. Threads: the main
// one's alone. Does not belong here: what is said.
#pragma once

#include <cstdint>
#include <functional>
#include <ostream>
#include <streambuf>
#include <string>
#include <string_view>

namespace plc::tools {

/// Writes to a descriptor: with waiting before and after the plant runs, without in between. Never fails, so that no
/// stream above it turns silent for good (badbit).
class PatientBuffer final : public std::streambuf {
 public:
  static constexpr std::size_t kMostWaiting = 262'144;

  explicit PatientBuffer(int descriptor);
  /// From here on nothing waits for the reader.
  void stop_waiting() { waits_ = false; }
  /// From here on flushing waits until all is written, the descriptor refuses it, or `give_up` says so.
  void wait_again(std::function<bool()> give_up);
  /// Whether text was lost that the descriptor refused: on a disk that is full.
  [[nodiscard]] bool refused() const { return refused_; }
  /// How many texts have come, but for those of print_or_drop().
  [[nodiscard]] std::uint64_t texts() const { return texts_; }
  [[nodiscard]] bool is_terminal() const { return terminal_; }
  /// Prints when nothing waits, and as much as is taken at once; the rest is lost. For what the next text replaces.
  void print_or_drop(std::string_view text);

 protected:
  int sync() override;
  int_type overflow(int_type character) override;
  std::streamsize xsputn(const char* text, std::streamsize count) override;

 private:
  enum class Written { kAll, kBlocked, kRefused, kNobody };
  Written write_some();
  void add(std::string_view text);

  int descriptor_;
  bool terminal_;
  std::uint64_t texts_ = 0;
  std::size_t piece_;  ///< bytes that a descriptor ready for writing takes without waiting
  bool waits_ = true;
  bool refused_ = false;
  std::function<bool()> give_up_;
  std::string waiting_;
  std::uint64_t lost_lines_ = 0;
};

/// std::cout and std::cerr of this process go through patient buffers from here to the end of the object. Descriptors 0
/// to 2 that are closed are opened on /dev/null first: no file of the plant gets their numbers.
class Output {
 public:
  Output();
  ~Output();
  Output(const Output&) = delete;
  Output& operator=(const Output&) = delete;

  PatientBuffer& out() { return out_; }
  PatientBuffer& err() { return err_; }
  /// Texts that have come to a terminal: when there are more, what was drawn there is not the last thing on it.
  [[nodiscard]] std::uint64_t texts_on_terminal() const {
    return (out_.is_terminal() ? out_.texts() : 0) + (err_.is_terminal() ? err_.texts() : 0);
  }
  void stop_waiting();
  /// `give_up` is asked about every 50 ms while something waits, to the end of this object.
  void wait_again(const std::function<bool()>& give_up);
  /// Of a program whose stdout is a document: kExitUsage, and said, when some of it was refused; else `code`.
  [[nodiscard]] int end_document(int code) const;
  /// What waits, as far as it can be written now.
  static void flush();

 private:
  PatientBuffer out_, err_;
  std::streambuf* out_before_;
  std::streambuf* err_before_;
};

}  // namespace plc::tools
