#include "plcopen/reader_types.h"

#include "core/text.h"

namespace plc::plcopen {

namespace {

TypeSpec& type(Reader& r) { return *r.types.back(); }
InitialValue& value(Reader& r) { return *r.values.back(); }

void push_type(Reader& r, const Tag& tag, TypeSpec& target) {
  target = TypeSpec{};
  target.at = tag.at;
  target.at.kind = ElementKind::kType;
  r.types.push_back(&target);
}

void named_type(Reader& r, const Tag& tag) {
  type(r).kind = TypeSpec::Kind::kNamed;
  type(r).name = tag.name;
}

void derived_type(Reader& r, const Tag& tag) {
  type(r).kind = TypeSpec::Kind::kNamed;
  type(r).name = r.required_name(tag, Attr::kName);
}

void string_type(Reader& r, const Tag& tag) {
  type(r).kind = TypeSpec::Kind::kString;
  type(r).name = tag.name.size() == 7 ? "WSTRING" : "STRING";
  type(r).length = core::trimmed(tag.attributes.get(Attr::kLength));
  type(r).length_at = r.value_place(tag, Attr::kLength);
}

constexpr std::string_view kElementary[] = {
    "BOOL",     "BYTE",    "WORD",    "DWORD",         "LWORD",       "SINT",           "INT",           "DINT",
    "LINT",     "USINT",   "UINT",    "UDINT",         "ULINT",       "REAL",           "LREAL",         "TIME",
    "DATE",     "DT",      "TOD",     "ANY",           "ANY_DERIVED", "ANY_ELEMENTARY", "ANY_MAGNITUDE", "ANY_NUM",
    "ANY_REAL", "ANY_INT", "ANY_BIT", "ANY_STRING",    "ANY_DATE",    "LTIME",          "LDATE",         "LDT",
    "LTOD",     "CHAR",    "WCHAR",   "DATE_AND_TIME", "TIME_OF_DAY", "LDATE_AND_TIME", "LTIME_OF_DAY",  "BIT"};

constexpr Rule kRules[] = {
    anchored(State::kDataTypes, "dataType", State::kDataType, start_data_type, end_data_type),
    used(State::kDataType, "baseType", State::kType, push_data_type_type, pop_type),
    used(State::kDataType, "initialValue", State::kValue, push_data_type_value, pop_value),
    used(State::kDataType, "addData", State::kAddData),
    ignored(State::kDataType, "documentation", kReasonNote),

    used(State::kType, "string", State::kLeaf, string_type),
    used(State::kType, "wstring", State::kLeaf, string_type),
    used(State::kType, "STRING", State::kLeaf, string_type),
    used(State::kType, "WSTRING", State::kLeaf, string_type),
    used(State::kType, "array", State::kArray, type_kind<TypeSpec::Kind::kArray>),
    used(State::kType, "derived", State::kLeaf, derived_type),
    used(State::kType, "enum", State::kEnum, type_kind<TypeSpec::Kind::kEnum>),
    used(State::kType, "struct", State::kStruct, start_struct, end_var_list),
    used(State::kType, "union", State::kStruct, start_union, end_var_list),
    used(State::kType, "subrangeSigned", State::kSubrange, type_kind<TypeSpec::Kind::kSubrange>),
    used(State::kType, "subrangeUnsigned", State::kSubrange, type_kind<TypeSpec::Kind::kSubrange>),
    used(State::kType, "pointer", State::kPointer, type_kind<TypeSpec::Kind::kPointer>),

    used(State::kArray, "dimension", State::kLeaf, dimension),
    used(State::kArray, "baseType", State::kType, push_base_type, pop_type),
    used(State::kEnum, "values", State::kEnumValues),
    used(State::kEnum, "baseType", State::kType, push_base_type, pop_type),
    used(State::kEnumValues, "value", State::kLeaf, enum_value),
    used(State::kSubrange, "range", State::kLeaf, dimension),
    used(State::kSubrange, "baseType", State::kType, push_base_type, pop_type),
    used(State::kPointer, "baseType", State::kType, push_base_type, pop_type),
    used(State::kStruct, "variable", State::kVariable, start_variable, end_variable),
    ignored(State::kStruct, "documentation", kReasonNote),
    used(State::kStruct, "addData", State::kAddData),

    used(State::kValue, "simpleValue", State::kLeaf, simple_value),
    used(State::kValue, "arrayValue", State::kValues, array_value),
    used(State::kValue, "structValue", State::kValues, struct_value),
    used(State::kValues, "value", State::kValue, push_element_value, pop_value),

    used(State::kVarList, "variable", State::kVariable, start_variable, end_variable),
    used(State::kVarList, "addData", State::kAddData),
    ignored(State::kVarList, "documentation", kReasonNote),
    used(State::kAccessVars, "accessVariable", State::kVariable, access_variable, end_variable),
    used(State::kAccessVars, "addData", State::kAddData),
    ignored(State::kAccessVars, "documentation", kReasonNote),
    used(State::kConfigVars, "configVariable", State::kVariable, config_variable, end_variable),
    used(State::kConfigVars, "addData", State::kAddData),
    ignored(State::kConfigVars, "documentation", kReasonNote),

    used(State::kVariable, "type", State::kType, push_variable_type, pop_type),
    used(State::kVariable, "initialValue", State::kValue, push_variable_value, pop_value),
    used(State::kVariable, "addData", State::kAddData),
    preserved(State::kVariable, "documentation", State::kFormatted, kReasonKept, start_text, variable_note),
};

}  // namespace

void push_variable_type(Reader& r, const Tag& tag) { push_type(r, tag, r.variables.back().type); }
void push_data_type_type(Reader& r, const Tag& tag) { push_type(r, tag, r.data_types.back().type); }
void push_return_type(Reader& r, const Tag& tag) { push_type(r, tag, r.pous.back()->pou.return_type); }

void push_base_type(Reader& r, const Tag& tag) {
  type(r).base = std::make_shared<TypeSpec>();
  push_type(r, tag, *type(r).base);
}

void pop_type(Reader& r) { r.types.pop_back(); }

void push_variable_value(Reader& r, const Tag& tag) {
  Variable& variable = r.variables.back();
  variable.initial = InitialValue{};
  variable.initial.at = tag.at;
  r.values.push_back(&variable.initial);
}

void push_data_type_value(Reader& r, const Tag& tag) {
  DataType& data_type = r.data_types.back();
  data_type.initial = InitialValue{};
  data_type.initial.at = tag.at;
  r.values.push_back(&data_type.initial);
}

void push_element_value(Reader& r, const Tag& tag) {
  InitialValue& element = value(r).values.emplace_back();
  element.at = tag.at;
  element.member = r.optional_name(tag, Attr::kMember);
  element.repetition = core::trimmed(tag.attributes.get(Attr::kRepetitionValue));
  element.repetition_at = r.value_place(tag, Attr::kRepetitionValue);
  r.values.push_back(&element);
}

void pop_value(Reader& r) { r.values.pop_back(); }

void simple_value(Reader& r, const Tag& tag) {
  value(r).kind = InitialValue::Kind::kSimple;
  value(r).text = core::trimmed(tag.attributes.get(Attr::kValue));
  value(r).at = r.value_place(tag, Attr::kValue);
}

void array_value(Reader& r, const Tag&) {
  value(r).kind = InitialValue::Kind::kArray;
  value(r).values.clear();
}

void struct_value(Reader& r, const Tag&) {
  value(r).kind = InitialValue::Kind::kStruct;
  value(r).values.clear();
}

void start_data_type(Reader& r, const Tag& tag) {
  DataType& data_type = r.data_types.emplace_back();
  data_type.at = tag.at;
  data_type.at.kind = ElementKind::kType;
  data_type.name = r.required_name(tag, Attr::kName);
}

void end_data_type(Reader& r) {
  parse_value_text(r.data_types.back().type, r.data_types.back().initial);
  r.note_extent(r.data_types.back().name, r.data_types.back().at);
  r.project.data_types.push_back(std::move(r.data_types.back()));
  r.data_types.pop_back();
}

void enum_value(Reader& r, const Tag& tag) {
  EnumValue& enumerator = type(r).values.emplace_back();
  enumerator.name = r.required_name(tag, Attr::kName);
  enumerator.value = core::trimmed(tag.attributes.get(Attr::kValue));
  enumerator.at = tag.at;
  enumerator.value_at = r.value_place(tag, Attr::kValue);
}

void dimension(Reader& r, const Tag& tag) {
  type(r).dimensions.push_back({std::string(core::trimmed(tag.attributes.get(Attr::kLower))),
                                std::string(core::trimmed(tag.attributes.get(Attr::kUpper))),
                                r.value_place(tag, Attr::kLower), r.value_place(tag, Attr::kUpper)});
}

void start_struct(Reader& r, const Tag&) {
  type(r).kind = TypeSpec::Kind::kStruct;
  VarListFrame& list = r.var_lists.emplace_back();
  list.out = &type(r).members;
}

void start_union(Reader& r, const Tag& tag) {
  start_struct(r, tag);
  type(r).kind = TypeSpec::Kind::kUnion;
}

void push_var_list(Reader& r, const Tag& tag, std::vector<Variable>& out, Section section) {
  VarListFrame list;
  list.out = &out;
  list.section = section;
  list.list = r.optional_name(tag, Attr::kName);
  list.constant = r.flag(tag, Attr::kConstant);
  list.retain = r.flag(tag, Attr::kRetain);
  list.nonretain = r.flag(tag, Attr::kNonretain);
  list.persistent = r.flag(tag, Attr::kPersistent);
  if (list.constant && (list.retain || list.persistent)) {
    r.report(core::Code::P4068, tag.at,
             std::string(tag.name) + " is constant and " + (list.retain ? "retain" : "persistent") +
                 ": what never changes has nothing to keep",
             "leave one of them out");
  }
  r.var_lists.push_back(std::move(list));
}

void start_globals(Reader& r, const Tag& tag) {
  std::vector<Variable>& out = !r.resources.empty()        ? r.resources.back()->resource.globals
                               : !r.configurations.empty() ? r.configurations.back()->globals
                                                           : r.outside().globals;
  push_var_list(r, tag, out, Section::kGlobal);
}

void end_var_list(Reader& r) { r.var_lists.pop_back(); }

void start_variable(Reader& r, const Tag& tag) {
  const VarListFrame& list = r.var_lists.back();
  Variable& variable = r.variables.emplace_back();
  variable.name = r.required_name(tag, Attr::kName);
  variable.section = list.section;
  variable.address = core::trimmed(tag.attributes.get(Attr::kAddress));
  variable.list = list.list;
  variable.constant = list.constant;
  variable.retain = list.retain;
  variable.nonretain = list.nonretain;
  variable.persistent = list.persistent;
  variable.at = tag.at;
  variable.at.kind = ElementKind::kVariable;
}

void access_variable(Reader& r, const Tag& tag) {
  Variable& variable = r.variables.emplace_back();
  variable.name = r.required_name(tag, Attr::kAlias);
  variable.section = Section::kAccess;
  variable.address = core::trimmed(tag.attributes.get(Attr::kInstancePathAndName));
  variable.constant = !core::iequals(core::trimmed(tag.attributes.get(Attr::kDirection)), "readWrite");
  variable.at = tag.at;
  variable.at.kind = ElementKind::kVariable;
}

void config_variable(Reader& r, const Tag& tag) {
  Variable& variable = r.variables.emplace_back();
  variable.name = r.required_name(tag, Attr::kInstancePathAndName);
  variable.section = Section::kConfig;
  variable.address = core::trimmed(tag.attributes.get(Attr::kAddress));
  variable.at = tag.at;
  variable.at.kind = ElementKind::kVariable;
}

void end_variable(Reader& r) {
  Variable& variable = r.variables.back();
  parse_value_text(variable.type, variable.initial);
  if (variable.section == Section::kGlobal && r.pous.empty()) r.note_extent(variable.name, variable.at);
  r.var_lists.back().out->push_back(std::move(r.variables.back()));
  r.variables.pop_back();
}

void start_text(Reader& r, const Tag&) { r.begin_text(); }
void drop_text(Reader& r) { static_cast<void>(r.take_text()); }
void variable_note(Reader& r) { r.variables.back().documentation = r.take_text(); }

std::span<const Rule> type_rules() {
  // Files written by hand and by converters have <bool/>; type names are case-insensitive in the language.
  static const std::vector<std::string> kLowerCase = [] {
    std::vector<std::string> all;
    for (const std::string_view name : kElementary) all.push_back(core::folded(name));
    return all;
  }();
  static const std::vector<Rule> kAll = [] {
    std::vector<Rule> all(std::begin(kRules), std::end(kRules));
    for (const std::string_view name : kElementary) all.push_back(used(State::kType, name, State::kLeaf, named_type));
    for (const std::string& name : kLowerCase) all.push_back(used(State::kType, name, State::kLeaf, named_type));
    return all;
  }();
  return kAll;
}

}  // namespace plc::plcopen
