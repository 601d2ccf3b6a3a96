#include "tools/plc-run/watch.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "core/clock.h"

namespace plc::tools {
namespace {

constexpr std::size_t kMostItems = 200;
constexpr core::TimeNs kPollNs = 500'000;

}  // namespace

LiveView::LiveView(const std::vector<std::string>& patterns, runtime::Resource& resource, Output& output)
    : access_(resource), output_(output) {
  for (std::size_t i = 0; i < resource.task_count(); ++i) {
    requests_.push_back(std::make_unique<std::atomic<Request>>(Request::kIdle));
  }
  for (const std::string& pattern : patterns) {
    for (std::string& path : access_.list_names(pattern, kMostItems)) {
      const bool known = std::any_of(items_.begin(), items_.end(), [&](const Item& i) { return i.path == path; });
      const auto place = access_.find_leaf(path);
      if (known || !place || items_.size() == kMostItems) continue;
      Item item;
      item.place = *place;
      // Room for the longest text: every character of a string may be written as an escape of five.
      const bytecode::ImageType& type = resource.image().types[item.place.type];
      std::size_t room = 64 + 5u * type.capacity;
      for (const std::string& member : type.members) room = std::max(room, member.size());
      item.text.reserve(room);
      item.path = std::move(path);
      path_width_ = std::max(path_width_, item.path.size());
      items_.push_back(std::move(item));
    }
  }
}

void LiveView::after_scan(const runtime::ReleaseContext& context) noexcept {
  std::atomic<Request>& request = *requests_[context.task];
  if (request.load(std::memory_order_acquire) != Request::kAsked) return;
  for (Item& item : items_) {
    if (item.place.task != context.task) continue;
    item.text.clear();
    access_.read_to(item.place, item.text, runtime::ValueStyle::kNames);
  }
  request.store(Request::kReady, std::memory_order_release);
}

void LiveView::show(core::TimeNs since_start_ns, core::TimeNs patience_ns) {
  for (const auto& request : requests_) {
    Request idle = Request::kIdle;
    request->compare_exchange_strong(idle, Request::kAsked, std::memory_order_acq_rel);
  }
  core::MonotonicClock clock;
  const core::TimeNs deadline = clock.now_ns() + patience_ns;
  const auto answered = [](const auto& r) { return r->load(std::memory_order_acquire) == Request::kReady; };
  while (!std::all_of(requests_.begin(), requests_.end(), answered) && clock.now_ns() < deadline) {
    clock.sleep_until_ns(clock.now_ns() + kPollNs);
  }
  for (Item& item : items_) {
    if (item.place.task == runtime::Place::kGlobal) {
      item.text.clear();
      access_.read_to(item.place, item.text, runtime::ValueStyle::kNames);
    }
  }
  // What a slow or stopped task has not answered is shown as it was; its request stays open.
  if (output_.out().is_terminal()) {
    print_terminal(since_start_ns);
  } else {
    print_lines(since_start_ns);
  }
  for (const auto& request : requests_) {
    Request ready = Request::kReady;
    request->compare_exchange_strong(ready, Request::kIdle, std::memory_order_acq_rel);
  }
}

void LiveView::print_terminal(core::TimeNs since_start_ns) {
  std::string out;
  // What others have printed since stays: the next block is below it.
  if (std::exchange(texts_, output_.texts_on_terminal()) != output_.texts_on_terminal()) drawn_lines_ = 0;
  if (drawn_lines_ != 0) out += fmt::format("\x1b[{}A", drawn_lines_);
  out += fmt::format("\x1b[2K{:8.1f} s\n", static_cast<double>(since_start_ns) / 1e9);
  for (Item& item : items_) {
    const bool open = item.place.task != runtime::Place::kGlobal &&
                      requests_[item.place.task]->load(std::memory_order_acquire) == Request::kAsked;
    if (!open) {
      const bool changed = item.text != item.shown;
      item.shown = item.text;
      out += fmt::format("\x1b[2K  {:<{}}  {}{}{}\n", item.path, path_width_, changed ? "\x1b[1m" : "", item.shown,
                         changed ? "\x1b[0m" : "");
    } else {
      out += fmt::format("\x1b[2K  {:<{}}  {}\n", item.path, path_width_, item.shown);
    }
  }
  drawn_lines_ = items_.size() + 1;
  output_.out().print_or_drop(out);
}

void LiveView::print_lines(core::TimeNs since_start_ns) {
  std::string changes;
  for (Item& item : items_) {
    if (item.place.task != runtime::Place::kGlobal &&
        requests_[item.place.task]->load(std::memory_order_acquire) == Request::kAsked) {
      continue;
    }
    if (item.text == item.shown) continue;
    item.shown = item.text;
    changes += fmt::format(" {}={}", item.path, item.shown);
  }
  if (changes.empty()) return;
  const std::string line = fmt::format("{:8.1f} s {}\n", static_cast<double>(since_start_ns) / 1e9, changes);
  output_.out().print_or_drop(line);
}

}  // namespace plc::tools
