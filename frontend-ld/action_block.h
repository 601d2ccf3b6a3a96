// ActionBlocks: action blocks drawn in LD and FBD bodies. Power flow takes the place of a step's activity; qualifiers
// mean what they mean in IEC 61131-3:2013, 6.7.4, except that each action takes effect at its place, like a coil.
//
// In: Element::actions and the flow into the block. Out: IR through the Builder of the drawing; timers and stored
// actions are hidden variables. Does not belong here: actions of sequential function charts, the flow itself
// (lower.cpp).
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "frontend-fbd/drawing.h"

namespace plc::ld {

class ActionBlocks {
 public:
  explicit ActionBlocks(fbd::Drawing& drawing) : d_(drawing), b_(drawing.builder()) {}

  /// Lowers the actions of `node`, in the order of the file, under the power `flow`. Reports every problem (P2004).
  void lower(fbd::NodeId node, ir::ValueId flow);

 private:
  enum class Qualifier : std::uint8_t { kN, kS, kR, kL, kD, kP, kP0, kSd, kDs, kSl };
  /// One action of the body: its block, and its index there.
  using ActionId = std::pair<fbd::NodeId, std::uint32_t>;
  /// Hidden variables of one action, by index into Pou::variables; made when first asked for.
  struct Memory {
    std::optional<std::uint32_t> stored;  ///< BOOL: set since the last R
    std::optional<std::uint32_t> timer;   ///< TON
  };
  /// What an action does to its variable, or when its ST runs.
  struct Activity {
    ir::ValueId value{};
    plcopen::Storage storage = plcopen::Storage::kNone;
  };

  static std::optional<Qualifier> qualifier_of(std::string_view text);
  static bool is_timed(Qualifier qualifier);
  [[nodiscard]] const plcopen::ActionLink& action(const ActionId& id) const {
    return d_.element(id.first).actions[id.second];
  }
  /// The action runs something, its own ST or an action of a POU, and drives no variable.
  [[nodiscard]] bool runs(const plcopen::ActionLink& action) const;
  void find_stored();
  void lower_action(const ActionId& id, ir::ValueId flow);
  void reset(const ActionId& id, ir::ValueId flow);
  void write(const ActionId& id, ir::PlaceId variable, Activity activity);
  void run_text(const ActionId& id, ir::ValueId active);
  Activity activity(const ActionId& id, Qualifier qualifier, ir::ValueId flow, ir::ValueId duration);
  std::optional<ir::PlaceId> variable(const plcopen::ActionLink& action);
  std::optional<ir::ValueId> duration(const plcopen::ActionLink& action);
  ir::PlaceId stored(const ActionId& id);
  ir::PlaceId timer(const ActionId& id);
  ir::ValueId store(const ActionId& id, ir::ValueId set);
  ir::ValueId on_delay(const ActionId& id, ir::ValueId in, ir::ValueId duration);
  void report(const plcopen::ActionLink& action, std::string message, std::string help);

  fbd::Drawing& d_;
  ir::Builder& b_;
  std::map<ActionId, Memory> memories_;
  bool searched_ = false;                                ///< the two below are filled
  std::map<std::string, std::vector<ActionId>> stored_;  ///< by name: what an R of the name has to forget
  std::set<std::string> texts_;                          ///< names of actions written as ST
  std::map<std::string, ir::ValueId> written_;           ///< by name: what this block wrote so far like a normal coil
};

/// The actions of a block for `plc explain`: "N Motor, L Lamp".
std::string action_summary(const plcopen::Element& element);

}  // namespace plc::ld
