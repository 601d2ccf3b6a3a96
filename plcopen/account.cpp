#include "plcopen/account.h"

#include <array>
#include <utility>

namespace plc::plcopen {

namespace {

constexpr std::string_view kStateTitles[] = {
#define PLC_STATE(Name, title) title,
    PLC_READER_STATES(PLC_STATE)
#undef PLC_STATE
};

constexpr std::size_t kStateCount = std::size(kStateTitles);

const std::vector<const Rule*>& rules_of(State parent) {
  static const auto kByState = [] {
    std::array<std::vector<const Rule*>, kStateCount> by_state;
    for (const Rule& rule : all_rules()) by_state[static_cast<std::size_t>(rule.parent)].push_back(&rule);
    return by_state;
  }();
  return kByState[static_cast<std::size_t>(parent)];
}

const Rule* find_rule(State parent, std::string_view name, std::string_view variant) {
  const Rule* plain = nullptr;
  const Rule* any = nullptr;
  for (const Rule* rule : rules_of(parent)) {
    if (rule->name == "*") any = rule;
    if (rule->name != name) continue;
    if (rule->variant.empty()) {
      plain = rule;
    } else if (rule->variant.front() == '/' ? variant.ends_with(rule->variant) : variant == rule->variant) {
      return rule;
    }
  }
  return plain != nullptr ? plain : any;
}

}  // namespace

std::string_view state_title(State state) { return kStateTitles[static_cast<std::size_t>(state)]; }

const std::vector<Rule>& all_rules() {
  static const std::vector<Rule> kAll = [] {
    std::vector<Rule> all;
    for (const auto rules :
         {project_rules(), type_rules(), pou_rules(), body_rules(), chart_rules(), configuration_rules(),
          vendor_rules(), misplaced_rules(), iec10_rules(), iec10_body_rules()}) {
      all.insert(all.end(), rules.begin(), rules.end());
    }
    return all;
  }();
  return kAll;
}

Account::Account() : slots_(4 * kMaxNodes) {
  nodes_.reserve(64);
  Node root;
  root.state = State::kDocument;
  root.fate = Fate::kUsed;
  nodes_.push_back(std::move(root));
}

Account::NodeId Account::enter(NodeId parent, const char* name, std::string_view variant, std::uint32_t line) {
  const std::size_t mask = slots_.size() - 1;
  std::size_t i =
      ((reinterpret_cast<std::uintptr_t>(name) >> 3) * 0x9E3779B1u + parent * std::size_t{0x85EBCA77u}) & mask;
  while (slots_[i].name != nullptr && (slots_[i].name != name || slots_[i].parent != parent)) i = (i + 1) & mask;
  NodeId id = slots_[i].child;
  if (slots_[i].name == nullptr) {
    id = make(parent, name, {});
    // A full table would make the probe above run for ever; what does not fit any more is looked up again each time.
    if (used_slots_ < slots_.size() / 2) {
      slots_[i] = {name, parent, id};
      ++used_slots_;
    }
  }
  if (!variant.empty()) id = variant_of(id, parent, name, variant);
  ReportRow& row = rows_[nodes_[id].row];
  if (row.count++ == 0) row.first_line = line;
  return id;
}

Account::NodeId Account::variant_of(NodeId base, NodeId parent, const char* name, std::string_view variant) {
  if (nodes_[base].variants.size() >= kMaxVariants) {
    // From here on only the variants that mean something are told apart.
    const Rule* rule = find_rule(nodes_[parent].state, name, variant);
    if (rule == nodes_[base].rule) return base;
    variant = rule->variant;
  }
  for (const NodeId id : nodes_[base].variants) {
    if (nodes_[id].variant == variant) return id;
  }
  const NodeId id = make(parent, name, variant);
  if (nodes_[id].variant == variant) nodes_[base].variants.push_back(id);
  return id;
}

Account::NodeId Account::make(NodeId parent, std::string_view name, std::string_view variant) {
  const State state = nodes_[parent].state;
  const Rule* rule = find_rule(state, name, variant);
  Node node;
  node.rule = rule;
  node.variant = variant;
  std::string_view reason = "unknown element";
  if (rule != nullptr) {
    node.state = rule->state;
    node.fate = rule->inherit ? nodes_[parent].fate : rule->fate;
    reason = rule->inherit ? std::string_view(rows_[nodes_[parent].row].reason) : rule->reason;
  }
  std::string path;
  if (nodes_.size() >= kMaxNodes) {
    path = "(other elements)";
    // One node per rule is enough to go on reading correctly; the account no longer tells the places apart.
    for (auto id = static_cast<NodeId>(kMaxNodes); id < nodes_.size(); ++id) {
      if (nodes_[id].rule == rule && nodes_[id].fate == node.fate) return id;
    }
    reason = "too many kinds of elements to list";
  } else if ((rule != nullptr && rule->anchor) || parent == kRoot) {
    path = name;
  } else {
    path = rows_[nodes_[parent].row].element;
    if (path.size() < kMaxPath) {
      path += '/';
      path += name.substr(0, kMaxPath);
      if (!variant.empty()) path += '[' + std::string(variant.substr(0, kMaxPath)) + ']';
    }
  }
  node.row = row_for(std::move(path), node.fate, reason);
  nodes_.push_back(std::move(node));
  return static_cast<NodeId>(nodes_.size() - 1);
}

std::vector<ReportRow> Account::take_rows() {
  std::erase_if(rows_, [](const ReportRow& row) { return row.count == 0; });
  return std::move(rows_);
}

std::uint32_t Account::row_for(std::string path, Fate fate, std::string_view reason) {
  const std::string key = path + '\n' + std::to_string(static_cast<int>(fate));
  const auto [it, added] = rows_by_path_.try_emplace(key, static_cast<std::uint32_t>(rows_.size()));
  if (added) {
    ReportRow row;
    row.element = std::move(path);
    row.fate = fate;
    row.reason = reason;
    rows_.push_back(std::move(row));
  }
  return it->second;
}

}  // namespace plc::plcopen
