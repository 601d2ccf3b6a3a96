// What tools hide in addData: TwinCAT and CODESYS keep resources, tasks, variable lists and POUs there.
#include <cctype>

#include "core/text.h"
#include "plcopen/reader_body.h"
#include "plcopen/reader_configuration.h"
#include "plcopen/reader_pou.h"
#include "plcopen/reader_types.h"

namespace plc::plcopen {

namespace {

void task_settings(Reader& r, const Tag& tag) {
  if (r.tasks.empty()) return;
  Task& task = *r.tasks.back();
  task.kind = core::trimmed(tag.attributes.get(Attr::kKindOfTask));
  const std::string_view event = core::trimmed(tag.attributes.get(Attr::kEvent));
  if (task.single.empty()) task.single = event;
  const std::string_view interval = core::trimmed(tag.attributes.get(Attr::kSettingsInterval));
  if (interval.empty()) return;
  task.interval = interval;
  // "t#20ms" carries its unit; a bare number needs the one beside it.
  task.interval_unit.clear();
  if (std::isdigit(static_cast<unsigned char>(interval.back())) != 0) {
    task.interval_unit = core::trimmed(tag.attributes.get(Attr::kSettingsIntervalUnit));
  }
}

void plain_declaration(Reader& r) {
  PlainDeclaration declaration;
  if (!r.var_lists.empty() && r.var_lists.back().section == Section::kGlobal) {
    declaration.owner = r.var_lists.back().list;
    declaration.of_list = true;
  } else if (!r.pous.empty()) {
    declaration.owner = r.pous.back()->pou.name;
  }
  declaration.text = r.take_text(&declaration.at);
  if (!r.pous.empty() && r.pous.back()->is_action) return;  // an action declares nothing
  r.project.declarations.push_back(std::move(declaration));
}

/// An attribute of the tool: of a list, that its name must come before its variables.
void vendor_attribute(Reader& r, const Tag& tag) {
  if (r.var_lists.empty() || r.var_lists.back().section != Section::kGlobal) return;
  if (core::iequals(core::trimmed(tag.attributes.get(Attr::kAttributeName)), "qualified_only")) {
    r.project.qualified_lists.push_back(r.var_lists.back().list);
  }
}

/// A body may be in vendor data alone, as those in languages of the tool are.
void foreign_data(Reader& r, const Tag& tag) {
  if (r.bodies.empty() || r.bodies.back()->element_open) return;
  const std::string_view name = core::trimmed(tag.attributes.get(Attr::kName));
  r.bodies.back()->foreign = name.substr(name.rfind('/') + 1);
}

/// Jumps and returns cannot be negated by the schema; Bachmann writes it here.
void vendor_negation(Reader& r, const Tag& tag) {
  if (r.bodies.empty() || !r.bodies.back()->element_open) return;
  Element& e = r.bodies.back()->element;
  if (e.kind != ElementKind::kJump && e.kind != ElementKind::kReturn) return;
  e.negated = e.negated || r.flag(tag, Attr::kValue);
}

void object_oriented(Reader& r, const Tag& tag) {
  r.report(core::Code::P1015, tag.at, "methods, properties, interfaces and inheritance are not executed",
           "write the method as a function block or a function");
}

constexpr Rule editor_data(std::string_view ending) {
  Rule rule = ignored(State::kAddData, "data", kReasonEditor);
  rule.variant = ending;
  return rule;
}

constexpr Rule unknown_data() {
  Rule rule = ignored(State::kAddData, "data", "vendor data; POUs, types, resources and variables in it are read",
                      State::kVendor);
  rule.start = foreign_data;
  return rule;
}

constexpr Rule vendor_data(std::string_view ending) {
  return used_variant(State::kAddData, "data", ending, State::kVendor);
}

constexpr Rule kRules[] = {
    unknown_data(),
    vendor_data("/application"),
    vendor_data("/resource"),
    vendor_data("/pou"),
    vendor_data("/datatype"),
    vendor_data("/globalvars"),
    vendor_data("/tasksettings"),
    vendor_data("/stcode"),
    vendor_data("/interfaceasplaintext"),
    vendor_data("/fbdelementtype"),
    vendor_data("/ldparallelbranch"),
    vendor_data("/method"),
    vendor_data("/property"),
    vendor_data("/interface"),
    vendor_data("/pouinheritance"),
    vendor_data("/action"),
    vendor_data("/actions"),
    vendor_data("/pathstructure"),
    vendor_data("/attributes"),
    editor_data("/objectid"),
    editor_data("/projectstructure"),
    editor_data("/projectinformation"),
    editor_data("/libraries"),
    editor_data("/buildproperties"),
    editor_data("/fbdcalltype"),
    editor_data("/inputparamtypes"),
    editor_data("/outputparamtypes"),
    editor_data("/implementationattributes"),
    editor_data("/ldbranchid"),
    editor_data("/www.phoenixcontact-software.com"),

    anchored(State::kVendor, "pou", State::kPou, start_pou, close_pou),
    anchored(State::kVendor, "resource", State::kResource, start_resource, end_resource),
    used(State::kVendor, "task", State::kTask, start_task, end_task),
    used(State::kVendor, "globalVars", State::kVarList, start_globals, end_var_list),
    anchored(State::kVendor, "dataType", State::kDataType, start_data_type, end_data_type),
    used(State::kVendor, "addData", State::kAddData),
    used(State::kVendor, "TaskSettings", State::kVendor, task_settings),
    used(State::kVendor, "negated", State::kLeaf, vendor_negation),
    used(State::kVendor, "STCode", State::kFormatted, start_text, element_code),
    preserved(State::kVendor, "InterfaceAsPlainText", State::kFormatted, "kept as text, the typed interface counts",
              start_text, plain_declaration),
    used(State::kVendor, "ParallelBranch", State::kClosedBranch, start_closed_branch, end_closed_branch),
    used(State::kClosedBranch, "BranchInput", State::kBranchEnd, start_branch_input, close_pin),
    used(State::kClosedBranch, "BranchTrees", State::kClosedBranch),
    used(State::kClosedBranch, "Tree", State::kBranchEnd, start_branch_line, close_pin),
    used(State::kBranchEnd, "connectionPointIn", State::kPointIn),
    refused(State::kVendor, "Method", kReasonOop, object_oriented),
    refused(State::kVendor, "Property", kReasonOop, object_oriented),
    refused(State::kVendor, "Interface", kReasonOop, object_oriented),
    refused(State::kVendor, "Inheritance", kReasonOop, object_oriented),
    used(State::kVendor, "actions", State::kActions),
    used(State::kVendor, "Actions", State::kActions),
    anchored(State::kVendor, "action", State::kPouAction, start_pou_action, close_pou_action),
    anchored(State::kVendor, "Action", State::kPouAction, start_pou_action, close_pou_action),
    used(State::kVendor, "Attributes", State::kVendor),
    used(State::kVendor, "Attribute", State::kLeaf, vendor_attribute),
    used(State::kVendor, "pathStructure", State::kVendor, path_structure),
    ignored(State::kVendor, "Watchdog", "the runtime has its own watchdog", State::kVendor),
    ignored(State::kVendor, "*", kReasonEditor, State::kVendor),
};

}  // namespace

std::span<const Rule> vendor_rules() { return kRules; }

}  // namespace plc::plcopen
