// Alarms: all alarms of a plant: evaluated after every scan that replicas have executed, so that each begins and ends
// in the scan in which it did; never in a cycle.
//
// In: definitions, instances of the block ALARM in the image, scans, what people do. Out: what is the case, events for
// the history. Globals that no task has or whose task has stopped, and all globals when nothing is recorded, are looked
// at with service(). A global of several tasks is looked at after scans of the fastest of them (watch.h).
// Threads: after_scan() that of the shadow; the rest any. Does not belong here: keeping (alarm_store.h), calls.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "alarms/alarm_state.h"
#include "alarms/condition.h"
#include "alarms/definition.h"
#include "alarms/watch.h"
#include "core/diagnostics.h"
#include "runtime/memory/global_ports.h"
#include "shadow/scan_observer.h"

namespace plc::alarms {

/// When and where something happened.
struct Stamp {
  core::TimeNs now_ns = 0;  ///< by the clock of the programs
  core::TimeNs utc_ns = 0;
  std::optional<std::uint32_t> task;  ///< nothing: between scans, by a person or a timer
  std::uint64_t scan = 0;             ///< of that task
};

/// What is written into the history.
struct Event {
  std::int64_t number = 0;  ///< from 1 on, over restarts
  Happened what = Happened::kNothing;
  std::string alarm, text, category, user, comment, task;
  Priority priority = Priority::kMedium;
  core::TimeNs utc_ns = 0;
  std::optional<std::uint64_t> scan;
  std::optional<double> value;
};

/// What is kept of an alarm over a restart.
struct Kept {
  std::string alarm;
  std::int64_t packed = 0;
  std::optional<core::TimeNs> shelved_until_ns;
  core::TimeNs raised_utc_ns = 0;
  std::string user = {}, comment = {};  ///< who acknowledged it, shelved it or took it out of service since then
};

/// An alarm as people see it.
struct View {
  Definition definition;
  State state = State::kNormal;
  bool active = false;  ///< the condition, whatever the state
  double value = 0;
  Stamp raised;                          ///< last time; utc_ns 0: not since it is known
  std::string task;                      ///< of `raised`
  std::uint32_t order = 0;               ///< in its group: 1 was first; 0: in none, or not now
  std::string user, comment;             ///< who acknowledged, shelved or took it out of service
  std::optional<core::TimeNs> until_ns;  ///< shelved, UTC
};

class Alarms final : public shadow::ScanObserver {
 public:
  /// Before tasks run. Those that cannot be evaluated are left out and reported. `recorded`: after_scan() will be
  /// called.
  Alarms(runtime::Resource& resource, std::vector<Definition> definitions, bool recorded,
         core::Diagnostics& diagnostics);

  [[nodiscard]] std::size_t count() const { return items_.size(); }
  /// Whether any of them needs after_scan().
  [[nodiscard]] bool needs_scans() const { return needs_scans_; }
  /// after_scan() will not be called, against what was said: globals are looked at with service(), the rest is left
  /// out. The names of that. Before restore().
  std::vector<std::string> do_without_scans();
  /// As it was when the program ended. Before the first scan. `last_number`: of the events that are kept already.
  void restore(const std::vector<Kept>& all, std::int64_t last_number);

  void after_scan(const shadow::ReplicaSet& replicas, const shadow::ObservedScan& scan) override;
  /// About every 100 ms: globals beside the scans, those of tasks that have stopped by a fault, delays while no scan
  /// comes, shelves that end. `now_ns`: by the clock of the programs, as that of scans
  /// (RealtimeScheduler::program_ns()).
  void service(core::TimeNs now_ns, core::TimeNs utc_ns);

  /// Those that are not normal, the ones that need somebody first; or all.
  [[nodiscard]] std::vector<View> list(bool all) const;
  struct Deed {
    std::string user, comment;
    core::TimeNs utc_ns = 0, now_ns = 0;  ///< as of service()
  };
  /// How many were acknowledged. An empty list: all.
  std::size_t acknowledge(const std::vector<std::string>& names, const Deed& deed);
  /// False: there is no such alarm.
  bool shelve(const std::string& name, core::TimeNs until_ns, const Deed& deed);
  bool unshelve(const std::string& name, const Deed& deed);
  bool take_out_of_service(const std::string& name, bool is, const Deed& deed);
  [[nodiscard]] bool has(const std::string& name) const;

  /// What has happened since the last call, and the states that are to be kept.
  void take(std::vector<Event>& events, std::vector<Kept>& states);

 private:
  /// Offsets of the ports of an instance of ALARM, from its place.
  struct Ports {
    std::uint32_t text = 0, category = 0, group = 0, priority = 0, latch = 0, value = 0;
    std::uint16_t text_capacity = 0, category_capacity = 0, group_capacity = 0;
    runtime::Place place;
  };
  struct Item {
    Definition definition;
    Watched watched;
    std::optional<Ports> ports;
    Condition condition;
    AlarmState state;
    Stamp raised;
    core::TimeNs looked_ns = 0;
    double shown_value = 0;
    std::string user, comment;
    std::optional<core::TimeNs> shelf_end_ns;  ///< by the clock of the programs, which nobody sets
    bool changed = false;                      ///< since it was kept
    bool pins_read = false;                    ///< those of an instance of ALARM, since the start
  };
  /// What is to be read: the variable of an alarm, or what suppresses it.
  struct Look {
    std::size_t item = 0;
    Watched watched;
    bool suppresses = false;
  };
  struct Looks {
    std::vector<Look> suppressions, conditions;
    [[nodiscard]] bool empty() const { return suppressions.empty() && conditions.empty(); }
  };
  struct TaskLooks {
    Looks looks;
    std::optional<core::TimeNs> quiet_since_ns;  ///< no scan since it was seen that the task has stopped
    bool by_time = false;                        ///< it has stopped, and all its scans are known
  };
  /// Where the value of a look lies, and the instance of ALARM that it is of. Null: it cannot be read.
  struct Read {
    const std::byte* value = nullptr;
    const std::byte* ports = nullptr;
  };
  struct Member {
    std::size_t item = 0;
    core::TimeNs now_ns = 0;
  };
  struct Group {
    std::string name;
    std::vector<Member> raised;  ///< since all were normal
  };

  void add(runtime::Resource& resource, Definition definition, bool recorded, core::Diagnostics& diagnostics);
  void add_blocks(runtime::Resource& resource, bool recorded, core::Diagnostics& diagnostics);
  void place_look(Look look);
  /// Looks at all values of one moment; `read_of(look)` gives a Read.
  template <class ReadOf>
  void look_at(const Looks& looks, const Stamp& stamp, ReadOf read_of);
  /// Looks at the globals of the table of the plant, as reader_ has taken it.
  void look_by_time(const Looks& looks, const Stamp& stamp);
  void look_after_stopped(const Stamp& stamp);
  void suppress(Item& item, bool is, const Stamp& stamp);
  void look(Item& item, double value, const std::byte* ports, const Stamp& stamp);
  static void read_pins(Item& item, const std::byte* ports);
  void happened(Item& item, Happened what, const Stamp& stamp, const Deed* deed = nullptr);
  void enter_group(std::size_t item);
  /// Of each item in its group, as View::order.
  [[nodiscard]] std::vector<std::uint32_t> orders() const;
  Item* find(const std::string& name);
  [[nodiscard]] std::string task_name(const Stamp& stamp) const;

  const bytecode::Image& image_;
  const runtime::GlobalTable& globals_;
  runtime::GlobalReader reader_;
  mutable std::mutex mutex_;
  std::vector<Item> items_;
  std::vector<TaskLooks> by_task_;  ///< after scans of each task
  Looks by_time_;                   ///< with service()
  std::vector<Group> groups_;
  std::vector<Event> events_;
  std::int64_t last_number_ = 0;
  bool needs_scans_ = false;
};

}  // namespace plc::alarms
