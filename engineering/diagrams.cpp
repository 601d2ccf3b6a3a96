#include "engineering/diagrams.h"

#include <algorithm>
#include <map>
#include <utility>

#include "bytecode/drawn_lines.h"
#include "core/text.h"

namespace plc::engineering {
namespace {

using bytecode::DrawnBody;
using bytecode::DrawnElement;
using bytecode::DrawnKey;
using bytecode::DrawnSide;
using core::ElementKind;

/// POUs whose drawings are kept ready, beyond those that somebody holds.
constexpr std::size_t kMostOpened = 4;
/// Calls of rest(): five minutes.
constexpr unsigned kMostIdle = 3000;

bool is_variable(ElementKind kind) {
  return kind == ElementKind::kContact || kind == ElementKind::kCoil || kind == ElementKind::kInVariable ||
         kind == ElementKind::kOutVariable || kind == ElementKind::kInOutVariable;
}

std::size_t row_of(std::span<const bytecode::ProbePoint> points, DrawnKey key) {
  key.pou = 0;
  const auto found = std::lower_bound(points.begin(), points.end(), key,
                                      [](const bytecode::ProbePoint& p, const DrawnKey& k) { return p.key < k; });
  return found == points.end() || found->key != key ? points.size() : static_cast<std::size_t>(found - points.begin());
}

}  // namespace

Diagrams::Diagrams(runtime::Resource& resource) : resource_(resource) {
  if (resource.image().drawings.empty()) return;
  for (std::uint32_t task = 0; task < resource.task_count(); ++task)
    reached_.push_back(shadow::reached_by(resource.program(task)));
}

const DrawnPou* Diagrams::Book::find(std::string_view name) const {
  const auto found =
      std::find_if(pous.begin(), pous.end(), [name](const DrawnPou& pou) { return core::iequals(pou.name, name); });
  return found == pous.end() ? nullptr : &*found;
}

std::span<const bytecode::ProbePoint> Diagrams::points(const DrawnPou& pou) const {
  const bytecode::Image& image = resource_.image();
  if (pou.pou >= image.probes.size()) return {};
  return image.probes[pou.pou].points;
}

std::shared_ptr<const Diagrams::Book> Diagrams::book() {
  const auto known = [this] {
    const std::lock_guard lock(mutex_);
    idle_ = 0;
    return book_;
  };
  if (auto book = known(); book || resource_.image().drawings.empty()) return book;
  const std::lock_guard one_at_a_time(making_);
  if (auto book = known()) return book;
  auto made = make_book();
  const std::lock_guard lock(mutex_);
  return book_ = std::move(made);
}

std::shared_ptr<const Diagrams::Book> Diagrams::make_book() const {
  const bytecode::Image& image = resource_.image();
  auto drawings = bytecode::unpack(image.drawings);
  if (!drawings) return nullptr;
  auto made = std::make_shared<Book>();
  made->drawings = std::move(*drawings);
  std::map<std::string, std::size_t> rows;
  for (const DrawnBody& body : made->drawings.bodies) {
    const auto [known, fresh] = rows.try_emplace(core::folded(body.name), made->pous.size());
    if (fresh) made->pous.push_back({body.name, DrawnPou::kNobody, {}, {}});
    made->pous[known->second].bodies.push_back(&body);
  }
  for (std::uint32_t p = 0; p < image.pous.size(); ++p) {
    const auto known = rows.find(core::folded(image.pous[p].name));
    if (known == rows.end()) continue;
    DrawnPou& pou = made->pous[known->second];
    if (pou.pou == DrawnPou::kNobody) pou.pou = p;
    pou.pous.push_back(p);
  }
  return made;
}

std::shared_ptr<const Diagrams::Opened> Diagrams::open(std::string_view name) {
  const std::shared_ptr<const Book> book = this->book();
  const DrawnPou* const pou = book ? book->find(name) : nullptr;
  if (pou == nullptr) return nullptr;
  if (auto opened = opened_now(pou)) return opened;
  const std::lock_guard one_at_a_time(making_);
  if (auto opened = opened_now(pou)) return opened;
  auto made = make_opened(book, *pou);
  const std::lock_guard lock(mutex_);
  std::erase_if(held_, [](const auto& one) { return one.expired(); });
  held_.push_back(made);
  opened_.insert(opened_.begin(), made);
  if (opened_.size() > kMostOpened) opened_.pop_back();
  return made;
}

std::shared_ptr<const Diagrams::Opened> Diagrams::opened_now(const DrawnPou* pou) {
  const std::lock_guard lock(mutex_);
  const auto known = std::find_if(opened_.begin(), opened_.end(), [&](const auto& one) { return one->pou == pou; });
  if (known != opened_.end()) {
    std::rotate(opened_.begin(), known, known + 1);
    return opened_.front();
  }
  for (const std::weak_ptr<const Opened>& one : held_) {
    if (auto opened = one.lock(); opened && opened->pou == pou) return opened;
  }
  return nullptr;
}

std::shared_ptr<const Diagrams::Opened> Diagrams::make_opened(const std::shared_ptr<const Book>& book,
                                                              const DrawnPou& pou) const {
  auto made = std::make_shared<Opened>();
  made->book = book;
  made->pou = &pou;
  const auto all = points(pou);
  pictures::Marks marks;
  for (std::size_t i = 0; i < all.size(); ++i) {
    DrawnKey key = all[i].key;
    key.pou = pou.pou;
    marks.emplace_hint(marks.end(), key, pictures::Mark{pictures::Look::kPlain, {}, static_cast<std::int64_t>(i)});
  }
  made->names.resize(all.size());
  std::vector<pictures::PicturedBody> bodies;
  for (const DrawnBody* const body : pou.bodies) {
    bodies.push_back({body, pou.bodies.size() > 1 ? body->worksheet : std::string(), pou.pou});
    for (const DrawnElement& e : body->elements) {
      const std::size_t row = is_variable(e.kind) ? row_of(all, bytecode::key_of(0, e)) : all.size();
      if (row < all.size()) made->names[row] = e.text;
    }
    if (body->text.empty()) continue;
    const bytecode::DrawnLines lines(*body);
    for (std::size_t i = 0; i < all.size(); ++i) {
      const DrawnKey& key = all[i].key;
      if (key.local_id < 0 && key.side == DrawnSide::kOutput && made->names[i].empty())
        made->names[i] = lines.name_at(key.line, key.column);
    }
  }
  made->sheet = std::make_unique<const pictures::Sheet>(bodies, std::move(marks));
  return made;
}

std::vector<DrawnInstance> Diagrams::instances(const DrawnPou& pou, std::size_t most) const {
  std::vector<DrawnInstance> all;
  for (std::uint32_t task = 0; task < reached_.size(); ++task) {
    for (const std::uint32_t p : pou.pous) {
      if (all.size() >= most) return all;
      for (shadow::PouInstance& one :
           shadow::instances_of(resource_.program(task), p, most - all.size(), &reached_[task]))
        all.push_back({task, std::move(one)});
    }
  }
  return all;
}

std::optional<DrawnInstance> Diagrams::instance(const DrawnPou& pou, std::string_view path,
                                                std::string_view task) const {
  constexpr std::size_t kMost = 100'000;
  for (DrawnInstance& one : instances(pou, path.empty() && task.empty() ? 1 : kMost)) {
    if (!path.empty() && !core::iequals(one.at.path, path)) continue;
    if (!task.empty() && !core::iequals(resource_.image().tasks[one.task].name, task)) continue;
    return std::move(one);
  }
  return {};
}

void Diagrams::rest() {
  const std::lock_guard lock(mutex_);
  if (!book_ || ++idle_ < kMostIdle) return;
  opened_.clear();
  book_.reset();
}

}  // namespace plc::engineering
