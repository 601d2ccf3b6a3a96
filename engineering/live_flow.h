// LiveFlow: what viewers of diagrams see of a plant that runs: the power flow of replicas that execute its scans soon
// after it (shadow/shadow.h), with probes where somebody looks. Each viewer has its own frames.
//
// In: a shadow, which keys of which instance a viewer looks at. Out: what they had since its last frame. Threads: that
// of the connections. Does not belong here: drawings, JSON.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engineering/diagrams.h"
#include "shadow/probe_view.h"
#include "shadow/shadow.h"

namespace plc::engineering {

class LiveFlow {
 public:
  /// Null: nothing is recorded, and nothing is seen. It must live until all viewers have gone.
  void set_shadow(shadow::Shadow* shadow) { shadow_ = shadow; }
  [[nodiscard]] bool on() const { return shadow_ != nullptr; }

  struct Frame {
    std::uint64_t scan = 0;  ///< the newest that was executed, of the task
    core::TimeNs utc_ns = 0;
    std::vector<shadow::Shown> shown;  ///< by key, since the viewer's last frame
    std::vector<std::string> texts;
  };
  /// Somebody who looks, as long as it lives.
  class Viewer {
   public:
    explicit Viewer(LiveFlow& flow) : flow_(flow) {}
    ~Viewer() { flow_.forget(*this); }
    Viewer(const Viewer&) = delete;
    Viewer& operator=(const Viewer&) = delete;
    /// From the next scan on. What happened before at the same keys of the same instance still counts.
    void look(const DrawnInstance& instance, std::vector<bytecode::DrawnKey> keys);
    /// Nothing when no scan was executed since the last frame.
    std::optional<Frame> take() { return flow_.take(*this); }

   private:
    friend class LiveFlow;
    struct Bits {
      bool ran = false, was_on = false, was_off = false, was_unknown = false;
    };
    LiveFlow& flow_;
    DrawnInstance instance_;
    std::vector<bytecode::DrawnKey> keys_;
    std::vector<Bits> bits_;
    bool looks_ = false, fresh_ = false;
  };

 private:
  struct Group {
    std::uint64_t next = 0;  ///< scan whose values are not collected yet
    bool applied = false;
  };
  using Place = std::pair<std::uint32_t, runtime::ProbedPou>;  ///< task, view
  void look(Viewer& viewer);
  void forget(Viewer& viewer);
  std::optional<Frame> take(Viewer& viewer);
  /// Tells the replicas who looks at what.
  void apply(shadow::Follower& follower);
  /// Adds what happened to what each viewer has seen.
  void collect(shadow::Follower& follower);
  void regroup();

  shadow::Shadow* shadow_ = nullptr;
  std::unique_ptr<shadow::Shadow::Viewer> viewer_;  ///< while anybody looks
  std::vector<Viewer*> viewers_;
  std::map<Place, Group> groups_;
  bool changed_ = false;  ///< groups_, since apply()
};

}  // namespace plc::engineering
