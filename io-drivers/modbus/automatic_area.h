// AutomaticArea: free addresses from 16384 on, in every table.
//
// In: addresses given before. Out: new ones, first fit, aligned. Does not belong here: which variable wants one.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "io-drivers/modbus/address_map.h"

namespace plc::modbus {

class AutomaticArea {
 public:
  /// Takes `width` addresses from `first` on. False, and unchanged, when one of them is taken or outside the area.
  bool reserve(Table table, std::uint32_t first, std::uint32_t width);
  /// `count` values in sequence, `width` addresses each, aligned to `width`. Nothing when there is no room.
  std::optional<std::uint16_t> allocate(Table table, std::uint32_t width, std::uint32_t count);

 private:
  static constexpr std::uint32_t kEnd = 65536;
  [[nodiscard]] bool is_free(const std::vector<bool>& taken, std::uint32_t first, std::uint32_t width) const;
  struct Addresses {
    std::vector<bool> taken = std::vector<bool>(kEnd - kAutomaticFirst);
    std::uint32_t search_from[3] = {kAutomaticFirst, kAutomaticFirst, kAutomaticFirst};  // nothing free below, by width
  };
  Addresses tables_[4];
};

}  // namespace plc::modbus
