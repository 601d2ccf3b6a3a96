// The spelling of IEC 61131-10: projects, types, POUs, configurations. Drawn bodies are in iec61131_10_body.cpp.
#include "core/text.h"
#include "plcopen/reader_configuration.h"
#include "plcopen/reader_pou.h"
#include "plcopen/reader_types.h"

namespace plc::plcopen {

namespace {

void file_header(Reader& r, const Tag& tag) { r.project.product = tag.attributes.get(Attr::kProductName); }
void content_header(Reader& r, const Tag& tag) { r.project.name = tag.attributes.get(Attr::kName); }

template <PouKind kKind>
void start_pou_of(Reader& r, const Tag& tag) {
  open_pou(r, tag, kKind);
}

void object_oriented(Reader& r, const Tag& tag) {
  r.report(core::Code::P1015, tag.at, "classes, interfaces, methods and inheritance are not executed",
           "write the method as a function block or a function");
  const std::string name = r.optional_name(tag, Attr::kName);
  if (r.pous.empty() && !name.empty()) r.note_extent(name, tag.at);
}

void chart_part(Reader& r, const Tag& tag) {
  if (!r.pous.empty()) r.pous.back()->pou.has_chart = true;
  report_chart(r, tag);
}

void type_name(Reader& r) {
  const SourceRef at = r.types.back()->at;
  parse_type_text(r.take_text(), at, *r.types.back());
}

void string_spec(Reader& r, const Tag& tag) {
  TypeSpec& type = *r.types.back();
  type.kind = TypeSpec::Kind::kString;
  type.name = tag.attributes.get(Attr::kXsiType).find("WString") == std::string_view::npos ? "STRING" : "WSTRING";
  type.length = core::trimmed(tag.attributes.get(tag.attributes.has(Attr::kLength) ? Attr::kLength : Attr::kMaxLength));
}

/// A type that is another one under a new name: the base's text becomes the type.
void derived_base(Reader& r) {
  pop_type(r);
  TypeSpec& type = *r.types.back();
  if (type.kind != TypeSpec::Kind::kMissing || type.base == nullptr) return;
  const std::shared_ptr<TypeSpec> base = std::move(type.base);
  TypeSpec copy = std::move(*base);
  type = std::move(copy);
}

void address(Reader& r, const Tag& tag) {
  r.variables.back().address = core::trimmed(tag.attributes.get(Attr::kAddress));
}

void start_x_access(Reader& r, const Tag& tag) {
  push_var_list(r, tag, r.configurations.back()->access, Section::kAccess);
}
void start_x_configs(Reader& r, const Tag& tag) {
  push_var_list(r, tag, r.configurations.back()->configs, Section::kConfig);
}

void program_instance(Reader& r, const Tag& tag) { add_instance(r, tag, Attr::kTypeName); }

void pou_note(Reader& r) { r.pous.back()->pou.documentation = r.take_text(); }

template <Language kLanguage>
void start_text_body(Reader& r, const Tag& tag) {
  open_body(r, tag);
  BodyFrame& frame = *r.bodies.back();
  frame.body.name = r.optional_name(tag, Attr::kName);
  frame.order = static_cast<std::int32_t>(r.integer(tag, Attr::kEvaluationOrder, 0, 1'000'000'000));
  set_language(r, tag, kLanguage);
}

void start_chart_body(Reader& r, const Tag& tag) {
  start_text_body<Language::kSfc>(r, tag);
  r.bodies.back()->body.drawn_elements = 1;
  report_chart(r, tag);
}

void start_text_content(Reader& r, const Tag& tag) {
  Body& body = r.bodies.back()->body;
  body.text_at = tag.at;
  body.text_at.kind = ElementKind::kText;
  r.begin_text();
}

constexpr Rule text_body(std::string_view variant, StartHandler start) {
  Rule rule = used_variant(State::kXMainBody, "BodyContent", variant, State::kXText, start, close_body);
  return rule;
}

constexpr Rule chart_body(std::string_view variant) {
  Rule rule = refused(State::kXMainBody, "BodyContent", kReasonSfc, start_chart_body);
  rule.variant = variant;
  rule.end = close_body;
  return rule;
}

constexpr Rule type_spec(State parent, std::string_view name, std::string_view variant, TypeSpec::Kind kind) {
  StartHandler start = nullptr;
  switch (kind) {
    case TypeSpec::Kind::kArray:
      start = type_kind<TypeSpec::Kind::kArray>;
      break;
    case TypeSpec::Kind::kEnum:
      start = type_kind<TypeSpec::Kind::kEnum>;
      break;
    case TypeSpec::Kind::kSubrange:
      start = type_kind<TypeSpec::Kind::kSubrange>;
      break;
    case TypeSpec::Kind::kReference:
      start = type_kind<TypeSpec::Kind::kReference>;
      break;
    case TypeSpec::Kind::kString:
      start = string_spec;
      break;
    default:
      break;
  }
  return used_variant(parent, name, variant, State::kXTypeSpec, start);
}

/// A specification in a declaration describes the data type itself.
void start_declared_spec(Reader& r, const Tag& tag) { push_data_type_type(r, tag); }

template <TypeSpec::Kind kKind>
void start_declared(Reader& r, const Tag& tag) {
  push_data_type_type(r, tag);
  r.types.back()->kind = kKind;
}
void start_declared_string(Reader& r, const Tag& tag) {
  push_data_type_type(r, tag);
  string_spec(r, tag);
}
/// A member brings its own list: specifications of other kinds may contain one by mistake.
void start_member(Reader& r, const Tag& tag) {
  start_struct(r, tag);
  start_variable(r, tag);
}
void end_member(Reader& r) {
  end_variable(r);
  end_var_list(r);
}

constexpr Rule declared(std::string_view variant, StartHandler start, EndHandler end = pop_type) {
  return used_variant(State::kXDataType, "UserDefinedTypeSpec", variant, State::kXTypeSpec, start, end);
}

using Kind = TypeSpec::Kind;
constexpr State kInline = State::kXTypeRef;

constexpr Rule kRules[] = {
    anchored(State::kXProject, "FileHeader", State::kLeaf, file_header),
    anchored(State::kXProject, "ContentHeader", State::kXContentHeader, content_header),
    anchored(State::kXProject, "Types", State::kXTypes),
    anchored(State::kXProject, "Instances", State::kXInstances),
    anchored(State::kXProject, "Configuration", State::kXConfiguration, start_configuration, end_configuration),
    used(State::kXProject, "AddData", State::kXAddData),
    ignored(State::kXProject, "Documentation", kReasonNote),
    ignored(State::kXContentHeader, "CoordinateInfo", kReasonLayout),
    ignored(State::kXContentHeader, "AddDataInfo", kReasonHeader),
    ignored(State::kXContentHeader, "Comment", kReasonHeader),
    ignored(State::kXContentHeader, "Documentation", kReasonNote),
    used(State::kXContentHeader, "AddData", State::kXAddData),

    used(State::kXTypes, "GlobalNamespace", State::kXNamespace),
    used(State::kXNamespace, "NamespaceDecl", State::kXNamespace),
    anchored(State::kXNamespace, "DataTypeDecl", State::kXDataType, start_data_type, end_data_type),
    anchored(State::kXNamespace, "Program", State::kXPou, start_pou_of<PouKind::kProgram>, close_pou),
    anchored(State::kXNamespace, "FunctionBlock", State::kXPou, start_pou_of<PouKind::kFunctionBlock>, close_pou),
    anchored(State::kXNamespace, "Function", State::kXPou, start_pou_of<PouKind::kFunction>, close_pou),
    refused(State::kXNamespace, "Class", kReasonOop, object_oriented),
    refused(State::kXNamespace, "Interface", kReasonOop, object_oriented),
    used(State::kXNamespace, "AddData", State::kXAddData),
    ignored(State::kXNamespace, "Documentation", kReasonNote),

    declared("", start_declared_spec),
    declared("ArrayTypeSpec", start_declared<Kind::kArray>),
    declared("EnumTypeSpec", start_declared<Kind::kEnum>),
    declared("EnumTypeWithNamedValueSpec", start_declared<Kind::kEnum>),
    declared("StructTypeSpec", start_declared<Kind::kStruct>),
    declared("SubrangeTypeSpec", start_declared<Kind::kSubrange>),
    declared("RefTypeSpec", start_declared<Kind::kReference>),
    declared("ReferenceTypeSpec", start_declared<Kind::kReference>),
    declared("StringTypeSpec", start_declared_string),
    declared("WStringTypeSpec", start_declared_string),
    used(State::kXDataType, "InitialValue", State::kXValue, push_data_type_value, pop_value),
    used(State::kXDataType, "AddData", State::kXAddData),
    ignored(State::kXDataType, "Documentation", kReasonNote),

    used(kInline, "TypeName", State::kText, start_text, type_name),
    type_spec(kInline, "InstantlyDefinedType", "", Kind::kMissing),
    type_spec(kInline, "InstantlyDefinedType", "ArrayTypeSpec", Kind::kArray),
    type_spec(kInline, "InstantlyDefinedType", "EnumTypeSpec", Kind::kEnum),
    type_spec(kInline, "InstantlyDefinedType", "SubrangeTypeSpec", Kind::kSubrange),
    type_spec(kInline, "InstantlyDefinedType", "RefTypeSpec", Kind::kReference),
    type_spec(kInline, "InstantlyDefinedType", "ReferenceTypeSpec", Kind::kReference),
    type_spec(kInline, "InstantlyDefinedType", "StringTypeSpec", Kind::kString),
    type_spec(kInline, "InstantlyDefinedType", "WStringTypeSpec", Kind::kString),

    used(State::kXTypeSpec, "BaseType", State::kXTypeRef, push_base_type, derived_base),
    used(State::kXTypeSpec, "TypeName", State::kText, start_text, type_name),
    used(State::kXTypeSpec, "DimensionSpec", State::kXDimension),
    used(State::kXTypeSpec, "Range", State::kLeaf, dimension),
    used(State::kXTypeSpec, "IndexRange", State::kLeaf, dimension),
    used(State::kXTypeSpec, "Enumerator", State::kLeaf, enum_value),
    used(State::kXTypeSpec, "Member", State::kXVariable, start_member, end_member),
    used(State::kXTypeSpec, "AddData", State::kXAddData),
    ignored(State::kXTypeSpec, "Documentation", kReasonNote),
    used(State::kXDimension, "IndexRange", State::kLeaf, dimension),

    used(State::kXValue, "SimpleValue", State::kLeaf, simple_value),
    used(State::kXValue, "ArrayValue", State::kXValues, array_value),
    used(State::kXValue, "StructValue", State::kXValues, struct_value),
    used(State::kXValues, "Value", State::kXValue, push_element_value, pop_value),

    used(State::kXPou, "ResultType", State::kXTypeRef, push_return_type, pop_type),
    used(State::kXPou, "Parameters", State::kXParameters),
    used(State::kXPou, "Vars", State::kXVarList, start_pou_list<Section::kLocal>, end_var_list),
    used(State::kXPou, "TempVars", State::kXVarList, start_pou_list<Section::kTemp>, end_var_list),
    used(State::kXPou, "ExternalVars", State::kXVarList, start_pou_list<Section::kExternal>, end_var_list),
    used(State::kXPou, "GlobalVars", State::kXVarList, start_pou_list<Section::kGlobal>, end_var_list),
    used(State::kXPou, "MainBody", State::kXMainBody),
    refused(State::kXPou, "Method", kReasonOop, object_oriented),
    refused(State::kXPou, "Extends", kReasonOop, object_oriented),
    refused(State::kXPou, "Implements", kReasonOop, object_oriented),
    anchored(State::kXPou, "Action", State::kXMainBody, start_pou_action, close_pou_action),
    refused(State::kXPou, "Transition", kReasonSfc, chart_part),
    used(State::kXPou, "AddData", State::kXAddData),
    preserved(State::kXPou, "Documentation", State::kFormatted, kReasonKept, start_text, pou_note),
    used(State::kXParameters, "InputVars", State::kXVarList, start_pou_list<Section::kInput>, end_var_list),
    used(State::kXParameters, "OutputVars", State::kXVarList, start_pou_list<Section::kOutput>, end_var_list),
    used(State::kXParameters, "InoutVars", State::kXVarList, start_pou_list<Section::kInOut>, end_var_list),
    used(State::kXParameters, "InOutVars", State::kXVarList, start_pou_list<Section::kInOut>, end_var_list),

    used(State::kXVarList, "Variable", State::kXVariable, start_variable, end_variable),
    used(State::kXVarList, "AddData", State::kXAddData),
    ignored(State::kXVarList, "Documentation", kReasonNote),
    used(State::kXAccessVars, "AccessVariable", State::kXVariable, access_variable, end_variable),
    used(State::kXConfigVars, "ConfigVariable", State::kXVariable, config_variable, end_variable),
    used(State::kXVariable, "Type", State::kXTypeRef, push_variable_type, pop_type),
    used(State::kXVariable, "InitialValue", State::kXValue, push_variable_value, pop_value),
    used(State::kXVariable, "Address", State::kLeaf, address),
    used(State::kXVariable, "AddData", State::kXAddData),
    preserved(State::kXVariable, "Documentation", State::kFormatted, kReasonKept, start_text, variable_note),

    text_body("ST", start_text_body<Language::kSt>),
    text_body("IL", start_text_body<Language::kIl>),
    chart_body("SFC"),
    ignored(State::kXMainBody, "Documentation", kReasonNote),
    used(State::kXMainBody, "AddData", State::kXAddData),
    used(State::kXText, "ST", State::kFormatted, start_text_content, end_code),
    used(State::kXText, "IL", State::kFormatted, start_text_content, end_code),
    used(State::kXText, "AddData", State::kXAddData),
    ignored(State::kXText, "Documentation", kReasonNote),

    anchored(State::kXInstances, "Configuration", State::kXConfiguration, start_configuration, end_configuration),
    anchored(State::kXConfiguration, "Resource", State::kXResource, start_resource, end_resource),
    used(State::kXConfiguration, "GlobalVars", State::kXVarList, start_globals, end_var_list),
    used(State::kXConfiguration, "AccessVars", State::kXAccessVars, start_x_access, end_var_list),
    used(State::kXConfiguration, "ConfigVars", State::kXConfigVars, start_x_configs, end_var_list),
    used(State::kXConfiguration, "AddData", State::kXAddData),
    ignored(State::kXConfiguration, "Documentation", kReasonNote),
    used(State::kXResource, "GlobalVars", State::kXVarList, start_globals, end_var_list),
    used(State::kXResource, "Task", State::kXTask, start_task, end_task),
    used(State::kXResource, "ProgramInstance", State::kXTask, program_instance),
    used(State::kXResource, "AddData", State::kXAddData),
    ignored(State::kXResource, "Documentation", kReasonNote),
    used(State::kXTask, "AddData", State::kXAddData),
    ignored(State::kXTask, "Documentation", kReasonNote),

    ignored(State::kXAddData, "Data", "vendor data", State::kXVendor),
    ignored(State::kXVendor, "*", kReasonEditor, State::kXVendor),
};

}  // namespace

std::span<const Rule> iec10_rules() { return kRules; }

}  // namespace plc::plcopen
