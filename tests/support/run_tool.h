// Starts a program, waits for it and hands back what it printed. For the end-to-end tests: cases, diagnostics, corpus.
//
// In: argument list, seconds it may take. Out: exit code, the two streams. A crash or time-out shows as a negative code
// (minus the signal). Does not belong here: knowledge of any command's options.
#pragma once

#include <string>
#include <vector>

namespace plc::test {

struct ToolResult {
  int code = 0;  ///< exit code; -signal when the process was killed
  std::string out;
  std::string err;
  /// Both streams: tests that do not care where a message went.
  [[nodiscard]] std::string all() const { return out + err; }
};

/// Runs `arguments[0]` with the rest; killed by SIGALRM after `seconds`.
ToolResult run_tool(const std::vector<std::string>& arguments, unsigned seconds = 60);

/// The command line as one would type it, for failure messages.
std::string command_line(const std::vector<std::string>& arguments);

/// The localIds in the order in which `plc explain` lists them: lines "  3  block 12  text ..".
std::vector<std::string> explained_order(const std::string& output);

/// A fresh empty folder below the system's temporary folder; removed with its content when the object dies.
class ScratchFolder {
 public:
  ScratchFolder();
  ~ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  [[nodiscard]] std::string file(const std::string& name) const { return path_ + "/" + name; }

 private:
  std::string path_;
};

}  // namespace plc::test
