// SimChip: a GPIO chip of the kernel module gpio-sim, as a test needs it. KernelTrace: who set a line to what.
//
// In: number of lines, names, hogs. Out: a chip that can be driven, looked at and unplugged through configfs and sysfs.
// Only in the guest that gpio-vm.sh boots. Failures end the test program: nothing would make sense after them.
#pragma once

#include <map>
#include <string>
#include <vector>

namespace plc::test {

class SimChip {
 public:
  struct Options {
    int lines = 16;
    std::map<int, std::string> names{};  ///< of lines
    std::map<int, std::string> hogs{};   ///< lines the kernel itself takes as inputs, by consumer
  };
  SimChip(std::string label, const Options& options);
  ~SimChip();
  SimChip(const SimChip&) = delete;
  SimChip& operator=(const SimChip&) = delete;

  [[nodiscard]] const std::string& label() const { return label_; }
  /// "gpiochip0"
  [[nodiscard]] const std::string& name() const { return name_; }
  /// The level that the wire at `line` has.
  void pull(int line, bool up) const;
  [[nodiscard]] bool value(int line) const;
  void unplug();
  void plug();
  /// The kernel's number of `line`, as its trace has it.
  [[nodiscard]] int number(int line) const { return base_ + line; }

 private:
  [[nodiscard]] std::string attribute(int line, const char* what) const;
  std::string label_, folder_, name_, sysfs_;
  int base_ = 0;
};

/// The kernel's own record of every value that was set on an output, from now on. The guest records them from its boot.
class KernelTrace {
 public:
  KernelTrace();
  struct Set {
    std::string process;  ///< "plc-run", "plc-guardian"
    int value = -1;
  };
  /// What was set on the line with this number, in order.
  [[nodiscard]] std::vector<Set> sets(int number) const;
};

/// Text of a file, without the last line end; empty when it cannot be read.
std::string text_of(const std::string& path);
void write_text(const std::string& path, const std::string& text);

}  // namespace plc::test
