// The lock file: reading and writing of automatic addresses given before.
#include <algorithm>
#include <array>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <tuple>
#include <unordered_map>

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

/// "DINT", or "STRING[80]" with its characters.
std::optional<std::pair<core::TypeId, std::uint16_t>> type_of(std::string_view text) {
  const std::size_t bracket = std::min(text.find('['), text.size());
  const auto type = core::type_named(text.substr(0, bracket));
  if (!type) return std::nullopt;
  const core::Rep rep = core::rep_of(*type);
  const bool is_text = rep == core::Rep::kStr || rep == core::Rep::kWstr;
  if (is_text == (bracket == text.size())) return std::nullopt;
  std::uint16_t characters = 0;
  if (!is_text) return std::pair(*type, characters);
  const char* const end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data() + bracket + 1, end, characters);
  if (error != std::errc{} || std::string_view(rest, end) != "]" || characters == 0) return std::nullopt;
  return std::pair(*type, characters);
}

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
    const auto type = type_of(row[3].text);
    if (!type) return problem(Code::P7501, row, "\"" + row[3].text + "\" is no type of a single value");
    if ((type->first == core::TypeId::kBool) != is_bit_table(*table)) {
      return problem(Code::P7501, row, row[3].text + " in " + row[1].text);
    }
    const std::string& text = row[2].text;
    std::uint32_t address = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), address);
    const std::uint32_t width = is_bit_table(*table) ? 1 : registers_of(type->first, type->second);
    if (error != std::errc{} || end != text.data() + text.size() || address < kAutomaticFirst ||
        address + width > 65536) {
      return problem(Code::P7501, row, "\"" + text + "\" is no address from 16384 to " + std::to_string(65536 - width));
    }
    return add(row, {*table, static_cast<std::uint16_t>(address), type->first, type->second}, width);
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

core::Result<FrozenAddresses> parse(const std::string& text, const std::string& name) {
  const auto rows = io::parse_csv(text, name);
  if (!rows) return Problem{Code::P7501, rows.error().message, rows.error().help};
  Reader reader(name);
  if (auto wrong = reader.read(*rows)) return *wrong;
  return std::move(reader.result);
}

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
  return parse({std::istreambuf_iterator<char>(in), {}}, path);
}

core::Result<FrozenAddresses> read_frozen(const std::string& path, const bytecode::Image& image) {
  auto of_file = read_frozen(path);
  if (!of_file || image.frozen_addresses.empty()) return of_file;
  auto of_image = parse(image.frozen_addresses, "frozen addresses of the image");
  if (!of_image) return of_image;
  std::unordered_map<std::string, const FrozenAddresses::Entry*, core::NameHash, core::NameEqual> known;
  for (const auto& [name, entry] : of_image->entries) known.emplace(name, &entry);
  for (const auto& [name, entry] : of_file->entries) {
    const auto other = known.find(name);
    if (other == known.end()) continue;
    const FrozenAddresses::Entry& compiled = *other->second;
    if (compiled.table == entry.table && compiled.address == entry.address) continue;
    const auto place = [](const FrozenAddresses::Entry& e) {
      return std::string(io::modbus_table_text(e.table)) + " " + std::to_string(e.address);
    };
    return Problem{
        Code::P7507,
        path + ": \"" + name + "\" is at " + place(entry) + ", and the image was compiled with " + place(compiled),
        "compile the project again beside this file, or take the file away: the image has its addresses"};
  }
  for (auto& [name, entry] : of_file->entries) {
    if (known.find(name) == known.end()) of_image->entries.emplace(name, entry);
  }
  return of_image;
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
    if (entry->characters != 0) text += '[' + std::to_string(entry->characters) + ']';
    text += '\n';
  }
  return text;
}

}  // namespace plc::modbus
