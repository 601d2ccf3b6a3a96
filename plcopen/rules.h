// The table of known elements: (state of the parent, element name) -> what to do and what to account. One table drives
// reading, the import report and SUPPORT.md.
//
// In: rows in reader_*.cpp and iec61131_10*.cpp. Out: all_rules(). Does not belong here: state of a running read.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "plcopen/project.h"
#include "plcopen/xml_stream.h"

namespace plc::plcopen {

class Reader;

/// Where in a project the reader is: decides what an element name means. The texts head the tables of SUPPORT.md.
#define PLC_READER_STATES(X)                                                 \
  X(Document, "the file")                                                    \
  X(Project, "project")                                                      \
  X(ContentHeader, "contentHeader")                                          \
  X(Types, "types")                                                          \
  X(DataTypes, "dataTypes")                                                  \
  X(DataType, "dataType")                                                    \
  X(Type, "a type (type, baseType, returnType)")                             \
  X(Array, "array")                                                          \
  X(Enum, "enum")                                                            \
  X(EnumValues, "enum/values")                                               \
  X(Struct, "struct")                                                        \
  X(Subrange, "subrangeSigned, subrangeUnsigned")                            \
  X(Pointer, "pointer")                                                      \
  X(Value, "a value (initialValue, value)")                                  \
  X(Values, "arrayValue, structValue")                                       \
  X(Pous, "pous")                                                            \
  X(Pou, "pou")                                                              \
  X(PouAction, "actions/action")                                             \
  X(Interface, "interface")                                                  \
  X(VarList, "a variable list (localVars, inputVars, globalVars, ..)")       \
  X(AccessVars, "accessVars")                                                \
  X(ConfigVars, "configVars")                                                \
  X(Variable, "variable")                                                    \
  X(Actions, "actions, transitions")                                         \
  X(Body, "body")                                                            \
  X(Drawing, "LD, FBD")                                                      \
  X(Sfc, "SFC")                                                              \
  X(Condition, "SFC/transition/condition")                                   \
  X(Inline, "SFC/transition/condition/inline")                               \
  X(SfcAttributes, "attributes of a chart's element (CODESYS)")              \
  X(SfcSettings, "sfcsettings (CODESYS)")                                    \
  X(SfcFlags, "sfcsettings/Flags (CODESYS)")                                 \
  X(Element, "a drawn element")                                              \
  X(Action, "actionBlock/action")                                            \
  X(InputPins, "block/inputVariables")                                       \
  X(InOutPins, "block/inOutVariables")                                       \
  X(OutputPins, "block/outputVariables")                                     \
  X(Pin, "a pin (block/../variable)")                                        \
  X(PointIn, "connectionPointIn")                                            \
  X(PointOut, "connectionPointOut")                                          \
  X(Connection, "connection")                                                \
  X(Comment, "comment")                                                      \
  X(ClosedBranch, "ParallelBranch (CODESYS)")                                \
  X(BranchEnd, "ParallelBranch/BranchInput, Tree (CODESYS)")                 \
  X(Instances, "instances")                                                  \
  X(Configurations, "configurations")                                        \
  X(Configuration, "configuration")                                          \
  X(Resource, "resource")                                                    \
  X(Task, "task")                                                            \
  X(PouInstance, "pouInstance")                                              \
  X(AddData, "addData")                                                      \
  X(Vendor, "addData/data, at any depth")                                    \
  X(XProject, "Project (IEC 61131-10)")                                      \
  X(XContentHeader, "ContentHeader (IEC 61131-10)")                          \
  X(XTypes, "Types (IEC 61131-10)")                                          \
  X(XNamespace, "GlobalNamespace, NamespaceDecl (IEC 61131-10)")             \
  X(XDataType, "DataTypeDecl (IEC 61131-10)")                                \
  X(XTypeSpec, "a type specification (IEC 61131-10)")                        \
  X(XDimension, "DimensionSpec (IEC 61131-10)")                              \
  X(XTypeRef, "Type, BaseType, ResultType (IEC 61131-10)")                   \
  X(XValue, "InitialValue, Value (IEC 61131-10)")                            \
  X(XValues, "ArrayValue, StructValue (IEC 61131-10)")                       \
  X(XPou, "Program, FunctionBlock, Function (IEC 61131-10)")                 \
  X(XParameters, "Parameters (IEC 61131-10)")                                \
  X(XVarList, "a variable list (IEC 61131-10)")                              \
  X(XAccessVars, "AccessVars (IEC 61131-10)")                                \
  X(XConfigVars, "ConfigVars (IEC 61131-10)")                                \
  X(XVariable, "Variable, Member (IEC 61131-10)")                            \
  X(XMainBody, "MainBody (IEC 61131-10)")                                    \
  X(XDrawing, "BodyContent with LD, FBD (IEC 61131-10)")                     \
  X(XText, "BodyContent with ST, IL (IEC 61131-10)")                         \
  X(XNetwork, "Rung, Network (IEC 61131-10)")                                \
  X(XObject, "LdObject, FbdObject, CommonObject (IEC 61131-10)")             \
  X(XCode, "an inline ST object (IEC 61131-10)")                             \
  X(XPins, "InputVariables, InOutVariables, OutputVariables (IEC 61131-10)") \
  X(XPin, "a pin (IEC 61131-10)")                                            \
  X(XPointIn, "ConnectionPointIn (IEC 61131-10)")                            \
  X(XPointOut, "ConnectionPointOut (IEC 61131-10)")                          \
  X(XInstances, "Instances (IEC 61131-10)")                                  \
  X(XConfiguration, "Configuration (IEC 61131-10)")                          \
  X(XResource, "Resource (IEC 61131-10)")                                    \
  X(XTask, "Task, ProgramInstance (IEC 61131-10)")                           \
  X(XAddData, "AddData (IEC 61131-10)")                                      \
  X(XVendor, "AddData/Data, at any depth (IEC 61131-10)")                    \
  X(Formatted, "a text with markup")                                         \
  X(Text, "a plain text")                                                    \
  X(Leaf, "an element without content")                                      \
  X(Skip, "an element that is not read")

enum class State : std::uint8_t {
#define PLC_STATE(Name, title) k##Name,
  PLC_READER_STATES(PLC_STATE)
#undef PLC_STATE
};
/// Heading for the state's elements in SUPPORT.md.
std::string_view state_title(State state);

/// A start tag as handlers see it.
struct Tag {
  std::string_view name;
  const Attributes& attributes;
  core::SourceRef at;
};
using StartHandler = void (*)(Reader&, const Tag&);
using EndHandler = void (*)(Reader&);

struct Rule {
  State parent;
  State state;  ///< state for the children
  Fate fate = Fate::kUsed;
  bool anchor = false;         ///< paths in the import report begin here
  bool inherit = false;        ///< fate and reason come from the parent ("*" rows)
  std::string_view name;       ///< local name; "*" = any other name
  std::string_view variant;    ///< "/..": end of data's name; else local part of xsi:type; empty = any
  std::string_view reason;     ///< for SUPPORT.md and the import report
  std::string_view belongs{};  ///< misplaced: the element it should be in
  StartHandler start = nullptr;
  EndHandler end = nullptr;
};

constexpr Rule make_rule(State parent, std::string_view name, State state, Fate fate, std::string_view reason,
                         StartHandler start, EndHandler end) {
  Rule rule{.parent = parent, .state = state, .fate = fate, .name = name, .variant = {}, .reason = reason};
  rule.start = start;
  rule.end = end;
  return rule;
}
constexpr Rule used(State parent, std::string_view name, State state, StartHandler start = nullptr,
                    EndHandler end = nullptr) {
  return make_rule(parent, name, state, Fate::kUsed, {}, start, end);
}
constexpr Rule used_variant(State parent, std::string_view name, std::string_view variant, State state,
                            StartHandler start = nullptr, EndHandler end = nullptr) {
  Rule rule = used(parent, name, state, start, end);
  rule.variant = variant;
  return rule;
}
constexpr Rule anchored(State parent, std::string_view name, State state, StartHandler start = nullptr,
                        EndHandler end = nullptr) {
  Rule rule = used(parent, name, state, start, end);
  rule.anchor = true;
  return rule;
}
constexpr Rule preserved(State parent, std::string_view name, State state, std::string_view reason, StartHandler start,
                         EndHandler end) {
  return make_rule(parent, name, state, Fate::kPreserved, reason, start, end);
}
constexpr Rule ignored(State parent, std::string_view name, std::string_view reason, State state = State::kSkip) {
  return make_rule(parent, name, state, Fate::kIgnored, reason, nullptr, nullptr);
}
constexpr Rule refused(State parent, std::string_view name, std::string_view reason, StartHandler start) {
  return make_rule(parent, name, State::kSkip, Fate::kRefused, reason, start, nullptr);
}
constexpr Rule inherited(State parent, State state) {
  Rule rule = used(parent, "*", state);
  rule.inherit = true;
  return rule;
}

inline constexpr std::string_view kReasonLayout = "layout only";
inline constexpr std::string_view kReasonEditor = "editor data";
inline constexpr std::string_view kReasonComment = "comment";
inline constexpr std::string_view kReasonDrawn = "kept for pictures of the drawing";
inline constexpr std::string_view kReasonNote = "documentation of this element is not kept";
inline constexpr std::string_view kReasonHeader = "project information";
inline constexpr std::string_view kReasonSfc = "charts of IEC 61131-10 are not read (P1016)";
inline constexpr std::string_view kReasonOop = "object-oriented parts are not executed (P1015)";
inline constexpr std::string_view kReasonKept = "kept as documentation";

std::span<const Rule> project_rules();
std::span<const Rule> type_rules();
std::span<const Rule> pou_rules();
std::span<const Rule> body_rules();
std::span<const Rule> chart_rules();
std::span<const Rule> configuration_rules();
std::span<const Rule> vendor_rules();
std::span<const Rule> misplaced_rules();
std::span<const Rule> iec10_rules();
std::span<const Rule> iec10_body_rules();

/// All rows in the order of the tables above.
const std::vector<Rule>& all_rules();

}  // namespace plc::plcopen
