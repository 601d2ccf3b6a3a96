#include "runtime/packed_logic.h"

#include <algorithm>
#include <utility>

namespace plc::runtime {
namespace {

using Values = std::vector<std::uint32_t>;

bool holds(const Values& values, std::uint32_t value) {
  return std::find(values.begin(), values.end(), value) != values.end();
}
void add(Values& values, std::uint32_t value) {
  if (!holds(values, value)) values.push_back(value);
}

/// `result` of each index over so many inputs, as a truth table.
template <class Result>
std::uint64_t table_of(std::size_t inputs, Result result) {
  std::uint64_t table = 0;
  for (std::uint32_t index = 0; index < 1u << inputs; ++index) table |= std::uint64_t{result(index) & 1u} << index;
  return table;
}
/// What a value is, as the index says, over `inputs`.
std::uint32_t input_at(const Values& inputs, std::uint32_t value, std::uint32_t index) {
  return index >> (std::find(inputs.begin(), inputs.end(), value) - inputs.begin()) & 1u;
}
/// What the record computes there.
std::uint32_t result_at(const PackedNode& record, const Values& inputs, std::uint32_t index) {
  std::uint32_t own = 0;
  for (std::size_t k = 0; k < record.in.size(); ++k) own |= input_at(inputs, record.in[k], index) << k;
  return static_cast<std::uint32_t>(record.truth >> own) & 1u;
}

/// Each input once, and only those that the result depends on.
void reduce(PackedNode& record) {
  const auto keep = [&record](Values inputs) {
    record.truth = truth_over(record, inputs);
    record.in = std::move(inputs);
  };
  Values once;
  for (const std::uint32_t value : record.in) add(once, value);
  keep(std::move(once));
  for (std::size_t k = record.in.size(); k-- > 0;) {
    const std::uint32_t apart = 1u << k;
    const auto differs = [&](std::uint32_t index) { return record.truth >> index ^ record.truth >> (index ^ apart); };
    if (table_of(record.in.size(), [&](std::uint32_t i) { return static_cast<std::uint32_t>(differs(i)); }) != 0) {
      continue;
    }
    Values others = record.in;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(k));
    keep(std::move(others));
  }
}

}  // namespace

std::uint64_t truth_over(const PackedNode& record, const Values& inputs) {
  return table_of(inputs.size(), [&](std::uint32_t index) { return result_at(record, inputs, index); });
}

PackedLogic::PackedLogic(std::span<const StretchItem> items, std::span<const std::uint32_t> places) {
  for (const std::uint32_t place : places) cells_.push_back({place});
  Values now(cells_.size(), kNoNumber);
  const auto new_value = [&](std::uint32_t cell, std::uint32_t writer, bool logic) {
    values_.push_back({cell, writer, logic});
    now[cell] = static_cast<std::uint32_t>(values_.size() - 1);
    return now[cell];
  };
  for (std::uint32_t i = 0; i < items.size(); ++i) {
    const StretchItem& item = items[i];
    PackedNode node;
    node.logic = item.logic;
    node.truth = item.truth;
    for (const std::uint32_t cell : item.reads) {
      const std::uint32_t value = now[cell] != kNoNumber ? now[cell] : new_value(cell, kNoNumber, false);
      node.in.push_back(value);
      if (item.logic) {
        cells_[cell].logic = true;
      } else {
        values_[value].read_by_other = true;
      }
    }
    if (item.logic) reduce(node);
    for (const std::uint32_t value : node.in) values_[value].readers += item.logic ? 1 : 0;
    for (const std::uint32_t cell : item.writes) {
      node.out.push_back(new_value(cell, i, item.logic));
      if (!item.logic) continue;
      cells_[cell].logic = true;
      cells_[cell].logic_writes = true;
    }
    nodes_.push_back(std::move(node));
  }
  for (std::size_t c = 0; c < cells_.size(); ++c) cells_[c].last = now[c];
}

/// Visits each record that is left, with what tells whether all that the writer of a value reads is still what it was.
template <class Visit>
void PackedLogic::for_records(Visit visit) {
  Values now(cells_.size(), kNoNumber);
  const auto can_be_computed = [&](std::uint32_t result) {
    const PackedNode& from = writer_of(result);
    return std::all_of(from.in.begin(), from.in.end(), [&](std::uint32_t value) {
      const std::uint32_t current = now[values_[value].cell];
      return current == kNoNumber ? values_[value].writer == kNoNumber : current == value;
    });
  };
  for (PackedNode& node : nodes_) {
    if (node.logic && !node.gone) visit(node, can_be_computed);
    for (const std::uint32_t out : node.out) now[values_[out].cell] = out;
  }
}

bool PackedLogic::is_needed(std::uint32_t value) const {
  return values_[value].readers != 0 || values_[value].read_by_other || is_last(value);
}
void PackedLogic::remove(PackedNode& node) {
  node.gone = true;
  for (const std::uint32_t value : node.in) --values_[value].readers;
}

void PackedLogic::join_records() {
  for_records([&](PackedNode& node, const auto& can_be_computed) {
    for (std::size_t k = 0; k < node.in.size();) {
      const std::uint32_t value = node.in[k];
      const PackedValue& v = values_[value];
      const bool alone = v.logic && v.readers == 1 && !v.read_by_other && !is_last(value);
      k = alone && can_be_computed(value) && join(node, {value}) ? 0 : k + 1;
    }
  });
  // Whatever nobody reads: from the last one on.
  for (auto node = nodes_.rbegin(); node != nodes_.rend(); ++node) {
    if (node->logic && !node->gone && !is_needed(node->out[0])) remove(*node);
  }
}

bool PackedLogic::shorten_ways() {
  std::vector<std::uint32_t> depths(values_.size(), 0);  // records up to a value, one behind the other
  bool changed = false;
  for_records([&](PackedNode& node, const auto& can_be_computed) {
    const auto depth = [&] {
      std::uint32_t most = 0;
      for (const std::uint32_t value : node.in) most = std::max(most, depths[value]);
      return most;
    };
    const auto join_deepest = [&] {
      Values deepest;
      for (const std::uint32_t value : node.in) {
        if (depths[value] == depth()) deepest.push_back(value);
      }
      return std::all_of(deepest.begin(), deepest.end(), can_be_computed) && join(node, deepest);
    };
    while (depth() != 0 && join_deepest()) changed = true;
    depths[node.out[0]] = depth() + 1;
  });
  return changed;
}

/// The reader computes those of its inputs itself, which are results of other records. False, and nothing has happened,
/// if that takes too many inputs.
bool PackedLogic::join(PackedNode& reader, const Values& joined) {
  Values inputs;
  for (const std::uint32_t value : reader.in) {
    if (!holds(joined, value)) add(inputs, value);
  }
  for (const std::uint32_t value : joined) {
    for (const std::uint32_t in : writer_of(value).in) add(inputs, in);
  }
  if (inputs.size() > kMostPackedInputs) return false;
  for (const std::uint32_t value : reader.in) --values_[value].readers;
  reader.truth = table_of(inputs.size(), [&](std::uint32_t index) {
    std::uint32_t own = 0;
    for (std::size_t k = 0; k < reader.in.size(); ++k) {
      const std::uint32_t value = reader.in[k];
      own |= (holds(joined, value) ? result_at(writer_of(value), inputs, index) : input_at(inputs, value, index)) << k;
    }
    return static_cast<std::uint32_t>(reader.truth >> own);
  });
  reader.in = std::move(inputs);
  reduce(reader);
  for (const std::uint32_t value : reader.in) ++values_[value].readers;
  for (const std::uint32_t value : joined) {
    if (!is_needed(value)) remove(nodes_[values_[value].writer]);
  }
  return true;
}

}  // namespace plc::runtime
