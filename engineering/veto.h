// Veto: a BOOL of the program that says, while it is TRUE, that something must not be done now.
//
// Threads: made before the tasks run; holds() any. Does not belong here: what is not done.
#pragma once

#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "runtime/access.h"
#include "runtime/memory/global_ports.h"
#include "runtime/resource.h"

namespace plc::engineering {

class Veto {
 public:
  /// `path`: a global; empty: nothing is ever forbidden. One that is no BOOL of the program forbids nothing: plc.toml
  /// is checked before (io-drivers/config).
  Veto(runtime::Resource& resource, std::string path) : path_(std::move(path)) {
    if (path_.empty()) return;
    const auto place = runtime::Access(resource).find_leaf(path_);
    if (place && place->task == runtime::Place::kGlobal && resource.image().types[place->type].size == 1) {
      place_ = *place;
      reader_.emplace(resource.globals());
    }
  }

  /// As its task has published it last.
  [[nodiscard]] bool holds() {
    if (!place_) return false;
    const std::lock_guard lock(mutex_);
    reader_->take();
    std::byte value{};
    reader_->read(place_->offset, 1, &value);
    return value != std::byte{0};
  }
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  std::string path_;
  std::optional<runtime::Place> place_;
  std::mutex mutex_;
  std::optional<runtime::GlobalReader> reader_;
};

}  // namespace plc::engineering
