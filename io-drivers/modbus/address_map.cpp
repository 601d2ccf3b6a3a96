#include "io-drivers/modbus/address_map.h"

#include <algorithm>
#include <tuple>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "core/text.h"
#include "io-drivers/modbus/automatic_area.h"
#include "io-drivers/modbus/cells.h"
#include "io-drivers/modbus/views.h"
#include "runtime/access.h"

namespace plc::modbus {
namespace {

using bytecode::Image;
using bytecode::ImageType;
using bytecode::TypeKind;
using core::Code;
using core::TypeId;

/// Cells of its table that a value takes.
template <class T>
std::uint32_t width_of(const T& value) {
  return std::max<std::uint32_t>(registers_of(value.elementary, value.characters), 1);
}

bool is_input(Table table) { return table == Table::kDiscreteInputs || table == Table::kInputRegisters; }

/// "M[1][2]" -> "M": the array that an element belongs to.
std::string_view without_indices(std::string_view path) {
  while (path.ends_with(']')) path = path.substr(0, path.rfind('['));
  return path;
}

/// One scalar or text of the global table.
struct Leaf {
  std::string path;
  std::uint32_t offset = 0;
  std::uint32_t type = 0;
  std::uint32_t field = 0;  ///< of the global table
  TypeId elementary = TypeId::kBool;
  bool constant = false;  ///< or part of what is: a configuration port
  std::uint16_t characters = 0;
};

class Builder {
 public:
  Builder(runtime::Resource& resource, const io::ModbusConfig& config, FrozenAddresses& frozen,
          core::Diagnostics& diagnostics)
      : resource_(resource),
        image_(resource.image()),
        config_(config),
        frozen_(frozen),
        diagnostics_(diagnostics),
        overlay_(image_.options.profile == core::AddressProfile::kOverlay) {
    for (const auto& [path, entry] : frozen_.entries) known_paths_.emplace(path, path);
  }

  std::vector<Point> run() {
    collect_leaves();
    std::vector<std::size_t> unplaced;
    for (std::size_t i = 0; i < leaves_.size();) {
      std::size_t end = i + 1;
      while (end < leaves_.size() && leaves_[end].field == leaves_[i].field) ++end;
      if (!place_located(i, end)) {
        for (; i < end; ++i) unplaced.push_back(i);
      }
      i = end;
    }
    place_automatic(unplaced);
    apply_rights();
    std::sort(points_.begin(), points_.end(), [](const Point& a, const Point& b) {
      return std::tie(a.table, a.address, a.path) < std::tie(b.table, b.address, b.path);
    });
    refuse_split_values();
    warn_of_ranges_without_effect();
    return std::move(points_);
  }

  [[nodiscard]] io::WordOrder order_at(Table table, std::uint32_t address) const {
    io::WordOrder order = config_.word_order;
    for (const io::ModbusRange& range : config_.ranges) {
      if (range.word_order && range.table == table && range.first <= address && address <= range.last) {
        order = *range.word_order;
      }
    }
    return order;
  }

  /// Calls visit(point index, location) for every point that lies in the bit field of an area.
  template <class Visit>
  void each_in_overlay(std::span<const Point> points, const Visit& visit) const {
    if (!overlay_) return;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> by_offset;  // declaration order
    for (std::uint32_t i = 0; i < points.size(); ++i) by_offset.emplace_back(points[i].offset, i);
    std::sort(by_offset.begin(), by_offset.end());
    for (const auto& [offset, index] : by_offset) {
      const auto location = runtime::parse_location(points[index].iec_address);
      if (location && location->bits == bits_of(points[index].elementary)) visit(index, *location);
    }
  }

 private:
  static std::uint32_t bits_of(TypeId type) {
    return type == TypeId::kBool ? 1 : core::rep_bytes(core::rep_of(type)) * 8;
  }
  [[nodiscard]] const std::vector<bytecode::ImageField>& fields() const {
    return image_.types[image_.global_type].fields;
  }

  // In declaration order, each variable under the path that Access lists it by.
  void collect_leaves() {
    const runtime::Access access(resource_);
    for (runtime::Listed& listed : access.list_places("*")) {
      const ImageType& type = image_.types[listed.place.type];
      const bool text = type.kind == TypeKind::kString && type.capacity != 0;
      if (listed.place.task != runtime::Place::kGlobal || (type.kind != TypeKind::kScalar && !text)) continue;
      const auto field = std::upper_bound(fields().begin(), fields().end(), listed.place.offset,
                                          [](std::uint32_t offset, const auto& f) { return offset < f.offset; });
      leaves_.push_back({std::move(listed.path), listed.place.offset, listed.place.type,
                         static_cast<std::uint32_t>(field - fields().begin() - 1), type.elementary,
                         listed.place.constant, text ? type.capacity : std::uint16_t{0}});
    }
    std::sort(leaves_.begin(), leaves_.end(), [](const Leaf& a, const Leaf& b) { return a.offset < b.offset; });
  }

  void add_point(const Leaf& leaf, Table table, std::uint32_t address, std::string iec_address, bool automatic) {
    Point point;
    point.path = leaf.path;
    point.iec_address = std::move(iec_address);
    point.offset = leaf.offset;
    point.type = leaf.type;
    point.elementary = leaf.elementary;
    point.table = table;
    point.address = static_cast<std::uint16_t>(address);
    point.registers = static_cast<std::uint16_t>(registers_of(leaf.elementary, leaf.characters));
    point.characters = leaf.characters;
    point.automatic = automatic;
    if (point.registers > 1 && point.characters == 0) point.word_order = order_at(table, address);
    points_.push_back(std::move(point));
  }

  /// Structures have no layout that the two sides would agree on; their members are placed one by one.
  [[nodiscard]] bool is_array_of_scalars(std::uint32_t type) const {
    while (image_.types[type].kind == TypeKind::kArray) type = image_.types[type].element;
    return image_.types[type].kind == TypeKind::kScalar;
  }

  [[nodiscard]] std::optional<runtime::Location> location_of(const Leaf& leaf) const {
    return is_array_of_scalars(fields()[leaf.field].type) ? runtime::parse_location(image_.globals[leaf.field].address)
                                                          : std::nullopt;
  }

  /// The leaves begin..end of one field at their place in OpenPLC's map. False when they have none there, all of them.
  bool place_located(std::size_t begin, std::size_t end) {
    const auto location = location_of(leaves_[begin]);
    const View* const view = location ? view_of(*location) : nullptr;
    const TypeId type = leaves_[begin].elementary;
    if (view == nullptr || (view->bits == 1) != (type == TypeId::kBool)) return false;
    const std::uint64_t unit = location->first_bit / location->bits;
    if (unit >= view->count) return false;
    const std::uint32_t stride = std::max(view->width(), width_of(leaves_[begin]));
    const std::uint32_t first = view->base + static_cast<std::uint32_t>(unit) * view->width();
    const auto count = static_cast<std::uint32_t>(end - begin);
    if (count > (view->end() - first) / stride) return false;
    std::vector<bool>& taken = located_taken_[static_cast<std::size_t>(view->table)];
    const auto from = taken.begin() + static_cast<std::ptrdiff_t>(first);
    const auto to = from + static_cast<std::ptrdiff_t>(count * stride);
    // Two variables at one address are two values, unless their bits are one (overlay): the first declared is there.
    if (!overlay_ && std::find(from, to, true) != to) return false;
    std::fill(from, to, true);
    for (std::uint32_t i = 0; i < count; ++i) {
      add_point(leaves_[begin + i], view->table, first + i * stride, runtime::location_text(*location, i), false);
    }
    return true;
  }

  [[nodiscard]] bool accepts_writes(const Leaf& leaf) const {
    const std::string& address = image_.globals[leaf.field].address;
    return !leaf.constant && !address.starts_with("%I") && resource_.globals().writable(leaf.field);
  }

  [[nodiscard]] Table table_of(const Leaf& leaf) const {
    if (leaf.elementary == TypeId::kBool) return accepts_writes(leaf) ? Table::kCoils : Table::kDiscreteInputs;
    return accepts_writes(leaf) ? Table::kHoldingRegisters : Table::kInputRegisters;
  }

  [[nodiscard]] std::string automatic_iec_address(const Leaf& leaf) const {
    const bytecode::ImageField& field = fields()[leaf.field];
    const auto location = location_of(leaf);
    if (location) return runtime::location_text(*location, (leaf.offset - field.offset) / image_.types[leaf.type].size);
    return field.type == leaf.type ? image_.globals[leaf.field].address : std::string{};
  }

  void place_automatic(const std::vector<std::size_t>& unplaced) {
    const std::vector<bool> exported = matching(config_.exported, unplaced);
    std::vector<std::size_t> fresh;
    for (std::size_t i = 0; i < unplaced.size(); ++i) {
      if (!exported[i]) continue;
      const Leaf& leaf = leaves_[unplaced[i]];
      const auto known = known_paths_.find(leaf.path);
      FrozenAddresses::Entry* const entry =
          known == known_paths_.end() ? nullptr : &frozen_.entries.find(known->second)->second;
      if (entry != nullptr && (entry->characters != 0) == (leaf.characters != 0) &&
          registers_of(entry->elementary, entry->characters) == registers_of(leaf.elementary, leaf.characters)) {
        frozen_.changed =
            frozen_.changed || entry->elementary != leaf.elementary || entry->characters != leaf.characters;
        entry->elementary = leaf.elementary;
        entry->characters = leaf.characters;
        add_point(leaf, entry->table, entry->address, automatic_iec_address(leaf), true);
        continue;
      }
      if (entry != nullptr) frozen_.entries.erase(known->second);
      fresh.push_back(unplaced[i]);
    }
    AutomaticArea area;
    for (const auto& [path, entry] : frozen_.entries) {
      if (area.reserve(entry.table, entry.address, width_of(entry))) continue;
      diagnostics_.report(Code::P7502, {}, {},
                          "the frozen address of \"" + path + "\", " + std::string(io::modbus_table_text(entry.table)) +
                              " " + std::to_string(entry.address) +
                              ", is outside the automatic area or belongs to another variable",
                          "delete one of the lines of the lock file");
    }
    // WHY last: where texts are does not move what was mapped before texts were.
    std::stable_partition(fresh.begin(), fresh.end(), [&](std::size_t i) { return leaves_[i].characters == 0; });
    allocate(fresh, area);
  }

  // An array lies in sequence, so that a client reads it in one request.
  void allocate(const std::vector<std::size_t>& fresh, AutomaticArea& area) {
    std::size_t left_out[4] = {};
    const Leaf* first_left_out[4] = {};
    for (std::size_t i = 0; i < fresh.size();) {
      const Leaf& leaf = leaves_[fresh[i]];
      const std::string_view array = without_indices(leaf.path);
      std::size_t end = i + 1;
      while (end < fresh.size() && array.size() != leaf.path.size() && leaves_[fresh[end]].type == leaf.type &&
             without_indices(leaves_[fresh[end]].path) == array) {
        ++end;
      }
      const Table table = table_of(leaf);
      const auto t = static_cast<std::size_t>(table);
      const std::uint32_t width = width_of(leaf);
      const auto count = static_cast<std::uint32_t>(end - i);
      // Texts need no alignment.
      const auto address =
          leaf.characters != 0 ? area.allocate(table, 1, count * width) : area.allocate(table, width, count);
      if (!address) {
        left_out[t] += end - i;
        if (first_left_out[t] == nullptr) first_left_out[t] = &leaf;
      }
      for (std::size_t n = 0; address && n < end - i; ++n) {
        const Leaf& element = leaves_[fresh[i + n]];
        const auto at = static_cast<std::uint16_t>(*address + n * width);
        frozen_.entries[element.path] = {table, at, element.elementary, element.characters};
        frozen_.changed = true;
        add_point(element, table, at, automatic_iec_address(element), true);
      }
      i = end;
    }
    for (std::size_t t = 0; t < 4; ++t) {
      if (left_out[t] == 0) continue;
      diagnostics_.report(Code::P7504, config_.at, {},
                          "no Modbus address is left for " + std::to_string(left_out[t]) +
                              " variables, the first is \"" + first_left_out[t]->path + "\": the automatic area of " +
                              std::string(io::modbus_table_text(static_cast<Table>(t))) + " is full",
                          "name the variables that clients need in [modbus] exported");
    }
  }

  /// Which of the leaves one of the patterns matches, under any of their paths. Warns of patterns that match none.
  std::vector<bool> matching(const std::vector<io::Placed>& patterns, const std::vector<std::size_t>& leaves) {
    std::vector<bool> result(leaves.size());
    const runtime::Access access(resource_);
    for (const io::Placed& pattern : patterns) {
      if (pattern.text.find_first_not_of('*') == std::string::npos) return std::vector<bool>(leaves.size(), true);
      bool any = false;
      for (const std::size_t i : matches(access, pattern.text, leaves)) result[i] = any = true;
      if (any) continue;
      // "Recipe" and "Recipe.*" are what one writes for the elements of an array.
      const std::string wider = pattern.text.substr(0, pattern.text.find_last_not_of(".*") + 1) + "*";
      const bool would_match = wider != "*" && !matches(access, wider, leaves).empty();
      diagnostics_.report(
          Code::P7503, pattern.at, {}, "pattern \"" + pattern.text + "\" matches no variable of the map",
          "plc map shows the paths; '*' stands for any characters, '?' for one, all others for themselves" +
              (would_match ? "; \"" + wider + "\" would match" : std::string{}));
    }
    return result;
  }

  /// Positions in `leaves` of those that one pattern matches.
  [[nodiscard]] std::vector<std::size_t> matches(const runtime::Access& access, const std::string& pattern,
                                                 const std::vector<std::size_t>& leaves) const {
    std::unordered_set<std::uint32_t> offsets;
    for (const runtime::Listed& listed : access.list_places(pattern)) {
      if (listed.place.task == runtime::Place::kGlobal) offsets.insert(listed.place.offset);
    }
    std::vector<std::size_t> found;
    for (std::size_t i = 0; i < leaves.size(); ++i) {
      if (offsets.contains(leaves_[leaves[i]].offset)) found.push_back(i);
    }
    return found;
  }

  /// Half a value has neither rights nor a word order of its own: a range that ends inside of one would be without
  /// effect on it.
  void refuse_split_values() {
    for (const io::ModbusRange& range : config_.ranges) {
      if (!range.writable && !range.word_order) continue;
      const Point* split = nullptr;
      std::size_t count = 0;
      std::uint32_t first = range.first, last = range.last;
      for (const Point& point : points_) {
        const std::uint32_t end = point.address + std::max<std::uint32_t>(point.registers, 1) - 1;
        const bool touches = point.table == range.table && point.address <= range.last && end >= range.first;
        if (!touches || (range.first <= point.address && end <= range.last)) continue;
        if (count++ == 0) split = &point;
        first = std::min<std::uint32_t>(first, point.address);
        last = std::max(last, end);
      }
      if (split == nullptr) continue;
      diagnostics_.report(Code::P7505, range.at, {},
                          "range splits \"" + split->path + "\" (" + std::to_string(split->address) + ".." +
                              std::to_string(split->address + split->registers - 1) + ")" +
                              (count > 1 ? " and " + std::to_string(count - 1) + " more" : std::string{}),
                          "a range holds for whole values: first = " + std::to_string(first) +
                              ", last = " + std::to_string(last) + " has them inside");
    }
  }

  /// Nobody writes a range for nothing.
  void warn_of_ranges_without_effect() {
    for (const io::ModbusRange& range : config_.ranges) {
      const std::string where = std::string(io::modbus_table_text(range.table)) + " " + std::to_string(range.first) +
                                ".." + std::to_string(range.last);
      if (!range.writable && !range.word_order && !range.latch) {
        diagnostics_.report(Code::P7506, range.at, {}, "the range " + where + " says nothing of its addresses",
                            "give it writable, word_order or latch, or take it out");
      } else if (!has_point(range.table, range.first, range.last)) {
        // Manuals and HMIs count holding registers from 40001 on, and likewise the other tables.
        constexpr std::uint32_t kCountedFrom[] = {1, 10001, 30001, 40001};
        const std::uint32_t from = kCountedFrom[static_cast<std::size_t>(range.table)];
        const bool shifted = range.first >= from && has_point(range.table, range.first - from, range.last - from);
        diagnostics_.report(Code::P7506, range.at, {}, "no variable is at " + where,
                            shifted ? "addresses count from 0 here: first = " + std::to_string(range.first - from) +
                                          ", last = " + std::to_string(range.last - from)
                                    : "plc map shows which variable is where");
      }
    }
  }
  [[nodiscard]] bool has_point(Table table, std::uint32_t first, std::uint32_t last) const {
    if (table == Table::kInputRegisters && first < system_end() && last >= kSystemFirst) return true;
    return std::any_of(points_.begin(), points_.end(), [&](const Point& point) {
      const std::uint32_t end = point.address + std::max<std::uint32_t>(point.registers, 1);
      return point.table == table && point.address <= last && end > first;
    });
  }

  void apply_rights() {
    std::unordered_map<std::uint32_t, std::size_t> leaf_at;  // by offset
    for (std::size_t i = 0; i < leaves_.size(); ++i) leaf_at.emplace(leaves_[i].offset, i);
    std::vector<std::size_t> mapped;
    for (const Point& point : points_) mapped.push_back(leaf_at.at(point.offset));
    std::vector<bool> named(points_.size(), true);
    if (!config_.writable.empty()) named = matching(config_.writable, mapped);
    for (std::size_t i = 0; i < points_.size(); ++i) {
      Point& point = points_[i];
      bool writable = named[i];
      for (const io::ModbusRange& range : config_.ranges) {
        if (range.writable && range.table == point.table && range.first <= point.address &&
            point.address <= range.last) {
          writable = *range.writable;
        }
        if (range.latch && range.table == point.table && range.first <= point.address && point.address <= range.last) {
          point.latch = *range.latch;
        }
      }
      point.writable = writable && !config_.read_only && !is_input(point.table) && accepts_writes(leaves_[mapped[i]]);
    }
  }

  runtime::Resource& resource_;
  const Image& image_;
  const io::ModbusConfig& config_;
  FrozenAddresses& frozen_;
  core::Diagnostics& diagnostics_;
  const bool overlay_;
  std::unordered_map<std::string, std::string, core::NameHash, core::NameEqual>
      known_paths_;  // as the lock file spells it
  std::vector<Leaf> leaves_;
  std::vector<Point> points_;
  std::vector<bool> located_taken_[4] = {std::vector<bool>(kAutomaticFirst), std::vector<bool>(kAutomaticFirst),
                                         std::vector<bool>(kAutomaticFirst), std::vector<bool>(kAutomaticFirst)};
};

}  // namespace

std::optional<AddressMap> AddressMap::build(runtime::Resource& resource, const io::ModbusConfig& config,
                                            FrozenAddresses& frozen, core::Diagnostics& diagnostics) {
  const std::size_t errors = diagnostics.error_count();
  Builder builder(resource, config, frozen, diagnostics);
  AddressMap map;
  map.points_ = builder.run();
  if (diagnostics.error_count() != errors) return std::nullopt;
  map.strict_gaps_ = config.strict_gaps;

  // %ID and %IL are an extension of the map: their area is there only when something is in it.
  CellMaker cells;
  for (std::uint32_t i = 0; i < map.points_.size(); ++i) cells.add_point(i, map.points_[i]);
  const auto order_at = [&](Table table, std::uint32_t address) { return builder.order_at(table, address); };
  for (const View& view : kViews) {
    const auto t = static_cast<std::size_t>(view.table);
    const bool has_point = std::any_of(map.points_.begin(), map.points_.end(), [&](const Point& p) {
      return p.table == view.table && view.base <= p.address && p.address < view.end();
    });
    if (view.table == Table::kInputRegisters && view.bits > 16 && !has_point) continue;
    map.areas_[t].push_back({view.base, view.end()});
    builder.each_in_overlay(map.points_, [&](std::uint32_t index, const runtime::Location& location) {
      if (location.area == view.area) cells.add_view(index, location, view, order_at);
    });
  }
  map.cells_ = cells.finish(map.cell_begin_);
  map.areas_[static_cast<std::size_t>(Table::kInputRegisters)].push_back({kSystemFirst, system_end()});
  map.system_order_ = builder.order_at(Table::kInputRegisters, kSystemFirst);
  for (std::size_t t = 0; t < 4; ++t) {
    const auto end = static_cast<std::uint32_t>(map.cell_begin_[t].size() - 1);
    if (end > kAutomaticFirst) map.areas_[t].push_back({kAutomaticFirst, end});
  }
  return map;
}

bool AddressMap::contains(Table table, std::uint16_t address) const {
  const bool system = table == Table::kInputRegisters && kSystemFirst <= address && address < system_end();
  if (strict_gaps_) return system || !at(table, address).empty();
  const std::vector<Area>& areas = areas_[static_cast<std::size_t>(table)];
  return std::any_of(areas.begin(), areas.end(), [&](const Area& a) { return a.first <= address && address < a.end; });
}

}  // namespace plc::modbus
