// A place for files that only this run needs.
//
// In: nothing. Out: paths in a folder of its own. Does not belong here: what the files hold.
#pragma once

#include <string>

namespace plc::bench {

/// A temporary folder that is removed with its content.
class Scratch {
 public:
  Scratch();
  ~Scratch();
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  [[nodiscard]] std::string file(const std::string& name) const { return path_ + "/" + name; }

 private:
  std::string path_;
};

}  // namespace plc::bench
