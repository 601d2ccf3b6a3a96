#include "io-drivers/config/calibration.h"

#include <fmt/format.h>
#include <sys/stat.h>
#include <toml++/toml.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <stdexcept>

#include "core/guess.h"
#include "core/toml_limits.h"
#include "io-drivers/config/findings.h"
#include "stdlib/library.h"

namespace plc::io {
namespace {

using core::Code;
using core::SourceRef;
using runtime::Cost;
using runtime::CostKind;
using runtime::CostTable;

constexpr std::string_view kHelp = "plc calibrate -o FILE makes one for this version on this machine";
/// No cost is a second.
constexpr double kMostNs = 1e9;

using Named = std::map<std::string, double, std::less<>>;

class CalibrationReader {
 public:
  CalibrationReader(std::uint16_t file, Findings& findings) : file_(file), findings_(findings) {}

  CostTable read(const toml::table& root) {
    CostTable costs;
    for (const auto& [key, node] : root) {
      const bool known = key == "machine" || key == "costs" || key == "functions" || key == "blocks";
      if (!known) problem(place(key.source()), fmt::format("\"{}\" is nothing that a calibration has", key.str()));
    }
    const auto* machine = root["machine"].as_string();
    if (machine == nullptr) problem({}, "\"machine\" is missing: the machine that was measured");
    if (machine != nullptr) costs.machine = machine->get();
    if (const toml::table* table = part(root, "costs")) read_kinds(*table, costs);
    if (const toml::table* table = part(root, "functions")) {
      read_named(*table, costs.functions);
      for (const stdlib::Overload& overload : stdlib::overloads())
        expect(costs.functions, stdlib::key_of(overload), *table);
    }
    if (const toml::table* table = part(root, "blocks")) {
      read_named(*table, costs.blocks);
      for (const stdlib::BlockSpec& block : stdlib::blocks()) expect(costs.blocks, std::string(block.name), *table);
    }
    return costs;
  }

 private:
  SourceRef place(const toml::source_region& region) const {
    SourceRef at;
    at.file = file_;
    at.line = region.begin.line;
    at.column = region.begin.column;
    return at;
  }
  void problem(SourceRef at, std::string message) {
    at.file = file_;
    findings_.add(Code::P7607, at, std::move(message), std::string(kHelp));
  }

  const toml::table* part(const toml::table& root, std::string_view name) {
    const toml::node* node = root.get(name);
    const toml::table* table = node == nullptr ? nullptr : node->as_table();
    if (table == nullptr) {
      problem(node == nullptr ? SourceRef{} : place(node->source()), fmt::format("[{}] is missing", name));
    }
    return table;
  }

  /// Nanoseconds, or nothing after a complaint.
  std::optional<double> time(const toml::node& node, std::string_view name) {
    const auto ns = node.value<double>();
    if (ns && std::isfinite(*ns) && *ns >= 0 && *ns <= kMostNs) return ns;
    problem(place(node.source()), fmt::format("\"{}\" is no time from 0 to 1,000,000,000 ns", name));
    return std::nullopt;
  }

  void read_kinds(const toml::table& table, CostTable& costs) {
    for (std::size_t k = 0; k < runtime::kCostKinds; ++k) {
      const auto kind = static_cast<CostKind>(k);
      const std::string_view key = runtime::info(kind).key;
      const toml::node* node = table.get(key);
      const toml::array* pair = node == nullptr ? nullptr : node->as_array();
      if (pair == nullptr || pair->size() != 2) {
        problem(place((node == nullptr ? table : *node).source()),
                fmt::format("\"{}\" is not two times, of the first and of later rounds", key));
        continue;
      }
      const auto first = time(*pair->get(0), key);
      const auto again = time(*pair->get(1), key);
      if (first && again) costs[kind] = {*first, *again};
    }
    for (const auto& [key, node] : table) {
      bool known = false;
      for (std::size_t k = 0; k < runtime::kCostKinds; ++k) {
        known = known || runtime::info(static_cast<CostKind>(k)).key == key.str();
      }
      if (!known) problem(place(key.source()), fmt::format("\"{}\" is no cost of this version", key.str()));
    }
  }

  void read_named(const toml::table& table, Named& to) {
    for (const auto& [key, node] : table) {
      if (const auto ns = time(node, key.str())) to.emplace(key.str(), *ns);
    }
  }

  void expect(const Named& known, const std::string& name, const toml::table& table) {
    if (known.find(name) == known.end() && table.get(name) == nullptr) {
      problem(place(table.source()), fmt::format("\"{}\" is missing: the file is from another version", name));
    }
  }

  std::uint16_t file_;
  Findings& findings_;
};

void append_named(std::string& out, std::string_view title, const Named& named) {
  out += fmt::format("\n[{}]\n", title);
  for (const auto& [name, ns] : named) out += fmt::format("\"{}\" = {:.1f}\n", name, ns);
}

}  // namespace

std::optional<CostTable> read_calibration(std::string_view text, std::string_view file,
                                          core::Diagnostics& diagnostics) {
  SourceRef at;
  at.file = diagnostics.add_file(std::string(file));
  const auto refuse = [&](std::string message) {
    diagnostics.report(Code::P7607, at, {}, std::move(message), std::string(kHelp));
    return std::nullopt;
  };
  if (text.size() > core::kMaxTomlBytes) {
    return refuse(fmt::format("file has more than {} bytes", core::kMaxTomlBytes));
  }
  if (const auto unsafe = core::find_unsafe(text)) {
    at.line = unsafe->line;
    at.column = unsafe->column;
    return refuse("this is not what plc calibrate writes");
  }
  Findings findings;
  try {
    CostTable costs = CalibrationReader(at.file, findings).read(toml::parse(text, file));
    if (findings.size() == 0) return costs;
    findings.report(diagnostics);
    return std::nullopt;
  } catch (const toml::parse_error& error) {
    at.line = error.source().begin.line;
    at.column = error.source().begin.column;
    return refuse(std::string(error.description()));
  }
}

std::optional<CostTable> load_calibration(const std::string& path, const SourceRef& at,
                                          core::Diagnostics& diagnostics) {
  struct stat status {};
  std::ifstream in;
  // A pipe or a device is not opened: that may block, or never come to an end.
  if (::stat(path.c_str(), &status) == 0 && S_ISREG(status.st_mode)) in.open(path, std::ios::binary);
  if (!in.is_open()) {
    diagnostics.report(Code::P7607, at, {}, fmt::format("calibration \"{}\" cannot be opened", path),
                       std::string(kHelp));
    return std::nullopt;
  }
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  return read_calibration(text, path, diagnostics);
}

std::string calibration_text(const CostTable& costs) {
  std::string out =
      "# What the parts of a scan cost, in nanoseconds: plc calibrate. [scheduler] calibration of plc.toml names this "
      "file.\n";
  out += fmt::format("machine = \"{}\"\n", costs.machine);
  out += "\n# The first time in a scan, and in the later rounds of a loop.\n[costs]\n";
  for (std::size_t k = 0; k < runtime::kCostKinds; ++k) {
    const auto kind = static_cast<CostKind>(k);
    const Cost& cost = costs[kind];
    out += fmt::format("{:<12} = [{:.3f}, {:.3f}]  # per {}: {}\n", runtime::info(kind).key, cost.first, cost.again,
                       runtime::info(kind).unit, runtime::info(kind).meaning);
  }
  append_named(out, "functions", costs.functions);
  append_named(out, "blocks", costs.blocks);
  return out;
}

const CostTable& typical_costs() {
  static const CostTable kCosts = [] {
    core::Diagnostics diagnostics;
    auto costs = read_calibration(typical_calibration(), "typical.toml", diagnostics);
    if (!costs) throw std::logic_error("typical.toml was made for another library: plc calibrate, and build again");
    return std::move(*costs);
  }();
  return kCosts;
}

}  // namespace plc::io
