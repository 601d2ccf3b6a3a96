#include "engineering/program_json.h"

#include <nlohmann/json.hpp>

#include "log/format.h"

namespace plc::engineering {
namespace {

using namespace field;

constexpr Field kStoredFields[] = {
    text("image", "SHA-256 of the image"),
    text("project", "Name of the project that was stored with it, or empty"),
    text("by", "Who uploaded it; empty: it is what plc-run was given"),
    text("time", "When, UTC"),
};
constexpr Field kFailedFields[] = {
    record("program", kStoredProgram, "Which one"),
    text("why", "What was said about it"),
    text("time", "When, UTC"),
};

}  // namespace

constinit const Record kStoredProgram = {"StoredProgram", "A program that plc-run keeps.", kStoredFields};
constinit const Record kFailedStart = {"FailedStart", "A program that did not start.", kFailedFields};

Json program_json(const StoredProgram& program) {
  return {{"image", program.image},
          {"project", program.project},
          {"by", program.by},
          {"time", log::time_text(program.utc_ns)}};
}

Json failed_json(const FailedStart& failed) {
  return {{"program", program_json(failed.program)}, {"why", failed.why}, {"time", log::time_text(failed.utc_ns)}};
}

}  // namespace plc::engineering
