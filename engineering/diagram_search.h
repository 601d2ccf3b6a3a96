// DiagramSearch: where something stands in drawings and texts: a part of a text, or a variable under any of its names.
//
// In: a book, what to look for. Out: places in the order of the project. Threads: any. Does not belong here: rows.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "engineering/diagrams.h"
#include "runtime/access.h"

namespace plc::engineering {

class DiagramSearch {
 public:
  DiagramSearch(Diagrams& diagrams, const Diagrams::Book& book) : diagrams_(diagrams), book_(book) {}

  struct Found {
    const DrawnPou* pou = nullptr;
    std::size_t body = 0;
    std::uint32_t element = 0;  ///< kNoElement: `line` of a text
    std::uint32_t line = 0;
    std::string text;
    bool writes = false;
  };
  std::string text;
  std::size_t most = 200;
  std::vector<Found> found;
  bool more = false;
  std::string path;  ///< of find_uses(): of the variable

  /// Where `text` is a part of a text, in any letter case; in all POUs, or one.
  void find_text(const DrawnPou* only);
  /// The places of the variable that `text` means in `pou` on `instance`. Without an instance, and for what is no
  /// variable, names in `pou` count.
  void find_uses(const DrawnPou& pou, const DrawnInstance* instance);

 private:
  /// Calls visit(element, line, text, writes) for each text of a body as long as it returns true.
  template <class Visit>
  void each_text(const bytecode::DrawnBody& body, Visit&& visit) const;
  bool add(Found one);

  Diagrams& diagrams_;
  const Diagrams::Book& book_;
};

}  // namespace plc::engineering
