#include "bytecode/codegen/boolean_map.h"

#include <algorithm>
#include <cstddef>

namespace plc::bytecode {
namespace {

/// Truth table of input k alone.
constexpr std::array<std::uint32_t, kRecordInputs> kInput{0xaaaaaaaau, 0xccccccccu, 0xf0f0f0f0u, 0xff00ff00u,
                                                          0xffff0000u};
/// A negated AND is spread into an OR around it (and the reverse) only up to this length: spreading touches every
/// piece, and a chain of alternating negations would touch each of them again and again.
constexpr std::uint32_t kMaxSpread = 16;
/// Bins tried for a piece. More find little and would make wide operations quadratic.
constexpr std::size_t kOpenBins = 8;

std::uint32_t apply(Logic op, std::uint32_t a, std::uint32_t b) {
  return op == Logic::kAnd ? a & b : op == Logic::kOr ? a | b : a ^ b;
}

/// `table` with input k moved to input to[k].
std::uint32_t moved(std::uint32_t table, std::uint32_t count, const std::array<std::uint32_t, kRecordInputs>& to) {
  if (count == 0) return table;
  if (count == 1) return table == kInput[0] ? kInput[to[0]] : table == ~kInput[0] ? ~kInput[to[0]] : table;
  std::uint32_t out = 0;
  for (std::uint32_t row = 0; row < 32; ++row) {
    std::uint32_t from = 0;
    for (std::uint32_t k = 0; k < count; ++k) from |= ((row >> to[k]) & 1u) << k;
    out |= ((table >> from) & 1u) << row;
  }
  return out;
}

}  // namespace

Piece leaf_piece(std::uint32_t word, bool inverted) {
  Piece piece;
  piece.leaf[0] = word;
  piece.count = 1;
  piece.table = inverted ? ~kInput[0] : kInput[0];
  return piece;
}

bool merge(Piece& a, const Piece& b, Logic op) {
  std::array<std::uint32_t, kRecordInputs> to{};
  std::array<std::uint32_t, kRecordInputs> leaves = a.leaf;
  std::uint32_t count = a.count;
  for (std::uint32_t k = 0; k < b.count; ++k) {
    const auto end = leaves.begin() + count;
    const auto known = std::find(leaves.begin(), end, b.leaf[k]);
    if (known == end) {
      if (count == kRecordInputs) return false;
      leaves[count++] = b.leaf[k];
    }
    to[k] = static_cast<std::uint32_t>(known - leaves.begin());
  }
  a.table = apply(op, a.table, moved(b.table, b.count, to));
  a.leaf = leaves;
  a.count = count;
  return true;
}

ConeArena::Id ConeArena::new_cone(Logic op) {
  Id id = 0;
  if (free_cones_.empty()) {
    id = static_cast<Id>(cones_.size());
    cones_.emplace_back();
  } else {
    id = free_cones_.back();
    free_cones_.pop_back();
    cones_[id] = Cone{};
  }
  cones_[id].op = op;
  return id;
}

void ConeArena::append(Id cone, const Piece& piece) {
  std::uint32_t node = free_nodes_;
  if (node == kNone) {
    node = static_cast<std::uint32_t>(nodes_.size());
    nodes_.emplace_back();
  } else {
    free_nodes_ = nodes_[node].next;
  }
  nodes_[node] = {piece, kNone};
  Cone& c = cones_[cone];
  if (c.tail == kNone) {
    c.head = node;
  } else {
    nodes_[c.tail].next = node;
  }
  c.tail = node;
  ++c.count;
}

void ConeArena::splice(Id to, Id from) {
  Cone& t = cones_[to];
  const Cone f = cones_[from];
  free_cones_.push_back(from);
  if (f.head == kNone) return;
  if (t.tail == kNone) {
    t.head = f.head;
  } else {
    nodes_[t.tail].next = f.head;
  }
  t.tail = f.tail;
  t.count += f.count;
}

void ConeArena::absorb(Id cone, const Operand& operand, RecordSink& sink) {
  if (operand.cone == kNone) {
    append(cone, operand.inverted ? inverted_piece(operand.piece) : operand.piece);
    return;
  }
  const Logic op = cones_[cone].op;
  const Cone& from = cones_[operand.cone];
  if (from.op == op && (!operand.inverted || op == Logic::kXor)) {
    if (operand.inverted) nodes_[from.head].piece.table = ~nodes_[from.head].piece.table;
    splice(cone, operand.cone);
    return;
  }
  const bool dual = from.op != op && from.op != Logic::kXor && op != Logic::kXor;
  if (operand.inverted && dual && from.count <= kMaxSpread) {
    // De Morgan: NOT (a AND b) = NOT a OR NOT b.
    for (std::uint32_t n = from.head; n != kNone; n = nodes_[n].next) nodes_[n].piece.table = ~nodes_[n].piece.table;
    splice(cone, operand.cone);
    return;
  }
  const Piece piece = close(operand.cone, sink);
  append(cone, operand.inverted ? inverted_piece(piece) : piece);
}

ConeArena::Id ConeArena::combine(Logic op, const Operand& a, const Operand& b, RecordSink& sink) {
  // Splicing into the longer chain would be no cheaper: both ends are known.
  const Id cone = new_cone(op);
  absorb(cone, a, sink);
  absorb(cone, b, sink);
  return cone;
}

ConeArena::Id ConeArena::copy(Id cone) {
  const Id made = new_cone(cones_[cone].op);
  for (std::uint32_t n = cones_[cone].head; n != kNone; n = nodes_[n].next) {
    const Piece piece = nodes_[n].piece;
    append(made, piece);
  }
  return made;
}

Piece ConeArena::close(Id cone, RecordSink& sink) {
  const Cone c = cones_[cone];
  free_cones_.push_back(cone);
  scratch_.clear();
  for (std::uint32_t n = c.head; n != kNone;) {
    scratch_.push_back(nodes_[n].piece);
    const std::uint32_t next = nodes_[n].next;
    nodes_[n].next = free_nodes_;
    free_nodes_ = n;
    n = next;
  }
  const auto larger = [](const Piece& x, const Piece& y) { return x.count > y.count; };
  if (!std::is_sorted(scratch_.begin(), scratch_.end(), larger))
    std::stable_sort(scratch_.begin(), scratch_.end(), larger);

  bins_.clear();
  std::size_t first_open = 0;
  for (const Piece& piece : scratch_) {
    while (first_open < bins_.size() && bins_[first_open].count == kRecordInputs) ++first_open;
    std::size_t at = std::max(first_open, bins_.size() > kOpenBins ? bins_.size() - kOpenBins : 0);
    while (at < bins_.size() && !merge(bins_[at], piece, c.op)) ++at;
    if (at == bins_.size()) bins_.push_back(piece);
  }
  // The fullest bin becomes a record; its result takes the place of one leaf in an emptier bin.
  std::stable_sort(bins_.begin(), bins_.end(), larger);
  for (std::size_t i = 0; i + 1 < bins_.size(); ++i) {
    const Piece result = leaf_piece(sink.intermediate(bins_[i]), false);
    if (!merge(bins_.back(), result, c.op)) bins_.push_back(result);
  }
  return bins_.back();
}

}  // namespace plc::bytecode
