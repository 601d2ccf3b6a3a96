// Reader: what is under construction while a file is read. Handlers of the rules (reader_*.cpp, iec61131_10*.cpp) work
// on it; everything unfinished lies on stacks, so that elements may nest in any order without a dangling reference.
//
// In: events of xml_stream. Out: Project. Does not belong here: the meaning of single elements (the handlers).
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_set>
#include <utility>
#include <vector>

#include "core/diagnostics.h"
#include "core/text.h"
#include "plcopen/account.h"
#include "plcopen/project.h"
#include "plcopen/reader.h"
#include "plcopen/rules.h"
#include "plcopen/xml_stream.h"

namespace plc::plcopen {

/// A variable list that is open: where its variables go and what its head says of all of them.
struct VarListFrame {
  std::vector<Variable>* out = nullptr;
  Section section = Section::kLocal;
  std::string list;
  bool constant = false;
  bool retain = false;
  bool nonretain = false;
  bool persistent = false;
};

/// What a coordinate is for: the order of execution, or pictures alone. Those do without one that cannot be read.
enum class Coordinate : std::uint8_t { kOrder, kPicture };

/// An output point of IEC 61131-10: wires name it, not the element.
struct OutPoint {
  std::int64_t id = -1;
  std::int64_t local_id = -1;
  std::uint32_t pin = 0;      ///< index into the outputs of the element
  std::uint32_t element = 0;  ///< index into the elements of the body
  SourceRef at;
};

/// A body that is open, with the element being read in it.
struct BodyFrame {
  Body body;
  Element element;
  bool element_open = false;
  bool network_title = false;  ///< the open vendorElement is a network title
  std::string title;           ///< text of the open vendorElement
  bool action_open = false;    ///< an action of the open action block is read
  std::string guid;            ///< of the open attribute (CODESYS)
  std::string foreign;         ///< what the body has beside its languages and is not read, or empty
  SourceRef lost = {};         ///< of the open element `error`
  Pin* pin = nullptr;
  Connection* connection = nullptr;
  std::uint32_t network = 0;
  std::int32_t order = 0;            ///< evaluationOrder of the body (IEC 61131-10), 0 = none
  std::uint32_t network_begin = 0;   ///< first element of the open network (IEC 61131-10)
  std::int64_t network_order = 0;    ///< evaluationOrder of the open network
  std::vector<std::int64_t> orders;  ///< evaluationOrder of each network seen, by its number - 1
  std::vector<OutPoint> out_points;  ///< of the open network
};

/// Names of a list that grows while it is asked.
struct GrowingNames {
  template <class List>
  bool contains(const List& list, const std::string& name) {
    for (; seen < list.size(); ++seen) names.insert(list[seen].name);
    return names.contains(name);
  }
  std::unordered_set<std::string, core::NameHash, core::NameEqual> names;
  std::size_t seen = 0;
};

struct PouFrame {
  Pou pou;
  GrowingNames variable_names, action_names;
  std::vector<std::int32_t> body_orders;  ///< evaluationOrder of each finished body
  bool body_seen = false;
  bool chart_reported = false;
  bool is_action = false;
  std::vector<std::string> path;  ///< of an action outside its POU: names in the project tree, root first
};

/// An action beside the POUs (CODESYS and the tools derived from it), with the name of the POU it belongs to.
struct LooseAction {
  std::string owner;
  Pou action;
};

struct ResourceFrame {
  Resource resource;
  std::vector<std::string> instance_tasks;  ///< task named by each entry of resource.instances (IEC 61131-10), or empty
};

class Reader final : public XmlHandler {
 public:
  Reader(Project& target, core::Diagnostics& diagnostics, const ReadLimits& limits, XmlParser& parser);

  void start_element(const char* name, std::string_view uri, const Attributes& attributes, Place place) override;
  void end_element() override;
  [[nodiscard]] bool wants_text() const override { return capturing_; }
  bool ends_line_before(std::string_view piece) override;
  void text(std::string_view piece) override;

  /// After the last event: checks over the whole project.
  void finish();

  // ---- help for handlers ----
  void report(core::Code code, const SourceRef& at, std::string message, std::string help = {});
  /// Notes where a declaration is: from `begin` to where reading is.
  void note_extent(const std::string& name, const SourceRef& begin);
  /// Text of the open element and of those in it is collected until take_text(), blanks at both ends removed.
  void begin_text();
  std::string take_text(SourceRef* at = nullptr);
  /// A name that must be there: P1009 when missing, P1007 when it cannot be used.
  std::string required_name(const Tag& tag, Attr attribute);
  /// A name that may be missing.
  std::string optional_name(const Tag& tag, Attr attribute);
  /// Number or flag of an attribute; absent = the default, unreadable = P1010 and the default.
  std::int64_t integer(const Tag& tag, Attr attribute, std::int64_t absent, std::int64_t most);
  std::int32_t coordinate(const Tag& tag, Attr attribute, Coordinate use = Coordinate::kOrder);
  bool flag(const Tag& tag, Attr attribute);
  Edge edge(const Tag& tag, Attr attribute);
  Storage storage(const Tag& tag, Attr attribute);
  /// Where the value of an attribute is; the tag where it has none.
  SourceRef value_place(const Tag& tag, Attr attribute);
  /// `at` as a place of the open drawn element.
  SourceRef element_place(SourceRef at) const;
  /// A further pin of the open element, at the tag. Beyond the limit the file is read no further (P1006).
  Pin& add_pin(std::vector<Pin>& pins, const Tag& tag);
  /// The configuration for what is outside all configurations (TwinCAT, CODESYS).
  Configuration& outside();
  [[nodiscard]] std::size_t max_text() const { return limits_.max_text; }

  // ---- what is open ----
  Project& project;
  std::vector<std::unique_ptr<PouFrame>> pous;
  std::vector<std::unique_ptr<BodyFrame>> bodies;
  std::vector<VarListFrame> var_lists;
  std::deque<Variable> variables;
  std::vector<TypeSpec*> types;
  std::vector<InitialValue*> values;
  std::deque<DataType> data_types;
  std::vector<std::unique_ptr<Configuration>> configurations;
  std::vector<std::unique_ptr<ResourceFrame>> resources;
  std::vector<std::unique_ptr<Task>> tasks;
  std::vector<LooseAction> loose_actions;

 private:
  struct Frame {
    Account::NodeId node = 0;
    EndHandler end = nullptr;
    bool block = false;  ///< a paragraph or line of a text: what comes before and after it are lines of their own
  };

  void warn_of_letter_case(const Tag& tag, State parent);
  bool open_document(std::string_view name, std::string_view uri, const SourceRef& at);
  bool check_name(std::string_view name, const Tag& tag, Attr attribute);

  core::Diagnostics& diagnostics_;
  const ReadLimits& limits_;
  XmlParser& parser_;
  Account account_;
  std::vector<Frame> frames_;
  std::unordered_set<std::string> unknown_;
  std::unordered_set<std::string> other_case_;  ///< attributes that were named
  std::unordered_set<const Rule*> misplaced_;   ///< those that were named
  std::unique_ptr<Configuration> outside_;
  std::string text_;
  SourceRef text_at_;
  bool capturing_ = false;
  bool line_ends_ = false;   ///< a paragraph or line of the text began or ended
  bool line_ended_ = false;  ///< the blanks that the text ends with have a line end
};

}  // namespace plc::plcopen
