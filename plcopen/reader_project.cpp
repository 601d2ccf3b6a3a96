// The frame of a project: headers, containers, texts that are skipped.
#include "plcopen/reader_state.h"

namespace plc::plcopen {

namespace {

void file_header(Reader& r, const Tag& tag) { r.project.product = tag.attributes.get(Attr::kProductName); }
void content_header(Reader& r, const Tag& tag) { r.project.name = tag.attributes.get(Attr::kName); }

constexpr Rule kRules[] = {
    used(State::kDocument, "project", State::kProject),
    used(State::kDocument, "Project", State::kXProject),

    anchored(State::kProject, "fileHeader", State::kLeaf, file_header),
    anchored(State::kProject, "contentHeader", State::kContentHeader, content_header),
    anchored(State::kProject, "types", State::kTypes),
    anchored(State::kProject, "instances", State::kInstances),
    used(State::kProject, "addData", State::kAddData),
    ignored(State::kProject, "documentation", kReasonNote),

    ignored(State::kContentHeader, "Comment", kReasonHeader),
    ignored(State::kContentHeader, "coordinateInfo", kReasonLayout),
    ignored(State::kContentHeader, "addDataInfo", kReasonHeader),
    used(State::kContentHeader, "addData", State::kAddData),

    used(State::kTypes, "dataTypes", State::kDataTypes),
    used(State::kTypes, "pous", State::kPous),

    inherited(State::kSkip, State::kSkip),
    inherited(State::kFormatted, State::kFormatted),
};

}  // namespace

std::span<const Rule> project_rules() { return kRules; }

}  // namespace plc::plcopen
