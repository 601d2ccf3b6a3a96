// ShadowValues: globals as their owners have published them, and variables of tasks as replicas have them, which
// execute the recorded scans of the plant soon after it did (shadow/shadow.h).
//
// Threads: one at a time. Does not belong here: executing scans.
#pragma once

#include <memory>
#include <vector>

#include "engineering/value_source.h"
#include "shadow/shadow.h"

namespace plc::engineering {

class ShadowValues final : public ValueSource {
 public:
  /// Before tasks run. Without a shadow, globals alone are known.
  explicit ShadowValues(runtime::GlobalTable& globals) : globals_(globals) {}
  /// Must live until detach(). Before the first take().
  void attach(shadow::Shadow& shadow) { shadow_ = &shadow; }
  /// Nobody looks any more.
  void detach();

  void take() override;
  [[nodiscard]] bool knows(std::uint32_t task) const override;
  void read(std::uint32_t task, std::uint32_t offset, std::uint32_t bytes, std::byte* to) const override;

 private:
  void look() const;

  GlobalValues globals_;
  shadow::Shadow* shadow_ = nullptr;
  // Of variables of tasks: taken with the first one that is read after take(), and not where nobody asks for them.
  mutable std::unique_ptr<shadow::Shadow::Viewer> viewer_;  ///< while somebody asks
  mutable bool asked_ = false;                              ///< since the last take()
  unsigned idle_ = 0;                                       ///< calls of take() since somebody asked
  mutable std::vector<std::vector<std::byte>> tables_;      ///< by task
};

}  // namespace plc::engineering
