// Covers BOOL expressions with look-up records of up to five inputs, in few records (after Chortle: Francis, Rose,
// Chung, "Chortle: a technology mapping program for lookup table-based field programmable gate arrays", DAC 1990).
//
// In: AND, OR, XOR of leaves (operand words) and of other cones, in execution order. Out: pieces, i.e. record contents;
// records that a cone needs on the way go to the RecordSink. Linear in the number of leaves; no recursion.
// Does not belong here: when a cone may be evaluated and where its result goes (body.cpp decides).
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace plc::bytecode {

inline constexpr std::uint32_t kRecordInputs = 5;

/// A function of at most five leaves: what one record computes. Rows of `table` that differ only in inputs beyond
/// `count` are equal.
struct Piece {
  std::array<std::uint32_t, kRecordInputs> leaf{};
  std::uint32_t table = 0;
  std::uint32_t count = 0;
};

/// The piece that is one leaf, or its negation.
Piece leaf_piece(std::uint32_t word, bool inverted);
inline Piece constant_piece(bool value) { return {{}, value ? ~0u : 0u, 0}; }
inline Piece inverted_piece(Piece piece) {
  piece.table = ~piece.table;
  return piece;
}

enum class Logic : std::uint8_t { kAnd, kOr, kXor };
/// a := a `op` b over the union of their leaves. False (a unchanged) when that is more than five.
bool merge(Piece& a, const Piece& b, Logic op);

/// Where records go that a cone needs for its intermediate values.
class RecordSink {
 public:
  virtual ~RecordSink() = default;
  /// Emits a record into a fresh intermediate and returns the intermediate's operand word.
  virtual std::uint32_t intermediate(const Piece& piece) = 0;
};

/// Cones under construction. A cone is an operation over pieces that are not packed into records yet, so that a chain
/// of the same operation is packed as one.
class ConeArena {
 public:
  using Id = std::uint32_t;
  static constexpr Id kNone = 0xffffffffu;

  /// An operand: a cone (consumed by the call) or, if that is kNone, a piece.
  struct Operand {
    Id cone = kNone;
    Piece piece{};
    bool inverted = false;  ///< applies to the cone
  };

  /// The cone a `op` b.
  Id combine(Logic op, const Operand& a, const Operand& b, RecordSink& sink);
  /// A second cone with the same contents.
  Id copy(Id cone);
  /// Packs a cone into one piece; the cone is gone.
  Piece close(Id cone, RecordSink& sink);

 private:
  struct Node {
    Piece piece;
    std::uint32_t next = kNone;
  };
  struct Cone {
    Logic op = Logic::kAnd;
    std::uint32_t head = kNone;
    std::uint32_t tail = kNone;
    std::uint32_t count = 0;
  };
  Id new_cone(Logic op);
  void append(Id cone, const Piece& piece);
  void absorb(Id cone, const Operand& operand, RecordSink& sink);
  void splice(Id to, Id from);

  std::vector<Node> nodes_;
  std::vector<Cone> cones_;
  std::uint32_t free_nodes_ = kNone;
  std::vector<Id> free_cones_;
  std::vector<Piece> scratch_;
  std::vector<Piece> bins_;
};

}  // namespace plc::bytecode
