// An address map of a hand-made image, and what a register shows of a value.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "io-drivers/modbus/address_map.h"
#include "runtime/resource.h"
#include "tests/support/image_builder.h"

namespace plc::test {

using io::WordOrder;
using modbus::AddressMap;
using modbus::Cell;
using modbus::FrozenAddresses;
using modbus::Point;
using modbus::Table;

/// Globals, a task that exports them, and the map of it all.
struct MapFixture {
  ImageBuilder b;
  io::ModbusConfig config;
  FrozenAddresses frozen;
  core::Diagnostics diagnostics;
  std::unique_ptr<runtime::Resource> resource;
  std::optional<AddressMap> map;

  MapFixture() { diagnostics.add_file("plc.toml"); }

  void variable(const std::string& name, TypeId type, const std::string& address = {}) {
    b.global(name, b.type(type), {}, {.input = address.starts_with("%I"), .address = address});
  }
  void array(const std::string& name, TypeId type, std::uint32_t count, const std::string& address = {}) {
    b.global(name, b.array(b.type(type), count), {}, {.input = address.starts_with("%I"), .address = address});
  }

  void load() {
    PouBuilder main = b.pou("Main", PouKind::kProgram);
    b.task("Cyclic", 10'000'000, {main.finish()});
    core::Diagnostics problems;
    auto verified = bytecode::verify(b.build(), problems);
    ASSERT_TRUE(verified.has_value());
    auto loaded = runtime::Resource::load(std::move(*verified));
    ASSERT_TRUE(loaded.has_value());
    resource = std::move(*loaded);
  }
  /// Builds the map; the second time of the same resource.
  void build() {
    if (!resource) load();
    map = AddressMap::build(*resource, config, frozen, diagnostics);
  }

  [[nodiscard]] const Point* point(const std::string& path) const {
    if (!map) return nullptr;
    const auto found =
        std::find_if(map->points().begin(), map->points().end(), [&](const Point& p) { return p.path == path; });
    return found == map->points().end() ? nullptr : &*found;
  }
  /// "holding-registers 1024", with "*" after automatic ones; "none" for a variable that is not in the map.
  [[nodiscard]] std::string place(const std::string& path) const {
    const Point* const p = point(path);
    if (p == nullptr) return "none";
    return std::string(io::modbus_table_text(p->table)) + " " + std::to_string(p->address) + (p->automatic ? "*" : "");
  }
  /// The cells of an address as "Path:value_bit+bits@cell_bit ..".
  [[nodiscard]] std::string cells(Table table, std::uint16_t address) const {
    std::string text;
    for (const Cell& cell : map->at(table, address)) {
      if (!text.empty()) text += ' ';
      text += map->points()[cell.point].path + ":" + std::to_string(cell.value_bit) + "+" + std::to_string(cell.bits) +
              "@" + std::to_string(cell.cell_bit);
    }
    return text;
  }
  [[nodiscard]] std::string said() const {
    std::ostringstream text;
    diagnostics.render(text);
    return text.str();
  }
};

}  // namespace plc::test
