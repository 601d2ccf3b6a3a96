#include "drawings/statements.h"

#include <algorithm>
#include <utility>

#include "core/diagnostics.h"
#include "frontend-il/parser.h"
#include "frontend-st/parser.h"
#include "frontend-st/source_text.h"

namespace plc::drawings {
namespace {

using bytecode::DrawnStatement;
using st::NodeKind;

class Statements {
 public:
  explicit Statements(const st::SourceText& source) : source_(source) {}

  void list(const st::Ast& ast, st::NodeId first) {
    for (st::NodeId id = first; id != st::kNoNode; id = ast[id].next) {
      add(ast[id].begin, ast[id].end);
      inside(ast, ast[id]);
    }
  }
  void add(std::uint32_t begin, std::uint32_t end) {
    const core::SourceRef first = source_.locate(begin), last = source_.locate(end);
    found_.push_back({first.line, first.column, last.line, last.column});
  }
  std::vector<DrawnStatement> take() { return std::move(found_); }

 private:
  /// Nesting is limited by the parser (st::kMaxDepth).
  void inside(const st::Ast& ast, const st::Node& node) {
    switch (node.kind) {
      case NodeKind::kIf:
      case NodeKind::kFor:
      case NodeKind::kWhile:
      case NodeKind::kRepeat:
        list(ast, node.b);
        break;
      case NodeKind::kCase:
        break;
      default:
        return;
    }
    if (node.kind != NodeKind::kIf && node.kind != NodeKind::kCase) return;
    // ELSIF, ELSE, and the branches of a CASE: each leads to the next.
    for (st::NodeId part = node.c; part != st::kNoNode; part = ast[part].c) list(ast, ast[part].b);
  }

  const st::SourceText& source_;
  std::vector<DrawnStatement> found_;
};

}  // namespace

std::vector<DrawnStatement> statements_of(const plcopen::Body& body, const core::Diagnostics& places) {
  if (body.text.size() > st::kMaxTextBytes) return {};
  const core::SourceRef at = body.text_at.line != 0 ? body.text_at : body.at;
  const st::SourceText source(body.text, at, places);
  Statements statements(source);
  core::Diagnostics quiet;
  if (body.language == plcopen::Language::kIl) {
    il::Parser parser(source, quiet, {});
    const il::Listing listing = parser.parse();
    for (const il::Instruction& one : listing.instructions) {
      std::uint32_t end = one.end;
      for (st::NodeId id = one.operand; id != st::kNoNode; id = listing.ast[id].next) {
        end = std::max(end, listing.ast[id].end);
      }
      statements.add(one.begin, end);
    }
    return statements.take();
  }
  st::Parser parser(source, quiet, {});
  for (st::NodeId one = parser.next_statement(); one != st::kNoNode; one = parser.next_statement()) {
    statements.list(parser.ast(), one);
  }
  return statements.take();
}

}  // namespace plc::drawings
