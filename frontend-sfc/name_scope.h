// NameScope: names that a body sees beside those of its POU while it is lowered: the steps of its own chart, the result
// of a transition.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "ir/ir.h"

namespace plc::sfc {

class NameScope {
 public:
  NameScope(ir::Module& module, std::uint32_t pou) : module_(module), pou_(pou) {}
  ~NameScope() {
    auto& names = module_.pous[pou_].by_name;
    while (!before_.empty()) {
      auto& [name, index] = before_.back();
      if (index) {
        names[name] = *index;
      } else {
        names.erase(name);
      }
      before_.pop_back();
    }
  }
  NameScope(const NameScope&) = delete;
  NameScope& operator=(const NameScope&) = delete;

  /// `name` means variable `index` of the POU, whatever it meant before.
  void add(const std::string& name, std::uint32_t index) {
    auto& names = module_.pous[pou_].by_name;
    const auto known = names.find(name);
    before_.emplace_back(name, known == names.end() ? std::nullopt : std::optional(known->second));
    names[name] = index;
  }

 private:
  ir::Module& module_;
  std::uint32_t pou_;
  std::vector<std::pair<std::string, std::optional<std::uint32_t>>> before_;
};

}  // namespace plc::sfc
