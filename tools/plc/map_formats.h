// The Modbus map of a project as text: for people, for scripts, and as the import files of HMIs
// (docs/guides/modbus.md).
//
// In: AddressMap with the image it was built from, host and port for the HMIs. Out: the file's text, and what an HMI
// has no type for. Does not belong here: files, command lines.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_set>
#include <vector>

#include "bytecode/image.h"
#include "io-drivers/modbus/address_map.h"
#include "taskblocks/registry.h"

namespace plc::tools {

struct MapSource {
  const modbus::AddressMap& map;
  const bytecode::Image& image;
  const taskblocks::Registry& taskblocks;  ///< says what ports of global instances mean
  std::string name;                        ///< of the project
  std::string host;                        ///< IPv6 without brackets
  std::uint16_t port = 502;
  std::uint8_t unit_id = 1;
};

struct MapText {
  std::string text;
  std::vector<std::string> left_out;  ///< paths of variables that the format has no type for
};

struct MapFormat {
  std::string_view name;  ///< as after --format
  MapText (*write)(const MapSource&);
  bool names_host = false;  ///< the text says where the server is
};

MapText map_as_table(const MapSource& source);
/// One row a variable: name, type, iec_address, modbus_table, address0 (as sent), address1 (from 1), registers (0 = a
/// bit), bit, word_order, access (r, rw), min, max, comment (members of an enumeration; meaning and unit of a port).
MapText map_as_csv(const MapSource& source);
/// The same as JSON, with where to connect to, and the unit of a port beside its meaning.
MapText map_as_json(const MapSource& source);
/// An array of one device, for FUXA's Connections -> Import and its API.
MapText map_as_fuxa(const MapSource& source);
/// A flow for node-red-contrib-modbus: reads everything in few requests, writes by name.
MapText map_as_nodered(const MapSource& source);
/// A data source with its points, for Scada-LTS's import.
MapText map_as_scadalts(const MapSource& source);
/// A folder of OPC tags on a Modbus TCP device of Ignition that is called as the project; addresses from 1.
MapText map_as_ignition(const MapSource& source);

inline constexpr std::array<MapFormat, 7> kMapFormats = {{{"table", map_as_table},
                                                          {"csv", map_as_csv},
                                                          {"json", map_as_json, true},
                                                          {"fuxa", map_as_fuxa, true},
                                                          {"nodered", map_as_nodered, true},
                                                          {"scadalts", map_as_scadalts, true},
                                                          {"ignition", map_as_ignition}}};

/// What a client has to know of a value: how it is coded, not what it is called in the program.
enum class Coding : std::uint8_t { kBit, kI16, kU16, kI32, kU32, kF32, kI64, kU64, kF64, kText };
Coding coding_of(const modbus::Point& point);

/// Makes names that begin with a letter and hold letters, digits and '_' only, each once.
class PlainNames {
 public:
  std::string operator()(std::string_view path);

 private:
  std::unordered_set<std::string> used_;
};

}  // namespace plc::tools
