// Parts of a TC6 project that are elsewhere than its schema has them, where there is no doubt what they are:
// converters and people leave frames out. Each is read as in its place, with P1019.
#include "plcopen/reader_configuration.h"
#include "plcopen/reader_pou.h"
#include "plcopen/reader_types.h"

namespace plc::plcopen {

namespace {

constexpr Rule misplaced(State parent, std::string_view name, State state, std::string_view belongs,
                         StartHandler start = nullptr, EndHandler end = nullptr) {
  Rule rule = used(parent, name, state, start, end);
  rule.belongs = belongs;
  rule.reason = "misplaced: read with a warning (P1019)";
  return rule;
}

/// A body without its frame.
template <Language kLanguage>
void start_language(Reader& r, const Tag& tag) {
  open_body(r, tag);
  set_language(r, tag, kLanguage);
}

template <Language kLanguage>
void start_code(Reader& r, const Tag& tag) {
  start_language<kLanguage>(r, tag);
  begin_code(r, tag);
}

void end_code_and_body(Reader& r) {
  end_code(r);
  close_body(r);
}

constexpr Rule kRules[] = {
    misplaced(State::kProject, "dataTypes", State::kDataTypes, "types"),
    misplaced(State::kProject, "pous", State::kPous, "types"),
    misplaced(State::kProject, "pou", State::kPou, "types/pous", start_pou, close_pou),
    misplaced(State::kProject, "configurations", State::kConfigurations, "instances"),
    misplaced(State::kProject, "configuration", State::kConfiguration, "instances/configurations", start_configuration,
              end_configuration),
    misplaced(State::kProject, "globalVars", State::kVarList, "instances/configurations/configuration", start_globals,
              end_var_list),
    misplaced(State::kTypes, "dataType", State::kDataType, "dataTypes", start_data_type, end_data_type),
    misplaced(State::kTypes, "pou", State::kPou, "pous", start_pou, close_pou),
    misplaced(State::kInstances, "configuration", State::kConfiguration, "configurations", start_configuration,
              end_configuration),

    misplaced(State::kPou, "returnType", State::kType, "interface", push_return_type, pop_type),
    misplaced(State::kPou, "inputVars", State::kVarList, "interface", start_pou_list<Section::kInput>, end_var_list),
    misplaced(State::kPou, "outputVars", State::kVarList, "interface", start_pou_list<Section::kOutput>, end_var_list),
    misplaced(State::kPou, "inOutVars", State::kVarList, "interface", start_pou_list<Section::kInOut>, end_var_list),
    misplaced(State::kPou, "localVars", State::kVarList, "interface", start_pou_list<Section::kLocal>, end_var_list),
    misplaced(State::kPou, "tempVars", State::kVarList, "interface", start_pou_list<Section::kTemp>, end_var_list),
    misplaced(State::kPou, "externalVars", State::kVarList, "interface", start_pou_list<Section::kExternal>,
              end_var_list),
    misplaced(State::kPou, "LD", State::kDrawing, "body", start_language<Language::kLd>, close_body),
    misplaced(State::kPou, "FBD", State::kDrawing, "body", start_language<Language::kFbd>, close_body),
    misplaced(State::kPou, "ST", State::kFormatted, "body", start_code<Language::kSt>, end_code_and_body),
    misplaced(State::kPou, "IL", State::kFormatted, "body", start_code<Language::kIl>, end_code_and_body),
};

}  // namespace

std::span<const Rule> misplaced_rules() { return kRules; }

}  // namespace plc::plcopen
