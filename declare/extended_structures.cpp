#include "declare/extended_structures.h"

#include <cstddef>
#include <optional>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "core/text.h"

namespace plc::st {
namespace {

using plcopen::TypeSpec;

/// Bytes of texts that weigh as much as a member.
constexpr std::size_t kTextWeight = 256;

/// What a copy costs, in members and values.
std::size_t weight_of(const plcopen::InitialValue& value) {
  std::size_t weight = (value.text.size() + value.member.size() + value.repetition.size()) / kTextWeight;
  for (const plcopen::InitialValue& one : value.values) weight += 1 + weight_of(one);
  return weight;
}

/// TypeSpec::base is shared by copies.
std::size_t weight_of(const std::vector<plcopen::Variable>& members) {
  std::size_t weight = members.size();
  for (const plcopen::Variable& member : members) {
    weight += weight_of(member.initial) + member.type.values.size() + member.type.dimensions.size() +
              (member.name.size() + member.documentation.size() + member.type.name.size()) / kTextWeight +
              weight_of(member.type.members);
  }
  return weight;
}

class Joiner {
 public:
  Joiner(plcopen::Project& project, std::size_t limit)
      : project_(project), limit_(limit), states_(project.data_types.size()), weights_(states_.size()) {}

  void run() {
    for (std::size_t i = 0; i < states_.size(); ++i) known_.try_emplace(project_.data_types[i].name, i);
    for (std::size_t i = 0; i < states_.size(); ++i) join(i);
  }

 private:
  enum class State : unsigned char { kUntouched, kInProgress, kDone };

  static bool extends(const TypeSpec& type) { return type.kind == TypeSpec::Kind::kStruct && type.base != nullptr; }

  /// What `type` extends, into the data types; their number when it is none of them.
  [[nodiscard]] std::size_t base_of(const TypeSpec& type) const {
    const std::string_view name = core::trimmed(type.base->name);
    auto found = known_.find(name);
    // Types of libraries are written with their namespace, too.
    if (found == known_.end()) found = known_.find(name.substr(name.rfind('.') + 1));
    return found == known_.end() ? states_.size() : found->second;
  }

  /// What the members of a data type weigh, counted once: many may extend it.
  std::size_t weight(std::size_t index) {
    std::optional<std::size_t>& known = weights_[index];
    if (!known) known = weight_of(project_.data_types[index].type.members);
    return *known;
  }

  /// From the structure that extends nothing down to `index`: in a loop, as a chain may be of any length.
  void join(std::size_t index) {
    std::vector<std::size_t> chain;
    while (index < states_.size() && states_[index] == State::kUntouched && extends(project_.data_types[index].type)) {
      states_[index] = State::kInProgress;
      chain.push_back(index);
      index = base_of(project_.data_types[index].type);
    }
    bool usable = index < states_.size() && project_.data_types[index].type.kind == TypeSpec::Kind::kStruct &&
                  !extends(project_.data_types[index].type);
    for (; !chain.empty(); chain.pop_back()) {
      const std::size_t last = chain.back();
      TypeSpec& type = project_.data_types[last].type;
      states_[last] = State::kDone;
      usable = usable && weight(index) <= limit_ - joined_;
      if (usable) {
        const std::vector<plcopen::Variable>& members = project_.data_types[index].type.members;
        joined_ += weight(index);
        weights_[last] = weight(last) + weight(index);
        type.members.insert(type.members.begin(), members.begin(), members.end());
        type.base.reset();
      }
      index = last;
    }
  }

  plcopen::Project& project_;
  std::size_t limit_;
  std::vector<State> states_;
  std::vector<std::optional<std::size_t>> weights_;
  std::size_t joined_ = 0;
  std::unordered_map<std::string_view, std::size_t, core::NameHash, core::NameEqual> known_;
};

}  // namespace

void join_extended_structures(plcopen::Project& project, std::size_t limit) { Joiner(project, limit).run(); }

}  // namespace plc::st
