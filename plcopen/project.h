// Project: what a PLCopen XML or ST file says, typed, in file order, without interpretation. Front ends read it;
// nothing here knows what a drawing means. Texts are UTF-8, trimmed where the schema allows blanks around them.
//
// In: filled by plcopen/reader.cpp and frontend-st/read.cpp. Out: read by frontend-*. Does not belong here: name
// resolution, types' sizes, order.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/source_ref.h"

namespace plc::plcopen {

using core::ElementKind;
using core::SourceRef;

/// Spelling the file uses (docs: plcopen/SUPPORT.md). kUnknown = an unknown namespace, read by local names with a
/// warning. kText = no XML but declarations and bodies as text (docs/guides/structured-text.md).
enum class Version : std::uint8_t { kUnknown, kTc6v101, kTc6v200, kTc6v201, kIec61131_10, kText };

// ---- types and values as written ------------------------------------------------------------------------------

struct TypeSpec;

/// A bound or a length as written: an integer or the text of a constant expression.
struct Dimension {
  std::string lower;
  std::string upper;
  SourceRef lower_at = {};  ///< where the texts are, if known more exactly than the type
  SourceRef upper_at = {};
};
struct EnumValue {
  std::string name;
  std::string value;  ///< as written, empty = previous + 1
  SourceRef at;
  SourceRef value_at = {};  ///< where `value` is, if known more exactly
};
struct Variable;

struct TypeSpec {
  enum class Kind : std::uint8_t {
    kNamed,        ///< elementary or derived: `name`
    kString,       ///< `name` is STRING or WSTRING, `length` as written or empty
    kArray,        ///< `dimensions`, `base`
    kStruct,       ///< `members`
    kEnum,         ///< `values`, `base` or null
    kSubrange,     ///< `dimensions[0]`, `base`
    kPointer,      ///< `base` (POINTER TO, <pointer>)
    kMissing,      ///< no type given
    kReference,    ///< `base` (REF_TO)
    kReferenceTo,  ///< `base` (REFERENCE TO of CODESYS, followed by its name alone)
    kUnion,        ///< `members`
  };
  Kind kind = Kind::kMissing;
  std::string name;
  std::string length;
  std::vector<Dimension> dimensions;
  std::vector<EnumValue> values;
  std::vector<Variable> members;
  std::shared_ptr<TypeSpec> base;  ///< of a kStruct: the structure that it extends
  SourceRef at;
  SourceRef length_at;  ///< where `length` is, if known more exactly
};

struct InitialValue {
  enum class Kind : std::uint8_t { kNone, kSimple, kArray, kStruct };
  Kind kind = Kind::kNone;
  std::string text;    ///< kSimple: literal, expression or enumeration name, as written; else what a list was given as
  std::string member;  ///< this value's member name inside a kStruct parent
  std::string repetition;            ///< repetition count inside a kArray parent, as written; empty = 1
  std::vector<InitialValue> values;  ///< kArray elements or kStruct members, in order
  SourceRef at;
  SourceRef repetition_at;  ///< where `repetition` is, if known more exactly
};

/// kAccess: `name` is the alias, `address` the instance path, `constant` = read only. kConfig (VAR_CONFIG): `name` is
/// the instance path. kInstance (VAR_INST): kept from call to call, as kLocal of function blocks and programs is.
enum class Section : std::uint8_t {
  kInput,
  kOutput,
  kInOut,
  kLocal,
  kTemp,
  kExternal,
  kGlobal,
  kAccess,
  kConfig,
  kInstance,
  kStatic,   ///< VAR_STAT: one variable of the POU, whatever instances and calls it has
  kGeneric,  ///< VAR_GENERIC CONSTANT: constants whose values a declaration may give, FB<10>
};

enum class Edge : std::uint8_t { kNone, kRising, kFalling };

struct Variable {
  std::string name;
  Section section = Section::kLocal;
  TypeSpec type;
  InitialValue initial;
  std::string address;  ///< "%IX0.0" as written, or empty
  std::string list;     ///< name of the globalVars list ("GVL"), for qualified access GVL.x; or empty
  std::string prefix;   ///< name that may precede the variable though it needs none: its file's or list's; or empty
  bool file_prefix = false;  ///< the prefix is the name of the file, which the standard does not know
  bool constant = false;
  bool retain = false;
  bool nonretain = false;
  bool persistent = false;
  bool refused = false;     ///< the rest of its declaration could not be read, and was reported
  Edge edge = Edge::kNone;  ///< kInput of type BOOL: R_EDGE, F_EDGE; the body sees the edge, not the level
  std::string documentation;
  SourceRef at;
};

struct DataType {
  std::string name;
  TypeSpec type;
  InitialValue initial;
  SourceRef at;
  bool qualified = false;  ///< enumeration: its values are named with the type before them (qualified_only)
};

// ---- drawings -------------------------------------------------------------------------------------------------

enum class Storage : std::uint8_t { kNone, kSet, kReset };

/// A place in a drawing, in the file's units.
struct Point {
  std::int32_t x = 0, y = 0;
};

/// One <connection> of an input: the wire to the element (and pin) that feeds it.
struct Connection {
  std::int64_t ref_local_id = -1;
  std::string formal_parameter;  ///< output pin named at the far end, or empty
  SourceRef at;
  bool refused = false;       ///< where it comes from could not be read, and was reported
  std::vector<Point> points;  ///< corners of the line as drawn, from this input to the output that feeds it; or none
};

/// A pin of an element: name and modifiers, and for inputs what is wired to it.
struct Pin {
  std::string name;  ///< formalParameter as written, or empty
  bool negated = false;
  Edge edge = Edge::kNone;
  Storage storage = Storage::kNone;
  bool hidden = false;
  bool has_point_in = false;            ///< a connectionPointIn is drawn
  bool has_point_out = false;           ///< a connectionPointOut is drawn
  bool has_place = false;               ///< `place` was given
  Point place;                          ///< of the connection point, from the left upper corner of the element
  std::vector<Connection> connections;  ///< inputs: wires that meet at the pin (several = OR for BOOL)
  std::string expression;               ///< text given inside the connection point in instead of a wire, or empty
  std::string target;                   ///< variable given inside the connection point out, or empty
  SourceRef at;
  SourceRef target_at;  ///< where `target` is
};

/// Lines of a rung that leave one point and meet again, as CODESYS marks them where one holds a box. Their wires are
/// drawn like all others.
struct ClosedBranch {
  std::int64_t local_id = -1;  ///< of the mark
  bool short_circuit = false;  ///< mode "sce": boxes inside are not executed while a line without one is TRUE
  Pin input;                   ///< where the lines leave: its connections
  std::vector<Pin> lines;      ///< the end of each line: its connections
};

/// A comment in a drawing, or the title of a network.
struct DrawnComment {
  std::string text;
  Point place;
  std::int32_t width = 0, height = 0;
  std::uint32_t network = 0;  ///< as Element::network
  std::size_t before = 0;     ///< index of the element that follows it in the file
};

/// One action of an action block.
struct ActionLink {
  std::string qualifier;  ///< "N", "S", "P0", ...; empty = N
  /// Action or variable referred to, or empty. An action that is drawn in the block is one of the POU's.
  std::string name;
  std::string text;            ///< inline ST, or empty
  std::string duration;        ///< as written, or empty
  std::string indicator;       ///< indicator variable, or empty
  std::int64_t local_id = -1;  ///< its own, beside that of its block
  SourceRef at;
  SourceRef text_at;
};

struct Body;

/// What an element of a sequential function chart has beyond its pins (IEC 61131-3:2013, 6.7).
struct ChartPart {
  bool initial = false;        ///< step: initial step
  bool excluded = false;       ///< left out of the build (3S)
  std::string main;            ///< step: action of the POU or of an instance, run while it is active (3S); or empty
  std::string entry;           ///< step: the same, once when it becomes active
  std::string exit;            ///< step: the same, once when it ceases to be active
  std::string min_time;        ///< step: TIME before which no transition is tested (3S); or empty
  std::string max_time;        ///< step: TIME after which it is active too long (3S); or empty
  std::string reference;       ///< transition: name of a transition of the POU that is its condition; or empty
  std::string text;            ///< transition: condition as ST; or empty
  SourceRef text_at = {};      ///< where `text` is
  std::int64_t priority = -1;  ///< transition: small numbers first; -1 = none
  bool negated = false;        ///< transition: it goes on when its condition does not hold; also at the pin `condition`
  Pin condition = {};          ///< transition: what is wired to its condition
  std::shared_ptr<Body> macro = {};  ///< macro step: the chart in it; null when it has none
};

/// One drawn element. Which fields mean something depends on `kind`; the rest is empty.
struct Element {
  ElementKind kind = ElementKind::kNone;
  Edge edge = Edge::kNone;           ///< contact, coil
  Storage storage = Storage::kNone;  ///< contact, coil, in/out variables
  bool negated = false;              ///< contact, coil, in/outVariable; inOutVariable: negatedIn
  bool negated_out = false;          ///< inOutVariable: negatedOut
  Edge edge_out = Edge::kNone;       ///< inOutVariable: edgeOut
  Storage storage_out = Storage::kNone;
  bool has_position = false;
  bool has_code = false;      ///< an EXECUTE box: `code` holds its ST, even if empty
  std::int32_t x = 0, y = 0;  ///< position as drawn, in the file's units
  std::int32_t width = 0, height = 0;
  std::uint32_t execution_order = 0;  ///< executionOrderId, 0 = none
  bool order_zero = false;            ///< executionOrderId="0" is written
  /// Group inside the body that a network title or separator opens (TwinCAT/CODESYS); 0 when the file has none.
  std::uint32_t network = 0;
  SourceRef at;
  /// contact/coil: the <variable> text. in/out/inOutVariable: the expression. block: typeName. connector, continuation,
  /// label, jump, step: the name. jumpStep: the step it goes to. actionBlock: the names its actions refer to, for
  /// messages. comment-like elements are not stored.
  std::string text;
  SourceRef text_at;          ///< where `text` is in the file
  std::string instance_name;  ///< block: instanceName, or empty
  std::string code;           ///< block: ST of an EXECUTE box
  SourceRef code_at;
  std::vector<Pin>
      inputs;  ///< contact, coil, outVariable, connector, jump, return, right rail: the connection points in order
  std::vector<Pin> in_outs;
  std::vector<Pin> outputs;  ///< left rail, continuation, contact, coil, inVariable: the connection points out in order
  std::vector<ActionLink> actions;   ///< actionBlock
  std::shared_ptr<ChartPart> chart;  ///< step, macro step, transition; else null
};

enum class Language : std::uint8_t { kNone, kLd, kFbd, kSt, kIl, kSfc };
/// "LD", "FBD", "ST", "IL", "SFC"; "none" for an empty body.
const char* language_name(Language language);

struct Body {
  Language language = Language::kNone;
  std::string name;               ///< IEC 61131-10 worksheets; usually empty
  std::vector<Element> elements;  ///< LD, FBD, SFC drawn: document order
  std::vector<ClosedBranch> closed_branches;
  std::vector<DrawnComment> comments;
  std::uint32_t drawn_elements = 0;  ///< elements drawn, comments excluded, whatever the language
  std::string text;                  ///< ST, IL, SFC as text
  std::vector<std::string> flags;    ///< SFC: flags that its settings declare and use, "SFCInit" (3S)
  SourceRef at;
  SourceRef text_at;  ///< first character of `text`
  std::string lead;   ///< files of ST: comments before `text`, up to it, from the begin of a line; else empty
  SourceRef lead_at;
  /// Names that pragmas of the text may ask for, as --define has them; null: those of the options.
  std::shared_ptr<const std::vector<std::string>> defines = {};
};

enum class PouKind : std::uint8_t { kProgram, kFunctionBlock, kFunction };
/// "program", "functionBlock", "function".
const char* pou_kind_name(PouKind kind);

struct Pou {
  std::string name;
  PouKind kind = PouKind::kProgram;
  TypeSpec return_type;             ///< functions; kMissing otherwise
  std::vector<Variable> variables;  ///< all sections, in file order
  std::vector<Body> bodies;         ///< usually one
  std::vector<Pou> actions;         ///< bodies that run on its instances; an action has a name and bodies, no more
  std::vector<Pou> transitions;     ///< conditions of its charts: a name and a body, no more
  std::string result;  ///< of a transition: the name by which its body gives the condition; empty = its own
  /// Why the bodies are not read, as part of a sentence: "drawn in CFC, in the format of TwinCAT"; empty = they are.
  /// Compiling it is an error, and --stub-missing makes it a stub.
  std::string unread;
  bool object_oriented = false;             ///< that is the reason
  std::vector<std::string> unread_members;  ///< methods and properties: uses of these names are no errors of their own
  bool has_chart = false;                   ///< parts of a sequential function chart are present
  bool from_library = false;    ///< brought by --lib: compiled when something uses it, not looked at by lint
  bool test = false;            ///< a TEST block, which nothing but plc test compiles and runs
  std::uint64_t taskblock = 0;  ///< declares a taskblock: hash of its declaration; 0 = it does not
  std::string documentation;
  SourceRef at;
};

// ---- configuration --------------------------------------------------------------------------------------------

/// One element of PROGRAM p : T (In := x, Out => y).
struct InstanceConnection {
  std::string variable;  ///< of the program
  std::string other;     ///< what it is connected to, as written: a constant, a global variable or an address
  bool output = false;   ///< =>
  SourceRef at;
  SourceRef other_at;
};
struct PouInstance {
  std::string name;
  std::string type_name;  ///< as written; empty = "the type is named like the instance"
  SourceRef at;
  bool retain = false;  ///< PROGRAM RETAIN p
  std::vector<InstanceConnection> connections = {};
};

struct Task {
  std::string name;
  std::string interval;       ///< as written, or empty
  std::string interval_unit;  ///< TaskSettings IntervalUnit when `interval` came from there, else empty
  std::string single;         ///< trigger variable, or empty
  std::string priority;       ///< as written
  std::string kind;           ///< TaskSettings KindOfTask ("Cyclic", "Freewheeling", ...), or empty
  std::vector<PouInstance> instances;
  SourceRef at;
};

struct Resource {
  std::string name;
  std::vector<Task> tasks;
  std::vector<PouInstance> instances;  ///< beside the tasks (v1 files): run by the resource's only task
  std::vector<Variable> globals;
  SourceRef at;
};

struct Configuration {
  std::string name;  ///< empty for resources outside a configuration (TwinCAT)
  std::vector<Resource> resources;
  std::vector<Variable> globals;
  std::vector<Variable> access;
  std::vector<Variable> configs;  ///< VAR_CONFIG entries
  SourceRef at;
};

/// What became of an element name while reading.
enum class Fate : std::uint8_t { kUsed, kPreserved, kIgnored, kRefused };

/// One row of the import report: an element (by its path below the nearest POU, body or project part), how often, why.
struct ReportRow {
  std::string element;  ///< "body/LD/contact", "pou/addData/data[http://..]"
  Fate fate = Fate::kUsed;
  std::uint32_t count = 0;
  std::uint32_t first_line = 0;
  std::string reason;  ///< for kPreserved, kIgnored and kRefused
};

/// A declaration kept as the tool's own text (TwinCAT/CODESYS interfaceasplaintext): the typed interface is what
/// counts, where there is one.
struct PlainDeclaration {
  std::string owner;     ///< POU or globalVars list it belongs to
  bool of_list = false;  ///< owner is a globalVars list
  std::string text;
  SourceRef at;
};

/// Where a declaration is that others may name, whether it was understood or not: a data type, a POU, the global
/// variables of one line of a list. Problems between its ends are its own.
struct Extent {
  std::vector<std::string> names;
  SourceRef begin;
  SourceRef end;
};

/// A pragma, "{attribute 'qualified_only'}", kept as written; none has a meaning for the program.
struct Pragma {
  std::string text;
  SourceRef at;
};

/// A comment between the declarations of a text, as written.
struct Comment {
  std::string text;
  SourceRef at;
  bool follows = false;  ///< something else is in its line before it
};

/// {attribute 'name'} or {attribute 'name' := 'value'} before a POU or a variable.
struct Attribute {
  std::string pou;       ///< the POU, or that of the variable; empty for variables outside of POUs
  std::string variable;  ///< empty: of the POU itself
  std::string name;
};

struct Project {
  std::string path;
  Version version = Version::kUnknown;
  std::string name;     ///< contentHeader name
  std::string product;  ///< fileHeader productName
  std::vector<DataType> data_types;
  std::vector<Pou> pous;
  std::vector<Pou> tests;  ///< TEST blocks of texts, each named by what stands in its quotes
  std::vector<Configuration> configurations;
  std::vector<PlainDeclaration> declarations;
  bool has_3s_charts = false;                ///< some chart comes from CODESYS or a tool derived from it, or says so
  std::vector<std::string> qualified_lists;  ///< globalVars lists of XML with the attribute qualified_only
  std::vector<Pragma> pragmas;
  std::vector<Comment> comments;        ///< of texts, outside of bodies
  std::vector<Attribute> attributes;    ///< of texts
  bool qualified_globals = false;       ///< text: {attribute 'qualified_only'} is before globals that name no list
  std::vector<Extent> extents;          ///< of the file's own declarations
  std::vector<Extent> library_extents;  ///< of the declarations of libraries that joined the project
  std::vector<std::string>
      offered_types;              ///< join the project when it names them (taskblocks); guessed for misspelt ones
  std::vector<ReportRow> report;  ///< XML: counts add up to the number of elements of the file
  std::uint16_t file = 0;         ///< index into Diagnostics' files
};

}  // namespace plc::plcopen
