// Inside engineering/: stored programs as JSON.
#pragma once

#include "engineering/call.h"
#include "engineering/program_store.h"

namespace plc::engineering {

extern const Record kStoredProgram;
extern const Record kFailedStart;
Json program_json(const StoredProgram& program);
Json failed_json(const FailedStart& failed);

}  // namespace plc::engineering
