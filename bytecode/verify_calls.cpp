#include <fmt/format.h>

#include <algorithm>

#include "bytecode/paths.h"
#include "bytecode/verifier.h"

namespace plc::bytecode {

namespace {

class CallVerifier {
 public:
  CallVerifier(const Image& image, Report& report, std::vector<PouFacts>& facts)
      : image_(image), report_(report), facts_(facts) {}

  std::uint32_t run() {
    if (image_.tasks.size() > kMaxTasks) {
      report_.broken(Rule::kV415, fmt::format("{} tasks", image_.tasks.size()));
      return 0;
    }
    follow_calls();
    for (const ImageTask& task : image_.tasks) check_task(task);
    if (report_.clean()) check_writers();
    if (report_.clean()) check_queues();
    return deepest_;
  }

 private:
  enum class State : std::uint8_t { kNew, kOpen, kDone };

  // Depth first with a stack of our own: the chain of calls is as long as the image says.
  void follow_calls() {
    states_.resize(image_.pous.size());
    depths_.resize(image_.pous.size());
    struct Step {
      std::uint32_t pou;
      std::size_t next;  // call to follow
    };
    std::vector<Step> stack;
    for (std::uint32_t root = 0; root < image_.pous.size(); ++root) {
      if (states_[root] != State::kNew) continue;
      stack.push_back({root, 0});
      states_[root] = State::kOpen;
      while (!stack.empty()) {
        Step& step = stack.back();
        const PouFacts& facts = facts_[step.pou];
        if (step.next == facts.calls.size()) {
          finish(step.pou);
          stack.pop_back();
          continue;
        }
        const std::uint32_t callee = facts.calls[step.next++].callee;
        if (states_[callee] == State::kOpen) {
          report_.broken(Rule::kV405, fmt::format("{} calls {}", image_.pous[step.pou].name, image_.pous[callee].name));
          return;
        }
        if (states_[callee] == State::kNew) {
          states_[callee] = State::kOpen;
          stack.push_back({callee, 0});
        }
      }
    }
  }

  /// All callees are known: depth and work of one execution.
  void finish(std::uint32_t pou) {
    PouFacts& facts = facts_[pou];
    for (const CallEdge& call : facts.calls) {
      depths_[pou] = std::max(depths_[pou], depths_[call.callee] + 1);
      const std::uint64_t work = facts_[call.callee].work;
      // Beyond the limit the exact number does not matter, but it must not wrap.
      facts.work = std::min(facts.work + std::min(call.times, kMaxTaskWork + 1) * work, kMaxTaskWork + 1);
    }
    facts.work = std::min(facts.work, kMaxTaskWork + 1);
    states_[pou] = State::kDone;
  }

  void check_task(const ImageTask& task) {
    if (task.name.empty() || task.period_ns < 0 || task.priority < 0) {
      report_.broken(Rule::kV413,
                     fmt::format("task \"{}\", period {} ns, priority {}", task.name, task.period_ns, task.priority));
    }
    if (!task.single.empty()) {
      const auto place = find_global(image_, task.single);
      const ImageType* type = place ? &image_.types[place->type] : nullptr;
      if (type == nullptr || type->kind != TypeKind::kScalar || rep_of(*type) != Rep::kBool) {
        report_.broken(Rule::kV414, fmt::format("task {} waits for \"{}\"", task.name, task.single));
      }
    }
    if (task.body >= image_.pous.size() || image_.pous[task.body].kind != PouKind::kTask) {
      report_.broken(Rule::kV412, fmt::format("task {} executes POU {}", task.name, task.body));
      return;
    }
    if (depths_[task.body] > kMaxCallDepth) {
      report_.broken(Rule::kV406, fmt::format("task {} needs {} calls", task.name, depths_[task.body]));
    }
    if (facts_[task.body].work > kMaxTaskWork) {
      report_.broken(Rule::kV407, fmt::format("task {} passes the limit", task.name));
    }
    deepest_ = std::max(deepest_, depths_[task.body]);
  }

  /// Ranges of one body, merged, so that an export named twice counts once.
  static std::vector<GlobalRange> merged(std::vector<GlobalRange> ranges) {
    std::sort(ranges.begin(), ranges.end(),
              [](const GlobalRange& a, const GlobalRange& b) { return a.first < b.first; });
    std::size_t kept = 0;
    for (const GlobalRange& range : ranges) {
      GlobalRange* const before = kept == 0 ? nullptr : &ranges[kept - 1];
      if (before != nullptr && range.first <= before->first + before->count) {
        before->count = std::max(before->count, range.first + range.count - before->first);
      } else {
        ranges[kept++] = range;
      }
    }
    ranges.resize(kept);
    return ranges;
  }

  void check_writers() {
    // Change of the number of writers from one field to the next.
    std::vector<std::int64_t> change(image_.globals.size() + 1);
    for (const ImageTask& task : image_.tasks) {
      for (const GlobalRange& range : merged(facts_[task.body].exports)) {
        ++change[range.first];
        --change[range.first + range.count];
      }
    }
    const auto& fields = image_.types[image_.global_type].fields;
    std::int64_t writers = 0;
    for (std::size_t i = 0; i < image_.globals.size() && !report_.full(); ++i) {
      writers += change[i];
      if (writers != image_.globals[i].writers) {
        report_.broken(Rule::kV411, fmt::format("{} tasks export \"{}\", which names {}", writers, fields[i].name,
                                                image_.globals[i].writers));
      }
      if (writers != 0 && fields[i].constant) {
        report_.broken(Rule::kV410, fmt::format("\"{}\" is exported", fields[i].name));
      }
    }
  }

  /// Queues that the body and all it calls put into or take from.
  void collect_queues(std::uint32_t pou, std::vector<bool>& seen, std::vector<bool>& puts, std::vector<bool>& takes) {
    std::vector<std::uint32_t> open{pou};
    seen[pou] = true;
    while (!open.empty()) {
      const PouFacts& facts = facts_[open.back()];
      open.pop_back();
      for (const PouFacts::QueueUse& use : facts.queues) (use.takes ? takes : puts)[use.queue] = true;
      for (const CallEdge& call : facts.calls) {
        if (!seen[call.callee]) open.push_back(call.callee);
        seen[call.callee] = true;
      }
    }
  }

  void check_queues() {
    const std::size_t queues = image_.queues.size();
    if (queues == 0) return;
    std::vector<ImageQueue> found(queues);
    for (std::uint32_t task = 0; task < image_.tasks.size() && !report_.full(); ++task) {
      std::vector<bool> seen(image_.pous.size()), puts(queues), takes(queues);
      collect_queues(image_.tasks[task].body, seen, puts, takes);
      for (std::size_t q = 0; q < queues; ++q) {
        if (puts[q]) found[q].puts.push_back(task);
        if (!takes[q]) continue;
        if (found[q].takes != ImageQueue::kNoTask) {
          report_.broken(Rule::kV417, fmt::format("tasks {} and {} take from queue {}", found[q].takes, task, q));
        }
        found[q].takes = task;
      }
    }
    for (std::size_t q = 0; q < queues && !report_.full(); ++q) {
      if (found[q].puts == image_.queues[q].puts && found[q].takes == image_.queues[q].takes) continue;
      report_.broken(Rule::kV417, fmt::format("queue {} (\"{}\")", q, image_.queues[q].name));
    }
  }

  const Image& image_;
  Report& report_;
  std::vector<PouFacts>& facts_;
  std::vector<State> states_;
  std::vector<std::uint32_t> depths_;  // nesting of calls below each POU
  std::uint32_t deepest_ = 0;
};

}  // namespace

std::uint32_t verify_calls(const Image& image, Report& report, std::vector<PouFacts>& facts) {
  return CallVerifier(image, report, facts).run();
}

}  // namespace plc::bytecode
