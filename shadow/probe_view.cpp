#include "shadow/probe_view.h"

#include <algorithm>
#include <unordered_map>

#include "runtime/link/link.h"

namespace plc::shadow {

namespace {

using bytecode::Image;
using bytecode::ImageType;
using bytecode::TypeKind;
using runtime::ProbeValues;

class Search {
 public:
  Search(const Image& image, std::uint32_t pou, std::size_t most)
      : image_(image), pou_(pou), wanted_(image.pous[pou].instance_type), most_(most) {}

  void fields(std::uint32_t type, std::uint32_t offset, const std::string& path, bool globals) {
    const std::vector<bytecode::ImageField>& all = image_.types[type].fields;
    for (std::size_t f = 0; f < all.size(); ++f) {
      const std::string list = globals && !image_.globals[f].list.empty() ? image_.globals[f].list + "." : "";
      walk(all[f].type, offset + all[f].offset, path + (path.empty() ? "" : ".") + list + all[f].name);
    }
  }
  std::vector<PouInstance> take() { return std::move(found_); }

 private:
  void walk(std::uint32_t type, std::uint32_t offset, const std::string& path) {
    if (found_.size() >= most_ || !holds(type)) return;
    const ImageType& t = image_.types[type];
    if (type == wanted_) {
      found_.push_back({path, {pou_, offset}});
    } else if (t.kind == TypeKind::kArray) {
      elements(t, offset, path + "[");
    } else {
      fields(type, offset, path, false);
    }
  }
  /// Of several dimensions: arrays of arrays.
  void elements(const ImageType& array, std::uint32_t offset, const std::string& path) {
    const ImageType& element = image_.types[array.element];
    for (std::uint32_t i = 0; i < array.count; ++i, offset += element.size) {
      const std::string at = path + std::to_string(array.lower + i);
      if (element.kind == TypeKind::kArray) {
        elements(element, offset, at + ",");
      } else {
        walk(array.element, offset, at + "]");
      }
    }
  }
  bool holds(std::uint32_t type) {
    if (type == wanted_) return true;
    const ImageType& t = image_.types[type];
    if (t.kind != TypeKind::kArray && t.kind != TypeKind::kStruct) return false;
    if (const auto known = holds_.find(type); known != holds_.end()) return known->second;
    const bool found = t.kind == TypeKind::kArray
                           ? holds(t.element)
                           : std::any_of(t.fields.begin(), t.fields.end(),
                                         [this](const bytecode::ImageField& field) { return holds(field.type); });
    return holds_[type] = found;
  }

  const Image& image_;
  std::uint32_t pou_, wanted_;
  std::size_t most_;
  std::unordered_map<std::uint32_t, bool> holds_;
  std::vector<PouInstance> found_;
};

}  // namespace

std::vector<std::uint32_t> reached_by(const runtime::Program& program) {
  return runtime::reached_pous(program.image(), program.task().body);
}

std::vector<PouInstance> instances_of(const runtime::Program& program, std::uint32_t pou, std::size_t most,
                                      const std::vector<std::uint32_t>* reached) {
  const Image& image = program.image();
  const std::uint32_t body = program.task().body;
  const std::vector<std::uint32_t> own = reached == nullptr ? reached_by(program) : std::vector<std::uint32_t>();
  const std::vector<std::uint32_t>& all = reached == nullptr ? own : *reached;
  if (std::find(all.begin(), all.end(), pou) == all.end()) return {};
  if (image.pous[pou].kind == bytecode::PouKind::kFunction) return {{image.pous[pou].name, {pou, 0}}};
  Search search(image, pou, most);
  search.fields(image.pous[body].instance_type, program.table().layout().instance, "", false);
  search.fields(image.global_type, 0, "", true);
  return search.take();
}

const bytecode::ProbePoint* ProbeView::find(bytecode::DrawnKey key) const {
  key.pou = 0;
  const auto found =
      std::lower_bound(map_->points.begin(), map_->points.end(), key,
                       [](const bytecode::ProbePoint& p, const bytecode::DrawnKey& k) { return p.key < k; });
  return found == map_->points.end() || found->key != key ? nullptr : &*found;
}

Shown ProbeView::at(const bytecode::ProbePoint& point) const {
  Shown shown;
  if (values_ == nullptr) return shown;
  const std::uint8_t bits = values_->bits(point.step);
  shown.ran = (bits & ProbeValues::kRan) != 0;
  shown.was_on = (bits & ProbeValues::kWasTrue) != 0;
  shown.was_off = (bits & ProbeValues::kWasFalse) != 0;
  shown.was_unknown = (bits & ProbeValues::kWasUnknown) != 0;
  shown.is_bool = values_->is_bool(point.step);
  shown.known = !values_->value(point.step).empty();
  shown.on = values_->is_true(point.step);
  return shown;
}

std::optional<Shown> ProbeView::at(bytecode::DrawnKey key) const {
  const bytecode::ProbePoint* const point = find(key);
  return point == nullptr ? std::nullopt : std::optional(at(*point));
}

std::string ProbeView::text(const bytecode::ProbePoint& point, runtime::ValueStyle style) const {
  if (values_ == nullptr) return {};
  const auto value = values_->value(point.step);
  if (value.empty()) return {};
  if (values_->is_bool(point.step)) {
    const bool on = values_->is_true(point.step);
    return style == runtime::ValueStyle::kNumbers ? (on ? "1" : "0") : (on ? "TRUE" : "FALSE");
  }
  std::string out;
  runtime::append_value(image_->types[values_->type(point.step)], value.data(), out, style);
  return out;
}

std::string ProbeView::text(bytecode::DrawnKey key, runtime::ValueStyle style) const {
  const bytecode::ProbePoint* const point = find(key);
  return point == nullptr ? std::string() : text(*point, style);
}

}  // namespace plc::shadow
