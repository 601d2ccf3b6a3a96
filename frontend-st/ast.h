// Syntax tree of ST: flat, indices instead of pointers, children before parents. Nodes name byte ranges of the text.
//
// In: made by the parser. Out: read by the lowerings and by constant evaluation. Does not belong here: names, types.
// Depth: a tree is at most kMaxDepth levels of nesting deep, but operator chains ("a + b + ..") and postfix chains
// ("a.b.c") lean to the left without limit: walk their left spine in a loop.
#pragma once

#include <cstdint>
#include <vector>

namespace plc::st {

using NodeId = std::uint32_t;
inline constexpr NodeId kNoNode = 0xffffffffu;
/// Nested parentheses, arguments, indices, prefix operators and IFs. Far above what people write, far below the stack.
inline constexpr std::uint32_t kMaxDepth = 128;

enum class Operator : std::uint8_t {
  kNone,
  kOr,
  kXor,
  kAnd,
  kEqual,
  kNotEqual,
  kLess,
  kLessEqual,
  kGreater,
  kGreaterEqual,
  kAdd,
  kSubtract,
  kMultiply,
  kDivide,
  kModulo,
  kPower,
  kNegate,
  kPlus,
  kNot,
  kAndThen,  ///< AND that leaves its right side alone when the left one is FALSE (CODESYS)
  kOrElse,   ///< OR that leaves its right side alone when the left one is TRUE (CODESYS)
  kSet,      ///< of kAssign: S=
  kReset,    ///< of kAssign: R=
  kBind,     ///< of kAssign and kArgument: REF=
};

enum class NodeKind : std::uint8_t {
  // expressions
  kLiteral,
  kName,
  kEnumValue,  ///< Type#Name
  kDirect,     ///< %IX0.0
  kMember,     ///< a . [name, end)
  kBit,        ///< a . [name, end): part of a word, as in w.3, w.%X3 or w.%B1
  kIndex,      ///< a [ b .. ]: b is the first index, linked by next
  kDeref,      ///< a ^
  kUnary,      ///< op a
  kBinary,     ///< a op b
  kCall,       ///< a ( b .. ): b is the first kArgument or kNoNode; [name, name_end) is what replaces the
               ///< parentheses where they are omitted, else empty
  kArgument,   ///< positional, or [name, name_end) := a, or => a
  kGiven,      ///< no text: the value number `given` that the lowering was given (the accumulator of IL)
  // statements, linked by next
  kAssign,         ///< a := b, a S= b, a R= b (op); b is a kAssign itself in a := b := c
  kCallStatement,  ///< a is the kCall
  kIf,             ///< IF a THEN b .. ; c is the next kIf (ELSIF), or kElse
  kElse,           ///< b ..
  kCase,           ///< CASE a OF; c is the first kBranch or kElse
  kBranch,         ///< labels a .. : b ..; c is the next kBranch or kElse
  kRange,          ///< label a .. b
  kFor,            ///< FOR a := c (three expressions: initial, final, increment or kNoNode) DO b ..
  kWhile,          ///< WHILE a DO b ..
  kRepeat,         ///< REPEAT b .. UNTIL a
  kExit,
  kContinue,
  kReturn,
};

enum class ArgumentKind : std::uint8_t { kPositional, kInput, kOutput, kNegatedOutput };

struct Node {
  NodeKind kind = NodeKind::kLiteral;
  Operator op = Operator::kNone;
  ArgumentKind argument = ArgumentKind::kPositional;
  std::uint32_t begin = 0;  ///< byte range of the text
  std::uint32_t end = 0;
  std::uint32_t name = 0;      ///< leaves: where the token begins; kMember, kBit, kArgument: where the name begins
  std::uint32_t name_end = 0;  ///< where it ends
  std::uint32_t given = 0;     ///< kGiven: which one
  NodeId a = kNoNode;
  NodeId b = kNoNode;
  NodeId c = kNoNode;
  NodeId next = kNoNode;
};

struct Ast {
  std::vector<Node> nodes;

  [[nodiscard]] const Node& operator[](NodeId id) const { return nodes[id]; }
  NodeId add(const Node& node) {
    nodes.push_back(node);
    return static_cast<NodeId>(nodes.size() - 1);
  }
};

}  // namespace plc::st
