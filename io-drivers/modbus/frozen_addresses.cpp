// The lock file: reading and writing of automatic addresses given before.
#include <algorithm>
#include <array>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <tuple>

#include "core/text.h"
#include "io-drivers/csv.h"
#include "io-drivers/modbus/address_map.h"

namespace plc::modbus {
namespace {

using core::Code;
using core::Problem;

constexpr std::array<std::string_view, 4> kHeader = {"path", "table", "address", "type"};

std::optional<Table> table_named(std::string_view text) {
  for (const Table table : {Table::kCoils, Table::kDiscreteInputs, Table::kInputRegisters, Table::kHoldingRegisters}) {
    if (io::modbus_table_text(table) == text) return table;
  }
  return std::nullopt;
}

bool is_bit_table(Table table) { return table == Table::kCoils || table == Table::kDiscreteInputs; }

class Reader {
 public:
  explicit Reader(const std::string& file) : file_(file) {}

  std::optional<Problem> read(const std::vector<io::CsvRow>& rows) {
    if (rows.empty()) return std::nullopt;
    bool header = rows[0].size() == kHeader.size();
    for (std::size_t i = 0; header && i < kHeader.size(); ++i) header = rows[0][i].text == kHeader[i];
    if (!header) return problem(Code::P7501, rows[0], "the first row is not path,table,address,type");
    for (std::size_t i = 1; i < rows.size(); ++i) {
      if (auto wrong = read_row(rows[i])) return wrong;
    }
    return std::nullopt;
  }
  FrozenAddresses result;

 private:
  [[nodiscard]] Problem problem(Code code, const io::CsvRow& row, const std::string& message) const {
    return {code, file_ + ":" + std::to_string(row[0].line) + ": " + message,
            code == Code::P7502
                ? "delete one of the two lines, then run plc map --freeze"
                : "write rows like Recipe.Time,holding-registers,16384,DINT, or let plc map --freeze make the file"};
  }

  std::optional<Problem> read_row(const io::CsvRow& row) {
    if (row.size() != kHeader.size()) {
      return problem(Code::P7501, row, std::to_string(row.size()) + " cells in a row, not 4");
    }
    const std::string& path = row[0].text;
    if (path.empty()) return problem(Code::P7501, row, "no path");
    const auto table = table_named(row[1].text);
    if (!table) return problem(Code::P7501, row, "\"" + row[1].text + "\" is no table");
    const auto type = core::type_named(row[3].text);
    if (!type || core::in_category(*type, core::kAnyString)) {
      return problem(Code::P7501, row, "\"" + row[3].text + "\" is no type of a single value");
    }
    if ((*type == core::TypeId::kBool) != is_bit_table(*table)) {
      return problem(Code::P7501, row, row[3].text + " in " + row[1].text);
    }
    const std::string& text = row[2].text;
    std::uint32_t address = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), address);
    const std::uint32_t width = is_bit_table(*table) ? 1 : (core::rep_bytes(core::rep_of(*type)) + 1) / 2;
    if (error != std::errc{} || end != text.data() + text.size() || address < kAutomaticFirst ||
        address + width > 65536) {
      return problem(Code::P7501, row, "\"" + text + "\" is no address from 16384 to " + std::to_string(65536 - width));
    }
    return add(row, {*table, static_cast<std::uint16_t>(address), *type}, width);
  }

  std::optional<Problem> add(const io::CsvRow& row, const FrozenAddresses::Entry& entry, std::uint32_t width) {
    const std::string& path = row[0].text;
    if (const auto [other, fresh] = lines_.emplace(core::folded(path), row[0].line); !fresh) {
      return problem(Code::P7502, row,
                     "\"" + path + "\" has an address already, in line " + std::to_string(other->second));
    }
    for (std::uint32_t i = 0; i < width; ++i) {
      const auto [other, fresh] = owners_.emplace(std::pair(entry.table, entry.address + i), &row);
      if (fresh) continue;
      return problem(Code::P7502, row,
                     std::string(io::modbus_table_text(entry.table)) + " " + std::to_string(entry.address + i) +
                         " of \"" + path + "\" belongs to \"" + (*other->second)[0].text + "\" in line " +
                         std::to_string((*other->second)[0].line));
    }
    result.entries.emplace(path, entry);
    return std::nullopt;
  }

  const std::string& file_;
  std::map<std::string, std::uint32_t> lines_;                           // by path, folded
  std::map<std::pair<Table, std::uint32_t>, const io::CsvRow*> owners_;  // of every address
};

}  // namespace

std::string lock_file_of(const io::Configuration& configuration, const std::string& project) {
  namespace fs = std::filesystem;
  const std::string& own = configuration.modbus.lock_file.text;
  if (!own.empty()) return (fs::path(configuration.file).parent_path() / own).string();
  return fs::path(project).replace_extension(".modbus.csv").string();
}

core::Result<FrozenAddresses> read_frozen(const std::string& path) {
  std::error_code unknown;
  const auto status = std::filesystem::status(path, unknown);
  if (status.type() == std::filesystem::file_type::not_found) return FrozenAddresses{};
  std::ifstream in;
  if (std::filesystem::is_regular_file(status)) in.open(path, std::ios::binary);
  if (!in.is_open()) {
    return Problem{Code::P7001, path + ": lock file cannot be opened for reading",
                   "see [modbus] lock_file in plc.toml"};
  }
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  const auto rows = io::parse_csv(text, path);
  if (!rows) return Problem{Code::P7501, rows.error().message, rows.error().help};
  Reader reader(path);
  if (auto wrong = reader.read(*rows)) return *wrong;
  return std::move(reader.result);
}

std::string frozen_text(const FrozenAddresses& frozen) {
  std::vector<std::pair<const std::string*, const FrozenAddresses::Entry*>> rows;
  for (const auto& [path, entry] : frozen.entries) rows.emplace_back(&path, &entry);
  std::sort(rows.begin(), rows.end(), [](const auto& a, const auto& b) {
    return std::tie(a.second->table, a.second->address) < std::tie(b.second->table, b.second->address);
  });
  std::string text =
      "# Modbus addresses given to variables without one in the program, kept by plc map --freeze: commit this file.\n"
      "# A variable without a line gets the next free address. Lines of variables that are gone keep their address "
      "taken.\n"
      "path,table,address,type\n";
  for (const auto& [path, entry] : rows) {
    io::append_csv(text, *path);
    text += ',';
    text += io::modbus_table_text(entry->table);
    text += ',' + std::to_string(entry->address) + ',';
    text += core::name_of(entry->elementary);
    text += '\n';
  }
  return text;
}

}  // namespace plc::modbus
